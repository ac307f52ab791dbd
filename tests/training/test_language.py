"""What the language model learns from is laid out as asked for; it goes on where it was."""

from dataclasses import replace
from itertools import islice
from random import Random

import numpy as np
import pytest
import torch

from geotlm_lm.core.errors import UsageError
from geotlm_lm.language.decoder import stored
from geotlm_lm.language.size import PREFIX, SLOTS
from geotlm_lm.motion.belief import BELIEF_NUMBERS
from geotlm_lm.query.lines import normal, read, write
from geotlm_lm.query.phrases import restated
from geotlm_lm.query.program import filled
from geotlm_lm.query.quantities import find
from geotlm_lm.query.reader import SAY, Reader, Spelling
from geotlm_lm.training import language
from geotlm_lm.training.composed import composed
from geotlm_lm.training.grammar import corpus
from geotlm_lm.training.language import Taught, train_language, train_vocabulary
from geotlm_lm.training.language_rows import (
    MASKED,
    PAD,
    POOL,
    SENTENCE,
    Answers,
    Questions,
    Row,
    english_row,
    hidden,
    in_parts,
    laid,
    steps_from,
)
from geotlm_lm.training.truth import UNASKED
from tests.training.shared_steps import LANGUAGE, PASSAGES, random_answers

STEPS = {"english_steps": 2, "reading_steps": 3, "slots_steps": 2, "sentences_steps": 2}
CONFIG = replace(LANGUAGE, batch=8, **STEPS)
SIZE = CONFIG.size
WIDTH = 12 + BELIEF_NUMBERS


@pytest.fixture(scope="module")
def taught():
    return Taught(corpus("train")[:20], PASSAGES, random_answers(), (12, BELIEF_NUMBERS))


@pytest.fixture(scope="module", autouse=True)
def small_vocabulary():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(language, "VOCABULARY_PAIRS", 200)
        yield


@pytest.fixture(scope="module")
def spelling(small_vocabulary):
    return Spelling(*train_vocabulary(CONFIG, (), PASSAGES))


def trained(taught, folder, config=CONFIG, progress=lambda *_: None):
    return stored(train_language(config, taught, folder, progress)).state_dict()


def test_one_seed_gives_the_same_weights_also_after_an_interruption_in_any_stage(taught, tmp_path):
    shown = []

    def interrupted(what, step, _):
        stage = what.split(",")[1].strip()
        shown.append((stage, step))
        if (stage, step) in (("english", 1), ("reading", 2), ("slots", 1), ("sentences", 1)):
            raise KeyboardInterrupt

    straight = trained(taught, tmp_path / "straight")
    for _ in range(4):
        with pytest.raises(KeyboardInterrupt):
            trained(taught, tmp_path / "broken", progress=interrupted)
    resumed = trained(taught, tmp_path / "broken", progress=interrupted)
    steps = [("english", 2), ("reading", 3), ("slots", 2), ("sentences", 2)]
    assert shown == [(stage, step) for stage, of in steps for step in range(1, of + 1)]
    assert all(torch.equal(resumed[name], value) for name, value in straight.items())
    other = trained(taught, tmp_path / "other", replace(CONFIG, seed=1))
    assert not all(torch.equal(other[name], value) for name, value in straight.items())


def test_what_is_trained_is_not_trained_again_and_reads_and_speaks(taught, tmp_path):
    folder = train_language(CONFIG, taught, tmp_path)
    assert train_language(CONFIG, taught, tmp_path, pytest.fail) == folder
    reader = Reader.load(folder)
    assert reader.read("Which way is it turning?").line
    assert reader.decoder.clip_width == WIDTH


def test_a_checkpoint_of_another_configuration_is_refused(taught, tmp_path):
    def stop(*_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train_language(CONFIG, taught, tmp_path, stop)
    with pytest.raises(UsageError, match="other settings; delete it to start over"):
        train_language(replace(CONFIG, batch=16), taught, tmp_path)


def test_a_model_goes_on_from_another_with_the_words_that_both_have(taught, tmp_path, monkeypatch):
    before = train_language(CONFIG, taught, tmp_path / "before")
    words = tuple(word for word in Reader.load(before).spelling.words if word != "way")
    monkeypatch.setattr(language, "WORDS", (*words, "way", "new-word"))
    monkeypatch.setattr("geotlm_lm.query.reader.WORDS", (*words, "way", "new-word"))
    still = replace(CONFIG, english_steps=0, reading_steps=0, slots_steps=0, sentences_steps=0)
    on = replace(taught, start=before)
    after = train_language(still, on, tmp_path / "after")
    one, other = Reader.load(before), Reader.load(after)
    for word in ("way", "turn", SAY):
        first, second = (
            each.decoder.embeddings[each.spelling.id_of[word]] for each in (one, other)
        )
        np.testing.assert_allclose(first, second)
    name = "model.layers.0.mlp.up_proj.weight"
    np.testing.assert_allclose(one.decoder.stored[name], other.decoder.stored[name])


def test_what_is_wanted_are_programs_or_sentences_each_of_the_state_before(spelling):
    row = Row([5, 6, 7], [20, 21], [30, 31, 32], clip=2)
    batch = laid([row, Row([5, 6], [22, 23], clip=1)], [90, 91, 92, 93])
    clip = PREFIX + len(SLOTS)
    assert batch.ids[0, PREFIX : clip + 8].tolist() == [90, 91, 92, 93, 5, 6, 7, 20, 21, 30, 31, 32]
    assert batch.wanted[0, clip : clip + 8].tolist() == [*[UNASKED] * 5, 31, 32, UNASKED]
    assert batch.wanted[1, clip : clip + 4].tolist() == [UNASKED, 22, 23, UNASKED]
    assert (batch.wanted[:, :clip] == UNASKED).all()
    assert batch.clip.tolist() == [2, 1]


@pytest.mark.parametrize("kind", ["cpu", "cuda"])
def test_parts_hold_each_row_once_and_whole(kind):
    lengths = [3, 900, 20, 7, 400, 20, 1500]
    batch = laid([Row(list(range(1, n + 1)), [2, 3]) for n in lengths])
    parts = list(in_parts(batch, kind))
    assert sorted(int(row) for _, rows in parts for row in rows) == list(range(len(lengths)))
    assert (len(parts) > 1) == (kind == "cpu")
    for part, rows in parts:
        for k, row in enumerate(rows):
            is_text = batch.kind[row] != PAD
            for cut, whole in ((part.ids, batch.ids), (part.wanted, batch.wanted)):
                assert torch.equal(cut[k, : int(is_text.sum())], whole[row][is_text])
            assert (part.kind[k, int(is_text.sum()) :] == PAD).all()


def test_each_text_is_hidden_by_its_own_share_and_no_program_is(spelling):
    rows = [Row(list(range(20)), list(range(9)))] * 800
    is_hidden, wanted = hidden(laid(rows), 0.2, torch.Generator().manual_seed(1))
    assert not is_hidden[:, 20:].any()
    shares = is_hidden[:, :20].float().mean(dim=1)
    assert float(shares.mean()) == pytest.approx(0.2, abs=0.03)
    assert float(shares.min()) == 0
    assert float(shares.max()) > 0.3
    assert torch.equal(wanted, laid(rows).wanted)


def test_words_hidden_of_a_passage_are_asked_for_where_they_stood(spelling):
    rows = [Row(list(range(1, 21)), is_masked=True)] * 400
    batch = laid(rows)
    is_hidden, wanted = hidden(batch, 0.2, torch.Generator().manual_seed(1))
    assert float(is_hidden[:, :20].float().mean()) == pytest.approx(MASKED, abs=0.02)
    assert torch.equal(wanted != UNASKED, is_hidden)
    assert torch.equal(wanted[is_hidden], batch.ids[is_hidden])


def test_a_passage_is_guessed_at_or_goes_on(spelling):
    rng, text = Random(0), spelling.text(PASSAGES[0])
    rows = [english_row(spelling, PASSAGES[0], rng) for _ in range(40)]
    masked = [row for row in rows if row.is_masked]
    assert 10 < len(masked) < 30
    assert all(row.question == text[: len(row.question)] for row in masked)
    for row in (row for row in rows if not row.is_masked):
        assert row.sentence[0] == spelling.id_of[SAY]
        assert row.question + row.sentence[1:] == text[: len(row.question) + len(row.sentence) - 1]


@pytest.mark.slow
def test_the_same_rows_come_from_any_step_on_and_by_any_number_of_processes(spelling):
    drawing = Questions(
        spelling, corpus("train")[:20], 4, 0.25, 0.25, 0.25, PASSAGES, 2, SIZE.max_tokens, seed=5
    )

    def rows(step, workers, count, passes=1):
        steps = islice(steps_from(drawing, step, workers, passes), count)
        return [[batch.ids.tolist() for batch in batches] for batches in steps]

    plain = rows(0, 0, 3 * POOL)
    assert rows(POOL + 3, 0, POOL) == plain[POOL + 3 : 2 * POOL + 3]
    assert rows(0, 2, 3 * POOL) == plain
    assert rows(0, 0, 2 * POOL, passes=2) == [*plain[:POOL], *plain[:POOL]]


def test_programs_composed_at_random_say_in_words_what_they_mean():
    for pair in islice(composed(Random(1)), 200):
        program = read(pair.query)
        assert write(normal(program)) == pair.query
        numbers = [each.quantity for each in find(pair.text)]
        assert restated(filled(program, numbers)) in pair.text


def test_answers_ask_for_sentences_and_slots_and_for_no_program(taught, spelling):
    for batch in Answers(taught.sentences, spelling).pool(np.random.default_rng(0), 3):
        clip = PREFIX + len(SLOTS)
        true_words = taught.sentences.words[batch.clip.numpy()]
        for place, words in enumerate(SLOTS.values()):
            ids = [spelling.id_of[word] for word in words]
            wanted = [UNASKED if k == UNASKED else ids[k] for k in true_words[:, place]]
            assert batch.wanted[:, PREFIX + place].tolist() == wanted
        is_asked = batch.wanted[:, clip:] != UNASKED
        assert (batch.kind[:, clip:][is_asked] == SENTENCE).all()
        assert not is_asked[:, -1].any()
        wanted, following = batch.wanted[:, clip:-1], batch.ids[:, clip + 1 :]
        assert torch.equal(wanted[is_asked[:, :-1]], following[is_asked[:, :-1]])


def test_what_a_question_means_outlasts_learning_to_feel_and_to_speak(taught, tmp_path):
    until = {"reading": 0, "slots": 0, "sentences": 0}
    kept = {}
    for name in until:
        until[name] = 2
        steps = {f"{stage}_steps": count for stage, count in until.items()}
        folder = train_language(replace(CONFIG, **steps), taught, tmp_path / name)
        kept[name] = Reader.load(folder).decoder

    def differ(one, other):
        first, second = kept[one].stored, kept[other].stored
        return {name for name in first if not np.array_equal(first[name], second[name])}

    assert differ("reading", "slots") == {"model.embed_tokens.weight"}
    changed = kept["reading"].embeddings != kept["slots"].embeddings
    slots = changed.any(axis=1).nonzero()[0]
    assert len(slots) == len(SLOTS)
    above = differ("slots", "sentences")
    assert above
    assert all(name.startswith("model.layers.1.") for name in above)
    one, other = kept["slots"].projector, kept["sentences"].projector
    same = {name for name, value in one.items() if np.array_equal(value, other[name])}
    assert same == {"mean", "scale"}
