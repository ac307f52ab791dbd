import json

import numpy as np
import pytest
import torch

from geotlm_lm.core.errors import IncompatibleBundle
from geotlm_lm.language.generation import Speaker
from geotlm_lm.language.prompt import MAX_ANSWER_TOKENS
from geotlm_lm.language.slots import SLOTS

QUESTIONS = [
    "which way?",
    "Is the cap turning clockwise, or is it the 12th thing?",
    "A) cw B) ccw C) left, which of the three is it?",
]
OPTIONS = ["Left, in the camera image.", "It is pressing in.", "A) clockwise"]


def likeliest_ids(speaker, fused_token, question):
    """The likeliest token each time, by plain reading of all before it."""
    model, prompt = speaker.model, speaker.prompts.prompt(question)
    ids, prefix = list(prompt), model.projector(fused_token[None])
    while len(ids) < len(prompt) + MAX_ANSWER_TOKENS and ids[-1] != speaker.prompts.eos_id:
        embedded = model.embed(torch.tensor([ids]), prefix)
        hidden = model.decoder(embedded)
        ids.append(int(model.logits(hidden[0, -1]).argmax()))
    return ids[len(prompt) :]


def test_generation_takes_the_likeliest_token_each_time(speaker, fused_tokens):
    expected = speaker.prompts.decode(likeliest_ids(speaker, fused_tokens[0], QUESTIONS[0]))
    assert speaker.generate(fused_tokens[:1], QUESTIONS[:1]) == [expected]


def test_a_score_is_the_log_likelihood_of_the_whole_answer(speaker, fused_tokens):
    model, prompts = speaker.model, speaker.prompts
    prompt = prompts.prompt(QUESTIONS[1])
    expected = []
    for option in OPTIONS:
        answer = prompts.answer(option)
        ids = torch.tensor([prompt + answer])
        embedded = model.embed(ids, model.projector(fused_tokens[:1]))
        hidden = model.decoder(embedded)
        steps = model.logits(hidden)[0].log_softmax(-1)[len(prompt) - 1 : -1]
        expected.append(float(steps[range(len(answer)), answer].sum().detach()))
    scores = speaker.score(fused_tokens[0], QUESTIONS[1], OPTIONS)
    np.testing.assert_allclose(scores, expected, rtol=1e-4)


def test_saved_and_loaded_it_says_and_scores_the_same(speaker, fused_tokens, tmp_path):
    speaker.save(tmp_path)
    loaded = Speaker.load(tmp_path)
    assert loaded.generate(fused_tokens[:3], QUESTIONS) == speaker.generate(
        fused_tokens[:3], QUESTIONS
    )
    one, two = (s.score(fused_tokens[0], QUESTIONS[0], OPTIONS) for s in (speaker, loaded))
    np.testing.assert_array_equal(one, two)
    felt, felt_again = (s.feel(fused_tokens) for s in (speaker, loaded))
    assert all(torch.equal(felt_again[slot], shares) for slot, shares in felt.items())


def test_the_words_that_may_fill_a_slot_exclude_each_other(speaker, fused_tokens):
    felt = speaker.feel(fused_tokens)
    assert {slot: tuple(shares.shape) for slot, shares in felt.items()} == {
        slot: (len(fused_tokens), len(words)) for slot, words in SLOTS.items()
    }
    for shares in felt.values():
        torch.testing.assert_close(shares.exp().sum(dim=1), torch.ones(len(fused_tokens)))
        assert shares.std(dim=0).max() > 0.01  # another clip feels otherwise


def test_what_is_felt_of_a_clip_depends_on_no_other_clip_and_on_no_question(speaker, fused_tokens):
    together = speaker.feel(fused_tokens[:5])
    speaker.generate(fused_tokens[:2], QUESTIONS[:2])
    alone = speaker.feel(fused_tokens[3:4])
    for slot, shares in alone.items():
        torch.testing.assert_close(together[slot][3:4], shares, atol=1e-5, rtol=1e-5)
    slots = speaker.prompts.slot_prompt[-len(SLOTS) :]
    assert speaker.prompts.slot_prompt[: -len(SLOTS)] == [speaker.prompts.tactile_id] * 3
    assert not set(slots) & set(speaker.prompts.prompt("<turn> <slide> <press> or <contact>?"))


def test_each_slot_is_what_plain_reading_of_its_place_gives(speaker, fused_tokens):
    model, prompts = speaker.model, speaker.prompts
    ids = torch.tensor([prompts.slot_prompt])
    with torch.no_grad():
        embedded = model.embed(ids, model.projector(fused_tokens[:1]))
        hidden = model.decoder(embedded)
        logits = model.logits(hidden)[0]
    felt = speaker.feel(fused_tokens[:1])
    for place, (slot, words) in enumerate(prompts.slot_words.items(), start=ids.shape[1] - 4):
        torch.testing.assert_close(felt[slot][0], logits[place, words].log_softmax(-1))


def test_a_processor_of_another_model_is_refused_in_one_sentence(speaker, tmp_path):
    speaker.save(tmp_path)
    path = tmp_path / "processor_config.json"
    stored = json.loads(path.read_text())
    path.write_text(json.dumps(stored | {"num_tactile_tokens": -1}))
    with pytest.raises(IncompatibleBundle, match="-1 tactile placeholders, the model reads"):
        Speaker.load(tmp_path)


@pytest.mark.parametrize(
    ("token", "said"),
    [
        (torch.full((1, 24), float("nan")), "not finite"),
        (torch.zeros(1, 23), r"shape \(1, 23\), expected \(1, 24\)"),
    ],
)
def test_what_is_no_token_of_the_model_is_refused(speaker, token, said):
    with pytest.raises(ValueError, match=said):
        speaker.generate(token, ["which way?"])
    with pytest.raises(ValueError, match=said):
        speaker.feel(token)


def in_config(**changes):
    """Return what changes the sizes of the language model in a config.json."""

    def change(stored):
        config = json.loads(stored)
        config["text_config"] |= changes
        return json.dumps(config)

    return change


DAMAGE = {
    "a list for a config": ("config.json", lambda _: "[]", "written in language-model format None"),
    "no heads": ("config.json", in_config(num_attention_heads=0), "makes no 0 heads"),
    "no sizes": ("config.json", lambda _: '{"format": 1, "text_config": []}', "do not belong"),
    "no JSON": ("tokenizer.json", lambda _: "not json", "is missing or broken"),
    "a broken template": ("chat_template.jinja", lambda _: "{% if %}", "is missing or broken"),
    "a failing template": ("chat_template.jinja", lambda _: "{{ 1 / 0 }}", "division by zero"),
    "no clip": ("chat_template.jinja", lambda _: "which way?", "does not lay out one <tactile>"),
}


@pytest.mark.parametrize("case", DAMAGE)
def test_a_damaged_folder_is_refused_in_one_sentence(speaker, tmp_path, case):
    name, damage, said = DAMAGE[case]
    speaker.save(tmp_path)
    (tmp_path / name).write_text(damage((tmp_path / name).read_text()))
    with pytest.raises(IncompatibleBundle) as caught:
        Speaker.load(tmp_path)
    assert str(caught.value).startswith(f"{tmp_path}: ")
    assert said in str(caught.value)
    assert "download the model again" in str(caught.value)
    with pytest.raises(IncompatibleBundle, match="save or download the model again"):
        Speaker.load(tmp_path / "absent")
