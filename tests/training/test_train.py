"""The whole path from nothing to a bundle, at a size at which it learns nothing."""

import json
import re
import shutil
from dataclasses import replace
from functools import partial

import pytest
import torch

from geotlm_lm.answering import Answerer
from geotlm_lm.checkpoint import load_bundle
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import ROTATIONS, SLIDES
from geotlm_lm.language.size import SLOTS, LanguageSize
from geotlm_lm.query.program import Program
from geotlm_lm.simulation.gels import HELD_OUT_GELS, TRAINING_GELS
from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS, TRAINING_OBJECTS
from geotlm_lm.simulation.touch import Touch, simulate_touch
from geotlm_lm.training import calibration, config, english, examples, language, train
from geotlm_lm.training.config import example_sets
from geotlm_lm.training.examples import read_examples
from geotlm_lm.training.grammar import corpus
from geotlm_lm.training.labelled import labelled
from geotlm_lm.training.language import LanguageTraining
from tests.training.shared_steps import PASSAGES

pytestmark = pytest.mark.slow

TINY = replace(
    config.SMOKE,
    name="tiny",
    pretraining_clips=20,
    head_clips=20,
    validation_clips=20,
    test_clips=20,
    backbone_width=8,
    backbone_depth=1,
    pretraining_draws=8,
    pretraining_batch=4,
    geometry_epochs=2,
    english_steps=2,
    reading_steps=2,
    slots_steps=2,
    sentences_steps=2,
    answer_clips=3,
    language_batch=4,
)
SMALL = LanguageSize(width=16, layers=1, heads=2, mlp=16, speaking=1)
LANGUAGE = {"size": SMALL, "vocabulary": 300, "dropout": 0}
"""Byte pairs are left apart by chance, which no seed rules."""


@pytest.fixture(scope="module", autouse=True)
def _tiny():
    threads = torch.get_num_threads()
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(config.PRESETS, "tiny", TINY)
        patch.setattr(examples, "CHUNK_CLIPS", 20)
        patch.setattr(train, "LanguageTraining", partial(LanguageTraining, **LANGUAGE))
        patch.setattr(train, "corpus", lambda split: corpus(split)[:20])
        # A model that has learned nothing writes the longest programs: most of a run was reading.
        patch.setattr(train, "labelled", lambda name: labelled(name)[:20])
        patch.setattr(language, "VOCABULARY_PAIRS", 200)
        patch.setattr(english, "fetch", lambda folder, progress: folder)
        patch.setattr(english, "passages", lambda path: PASSAGES)
        yield
    torch.set_num_threads(threads)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    out = tmp_path_factory.mktemp("run")
    assert train.train("tiny", out, seed=3, workers=1) == out / "bundle"
    return out


def test_the_folder_is_a_bundle_that_answers(finished):
    bundle = load_bundle(finished / "bundle")
    encoded = Answerer(bundle).encode(simulate_touch(Touch(twist_deg=12.0)).clip)
    assert set(encoded.prefix.slots) == set(SLOTS)
    assert isinstance(bundle.speaker.sentence(encoded.prefix, "Which way?", "way all", ""), str)
    written = {path.name for path in (finished / "bundle" / "language").iterdir()}
    assert written == {
        "config.json",
        "model.safetensors",
        "projector.safetensors",
        "spelling.json",
        "tokenizer.json",
    }
    assert isinstance(bundle.reader.read("Did it turn 20 degrees?").program, Program)
    assert bundle.calibration.felt_temperature > 0
    assert set(bundle.provenance["dgr_validation_accuracy"]) == {"paper", "grounded"}


def test_the_card_tells_the_scores_and_the_command_that_made_them(finished):
    about = json.loads((finished / "bundle" / "scores.json").read_text())
    scores = about["numbers"]
    assert scores["clips"] == 20
    seen = read_examples(finished / "examples", example_sets(TINY)["test"]).labels
    motions = [label.motion for label in seen if label.is_readable]
    assert scores["rotation"]["clips"] == sum(motion in ROTATIONS for motion in motions)
    assert scores["sliding"]["clips"] == sum(motion in SLIDES for motion in motions)
    assert scores["unreadable_clips"] == 20 - len(motions)
    assert set(scores["felt"]) == set(scores["felt by the fused token alone"]) == set(SLOTS)
    card = (finished / "bundle" / "README.md").read_text()
    command = "geotlm-lm train --preset tiny --seed 3 --workers 1 --out RUN_FOLDER"
    assert f"`{command}`" in card
    assert f"| rotation | {scores['rotation']['clips']} |" in card
    assert f"| turn | {scores['mixed']['turn way, number']} |" in card
    assert set(scores["gels"]["left out"]) <= {"all", *HELD_OUT_GELS}
    assert set(scores["gels"]["in training"]) <= {"all", *TRAINING_GELS}
    assert "| left out | all |" in card


def test_an_interrupted_run_is_continued_to_the_same_bytes(finished, tmp_path, monkeypatch):
    shutil.copytree(finished / "examples", tmp_path / "examples")
    take_step, taken = language._Stage._step, []

    def interrupted(*arguments):
        if taken:
            raise KeyboardInterrupt
        taken.append(1)
        return take_step(*arguments)

    with monkeypatch.context() as patch:
        patch.setattr(language._Stage, "_step", interrupted)
        with pytest.raises(KeyboardInterrupt):
            train.train("tiny", tmp_path, seed=3, workers=1)
    assert not (tmp_path / "bundle").exists()
    before = float((tmp_path / "seconds.txt").read_text())
    assert before > 0
    train.train("tiny", tmp_path, seed=3, workers=1)
    assert float((tmp_path / "seconds.txt").read_text()) > before
    compared = 0
    for path in (finished / "bundle").rglob("*"):
        if path.is_file() and path.name != "scores.json":
            again = tmp_path / "bundle" / path.relative_to(finished / "bundle")
            # The card alone tells how long it took, which a busy machine decides.
            once, twice = (
                re.sub(rb"\d+ min on", b"min on", one.read_bytes()) for one in (path, again)
            )
            assert twice == once, path.name
            compared += 1
    assert compared > 5
    first, second = (
        json.loads((out / "bundle" / "scores.json").read_text()) for out in (finished, tmp_path)
    )
    assert first["numbers"] == second["numbers"]


def test_perception_is_taken_from_a_bundle_as_it_is(finished, tmp_path, monkeypatch):
    for name in ("pretrain", "train_geometry", "train_motion"):
        monkeypatch.delattr(train, name)
    train.train("tiny", tmp_path, seed=3, workers=1, start=finished / "bundle")
    before, after = (folder / "bundle" for folder in (finished, tmp_path))
    name = "perception.safetensors"
    assert (after / name).read_bytes() == (before / name).read_bytes()
    assert "--start bundle --stage language" in load_bundle(after).provenance["command"]


def test_what_reads_and_feels_is_taken_from_a_bundle_that_learns_to_speak(finished, tmp_path):
    given = finished / "bundle"
    train.train("tiny", tmp_path, seed=3, workers=1, start=given, stage="sentences")
    before, after = (load_bundle(each).reader.decoder for each in (given, tmp_path / "bundle"))
    changed = {name for name, x in before.stored.items() if (x != after.stored[name]).any()}
    last = before.size.layers
    assert changed
    assert all(name.startswith(f"model.layers.{last}.") for name in changed)


def test_what_reads_goes_on_learning_and_is_the_best_mean_with_what_it_was(
    finished, tmp_path, monkeypatch
):
    monkeypatch.setattr(language, "labelled", lambda name: labelled(name)[:1])
    monkeypatch.setattr(calibration, "SHARES", (0.5,))
    given = finished / "bundle"
    train.train("tiny", tmp_path, seed=3, workers=1, start=given, stage="reading")
    assert (
        "--start bundle --stage reading" in load_bundle(tmp_path / "bundle").provenance["command"]
    )
    share = json.loads((tmp_path / "language_share.json").read_text())
    assert share["share"] == 0.5
    assert set(share["read"]) == {"0.5"}
    learned = torch.load(tmp_path / "language_reading.pt", weights_only=False)["model"]
    name = "model.layers.0.mlp.up_proj.weight"
    before, after = (load_bundle(each).reader.decoder for each in (given, tmp_path / "bundle"))
    mean = (before.stored[name] + learned[f"llama.{name}"].numpy()) / 2
    assert (after.stored[name] != before.stored[name]).any()
    assert after.stored[name] == pytest.approx(mean, abs=1e-3)


def test_a_stage_of_nothing_is_refused(tmp_path):
    with pytest.raises(UsageError, match="--stage slots goes on from a bundle; give one by"):
        train.train("tiny", tmp_path, seed=3, workers=1, stage="slots")


def test_an_unknown_stage_is_refused(tmp_path):
    with pytest.raises(UsageError, match="no stage 'end'; choose one of language, reading, slots"):
        train.train("tiny", tmp_path, seed=3, workers=1, stage="end")


def test_another_seed_in_the_same_folder_is_refused(finished):
    with pytest.raises(UsageError) as caught:
        train.train("tiny", finished, seed=4, workers=1)
    assert str(caught.value) == (
        f"{finished} holds a run of another preset, seed or version of this program; give an empty "
        f"folder, or continue the run as it began."
    )


def test_no_object_is_in_two_of_training_validation_and_test():
    sets = example_sets(TINY)
    trained, kept, unseen = (set(sets[s].objects) for s in ("heads", "validation", "test"))
    assert sets["pretraining"].objects == sets["heads"].objects
    assert sets["unseen gels"].objects == sets["validation"].objects
    seen = {gel for name in sets if name != "unseen gels" for gel in sets[name].gels or ()}
    assert seen == set(TRAINING_GELS)
    assert not seen & set(sets["unseen gels"].gels)
    assert trained | kept == set(TRAINING_OBJECTS)
    assert unseen == set(EVERYDAY_OBJECTS)
    assert not trained & kept
    assert not (trained | kept) & unseen
