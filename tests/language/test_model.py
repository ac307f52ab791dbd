import pytest
import torch

from geotlm_lm.language.generation import Speaker
from geotlm_lm.language.prompt import MAX_ANSWER_TOKENS

model_module = pytest.importorskip("geotlm_lm.language.model")
pytest.importorskip("geotlm_lm.language.processor")
from transformers import AutoModelForImageTextToText, AutoProcessor  # noqa: E402

QUESTIONS = ["which way?", "Is the <tactile> cap turning clockwise, or is it the 12th thing?"]


@pytest.fixture(scope="module")
def folder(speaker, tmp_path_factory):
    path = tmp_path_factory.mktemp("lm")
    speaker.save(path)
    return path


@pytest.fixture(scope="module")
def model(folder):
    return AutoModelForImageTextToText.from_pretrained(folder).eval()


@pytest.fixture(scope="module")
def processor(folder):
    return AutoProcessor.from_pretrained(folder)


def test_the_processor_writes_the_same_ids(speaker, processor):
    inputs = processor(QUESTIONS)
    rows = [
        ids[mask.bool()].tolist()
        for ids, mask in zip(inputs["input_ids"], inputs["attention_mask"], strict=True)
    ]
    assert rows == [speaker.prompts.prompt(question) for question in QUESTIONS]


def test_both_decoders_give_the_same_logits(speaker, model, processor, fused_tokens):
    inputs = processor(QUESTIONS[1], fused_tokens[:1])
    with torch.no_grad():
        theirs = model(**inputs).logits
        ids = inputs["input_ids"]
        embedded = speaker.model.embed(ids, speaker.model.projector(fused_tokens[:1]))
        hidden = speaker.model.decoder(embedded)
        ours = speaker.model.logits(hidden)
    # Measured difference 2e-6 at logits of order 10: summation order.
    torch.testing.assert_close(ours, theirs, rtol=1e-4, atol=1e-4)


def test_both_generate_the_same_words(speaker, model, processor, fused_tokens):
    inputs = processor(QUESTIONS, fused_tokens[:2])
    written = model.generate(**inputs, max_new_tokens=MAX_ANSWER_TOKENS)[
        :, inputs["input_ids"].shape[1] :
    ]
    words = [speaker.prompts.decode(row.tolist()) for row in written]
    assert words == speaker.generate(fused_tokens[:2], QUESTIONS)


def test_saved_and_loaded_logits_are_identical(speaker, model, processor, fused_tokens, tmp_path):
    model.save_pretrained(tmp_path)
    processor.save_pretrained(tmp_path)
    again = AutoModelForImageTextToText.from_pretrained(tmp_path).eval()
    inputs = processor(QUESTIONS, fused_tokens[:2])
    with torch.no_grad():
        assert torch.equal(again(**inputs).logits, model(**inputs).logits)
    read_back = Speaker.load(tmp_path)
    assert read_back.generate(fused_tokens[:2], QUESTIONS) == speaker.generate(
        fused_tokens[:2], QUESTIONS
    )
