"""The same weights give the same numbers in transformers and in NumPy, whatever may be seen."""

import json
from copy import copy
from dataclasses import replace

import numpy as np
import pytest
import torch
from transformers import LlamaForCausalLM

from geotlm_lm.language.decoder import fresh, served, stored, with_speaking
from geotlm_lm.language.sequence import log_softmax
from geotlm_lm.language.size import PREFIX, SLOTS, LanguageSize
from geotlm_lm.language.tokenizer import byte_pairs
from geotlm_lm.query.reader import SLOT_TOKENS, Reader, Spelling
from geotlm_lm.query.speaker import Speaker
from geotlm_lm.training.language_rows import Row, laid, positions, sight

SIZE = LanguageSize(width=32, layers=2, heads=2, mlp=48, speaking=1)
WIDTHS = 12, 6
QUESTION, LINE = "Does it turn by more than 12 degrees?", "> amount turn #1"
SAID = "Yes: it turns clockwise, about 14 degrees."


@pytest.fixture(scope="module")
def spelling():
    texts = [QUESTION.lower(), SAID.lower(), "which way is it turning?"] * 4
    return Spelling(byte_pairs(texts, 320))


@pytest.fixture(scope="module")
def model(spelling):
    """Embeddings are widened so that one text differs from another."""
    made = fresh(SIZE, spelling.size, WIDTHS, torch.Generator().manual_seed(0)).eval()
    made.projector.standardise_by(torch.randn(9, 18, generator=torch.Generator().manual_seed(1)))
    with torch.no_grad():
        made.embed_weight().mul_(10)
    for weights in made.parameters():  # as they are stored
        weights.data = weights.data.half().float()
    for name, numbers in made.projector.named_buffers():
        setattr(made.projector, name, numbers.half().float())
    return made


@pytest.fixture(scope="module")
def decoder(model):
    return served(model)


@pytest.fixture(scope="module")
def row(spelling):
    ids = spelling.question(QUESTION).ids
    return Row(ids, spelling.query(LINE.split()), spelling.sentence(SAID), clip=0)


def numbers_of(seed):
    return np.random.default_rng(seed).standard_normal(18).astype(np.float32)


def states_of(model, spelling, row, numbers=None, is_spoken=False):
    """Hidden states (s, width) of a row as training has it."""
    batch = laid([row], [spelling.id_of[token] for token in SLOT_TOKENS])
    with torch.no_grad():
        embedded = model.embed(batch.ids)
        if numbers is not None:
            prefix = model.projector(torch.from_numpy(numbers)[None])
            embedded = torch.cat([prefix, embedded[:, PREFIX:]], dim=1)
        places = sight(batch.kind), positions(batch.kind)
        states = model.states(embedded, *places)[is_spoken][0]
    return states[: int((batch.kind[0] > 0).sum())]


def test_a_question_and_its_program_are_the_same_with_any_clip_and_with_none(model, spelling, row):
    text = len(row.question) + len(row.program)
    alone = states_of(model, spelling, Row(row.question, row.program))
    first, second = (states_of(model, spelling, row, numbers_of(seed)) for seed in (1, 2))
    start = PREFIX + len(SLOTS)
    asked = slice(start, start + text)
    torch.testing.assert_close(first[asked], second[asked], atol=0, rtol=0)
    torch.testing.assert_close(first[asked], alone, atol=1e-5, rtol=1e-5)
    assert not torch.allclose(first[PREFIX:start], second[PREFIX:start], atol=0.01)
    assert not torch.allclose(first[start + text :], second[start + text :], atol=0.01)


def test_slots_see_the_clip_alone(model, spelling, row):
    other = Row(row.question[::-1], row.program, row.sentence, clip=0)
    one, two = (states_of(model, spelling, each, numbers_of(1)) for each in (row, other))
    clip = PREFIX + len(SLOTS)
    torch.testing.assert_close(one[:clip], two[:clip], atol=0, rtol=0)
    assert not torch.allclose(one[clip:], two[clip:], atol=0.01)


def test_one_text_in_numpy_has_the_states_of_transformers(model, decoder, spelling, row):
    wanted = states_of(model, spelling, Row(row.question, row.program)).numpy()
    cache, count = decoder.started(200), len(row.question)
    embedded = decoder.embeddings[row.question]
    states = [decoder.read(embedded, cache, np.ones((count, count), bool))]
    states += [decoder.read(decoder.embeddings[[each]], cache) for each in row.program]
    np.testing.assert_allclose(np.concatenate(states), wanted, rtol=1e-4, atol=1e-4)
    logits = model.logits(torch.from_numpy(wanted)).log_softmax(-1).detach()
    found = log_softmax(decoder.logits(np.concatenate(states)))
    np.testing.assert_allclose(found, logits, rtol=1e-3, atol=1e-3)


def test_slots_and_sentences_in_numpy_are_those_of_transformers(model, decoder, spelling, row):
    numbers, speaker = numbers_of(1), Speaker(decoder, spelling)
    states = states_of(model, spelling, row, numbers)
    logits = model.logits(states).detach()
    felt = speaker.prefix(numbers)
    for place, (slot, words) in enumerate(SLOTS.items(), PREFIX):
        among = [spelling.id_of[word] for word in words]
        wanted = logits[place, among].log_softmax(-1)
        np.testing.assert_allclose(felt.slots[slot], wanted, rtol=1e-3, atol=1e-3)
    asked = [*row.question, *row.program]
    spoken, _ = speaker._read(felt, asked, row.sentence)
    wanted = states_of(model, spelling, row, numbers, is_spoken=True)[PREFIX + len(SLOTS) :]
    np.testing.assert_allclose(spoken, wanted, rtol=1e-3, atol=1e-3)
    assert not np.allclose(spoken, states[PREFIX + len(SLOTS) :], atol=0.01)
    said = speaker.sentence(felt, QUESTION, LINE, "14")
    written, longest = row._replace(sentence=row.sentence[:1]), 6
    for _ in range(longest):  # as transformers goes on, word by word
        state = states_of(model, spelling, written, numbers, is_spoken=True)[-1]
        written = written._replace(sentence=[*written.sentence, int(model.logits(state).argmax())])
    assert said.startswith(spelling.sentence_of(written.sentence[1:], "14"))


def test_a_sentence_is_the_model_s_own_where_it_says_it_word_for_word(decoder, spelling):
    speaker = Speaker(decoder, spelling)
    felt = speaker.prefix(numbers_of(1))
    assert not speaker.says(felt, QUESTION, LINE, SAID)
    ids = spelling.sentence(SAID)
    wide = copy(decoder)
    wide.logits = lambda hidden: np.eye(spelling.size, dtype=np.float32)[ids[-len(hidden) :]]
    assert Speaker(wide, spelling).says(felt, QUESTION, LINE, SAID)
    assert Speaker(wide, spelling).says(felt, QUESTION, LINE, SAID.replace("14", "15"))
    assert not Speaker(wide, spelling).says(felt, QUESTION, LINE, SAID.replace("Yes", "No"))


def test_what_is_no_clip_is_refused(decoder, spelling):
    speaker = Speaker(decoder, spelling)
    for numbers in (np.zeros(5), np.full(18, np.nan)):
        with pytest.raises(ValueError, match="all finite"):
            speaker.prefix(numbers)


def test_a_text_is_read_on_from_where_it_was_cut(decoder, row):
    x = decoder.embeddings[row.question]
    whole = decoder.read(x, decoder.started(len(x)))
    cache = decoder.started(len(x))
    decoder.read(x[:5], cache)
    decoder.read(x[:3], cache)
    cache.length = 5
    rest = [decoder.read(one[None], cache)[0] for one in x[5:-2]]
    found = np.concatenate([rest, decoder.read(x[-2:], cache)])
    np.testing.assert_allclose(found, whole[5:], rtol=1e-5, atol=1e-5)


def test_transformers_reads_the_folder_and_so_does_what_goes_on_from_it(
    model, decoder, spelling, tmp_path
):
    Reader(decoder, spelling, (1.0, 0.0)).save(tmp_path)
    plain = LlamaForCausalLM.from_pretrained(tmp_path, dtype=torch.float32)
    again = stored(tmp_path)
    ids = torch.tensor([spelling.question(QUESTION).ids])
    with torch.no_grad():
        wanted = model.llama(input_ids=ids).logits
        torch.testing.assert_close(plain(input_ids=ids).logits, wanted, rtol=1e-4, atol=1e-4)
        torch.testing.assert_close(again.llama(input_ids=ids).logits, wanted, rtol=1e-4, atol=1e-4)
        numbers = torch.from_numpy(numbers_of(3))[None]
        torch.testing.assert_close(again.projector(numbers), model.projector(numbers))
    assert json.loads((tmp_path / "config.json").read_text())["model_type"] == "llama"


def test_layers_that_speak_leave_what_is_read_and_felt_as_it_was(model, spelling, row):
    grown = with_speaking(model, 3, torch.Generator().manual_seed(5))
    assert grown.size == replace(SIZE, speaking=3)
    before, after = (states_of(each, spelling, row, numbers_of(1)) for each in (model, grown))
    torch.testing.assert_close(after, before, atol=0, rtol=0)
    assert len(grown.speaking_parameters()) == 3 * 9


def test_standardised_training_clips_have_unit_spread(model):
    clips = torch.randn(50, 18, generator=torch.Generator().manual_seed(4)) * 3 + 1
    projector = type(model.projector)(*WIDTHS, SIZE.width)
    projector.standardise_by(clips)
    plain = (clips - projector.mean) / projector.scale
    torch.testing.assert_close(plain.mean(0), torch.zeros(18), atol=1e-5, rtol=0)
    torch.testing.assert_close(plain.std(0, correction=0), torch.ones(18))
