"""The path from an encoder's file to a model that answers, at a size at which it learns nothing."""

import json
from functools import partial

import numpy as np
import pytest
import torch

from geotlm_lm.answering import Answerer
from geotlm_lm.backbone.released import ReleasedEncoder, load_encoder
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UsageError
from geotlm_lm.simulation.indenters import TRAINING_OBJECTS
from geotlm_lm.training import config, train
from geotlm_lm.training.config import HeadsPreset
from geotlm_lm.training.examples import ExampleSet
from geotlm_lm.training.heads import BATCH, encode_examples, train_heads
from geotlm_lm.training.language import LanguageTraining
from tests.backbone.small_files import write_small

pytestmark = pytest.mark.slow

TINY = HeadsPreset(
    name="tiny",
    head_clips=12,
    validation_clips=6,
    geometry_epochs=2,
    answer_clips=3,
    slots_steps=2,
    sentences_steps=2,
    language_batch=8,
)
WANTED = ExampleSet("check", 2 * BATCH + 3, TRAINING_OBJECTS[:3])


@pytest.fixture(scope="module", autouse=True)
def _tiny():
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(config.HEADS_PRESETS, "tiny", TINY)
        # Which byte pairs are left apart no seed governs.
        patch.setattr(train, "LanguageTraining", partial(LanguageTraining, dropout=0))
        yield


@pytest.fixture(scope="module")
def anytouch2(tmp_path_factory):
    path = write_small("anytouch2", tmp_path_factory.mktemp("anytouch2"))
    return load_encoder(path, heads=2)


@pytest.fixture(scope="module")
def finished(anytouch2, tmp_path_factory):
    out = tmp_path_factory.mktemp("run")
    return out, train_heads(anytouch2, "tiny", out, seed=3)


def recording(size=(240, 320)):
    frames = np.random.default_rng(0).integers(95, 115, (4, *size, 3)).astype(np.uint8)
    return Clip(frames, background=np.full((*size, 3), 105, np.uint8))


def answers(bundle):
    answerer = Answerer(bundle)
    return answerer.ask(answerer.encode(recording()), "Which way is it turning?")


def test_a_model_that_sees_through_a_released_encoder_answers(anytouch2, finished):
    _, bundle = finished
    answer = answers(bundle)
    assert answer.text
    assert set(answer.evidence["regions"]) >= {"upper", "left", "global"}
    assert bundle.provenance["digest"] == anytouch2.digest()
    assert bundle.provenance["preset"]["head_clips"] == 12


@pytest.mark.parametrize("name", ["unit", "t3"])
def test_widths_that_differ_and_grids_without_a_view_answer_too(name, tmp_path):
    encoder = load_encoder(write_small(name, tmp_path), heads=2)
    bundle = train_heads(encoder, "tiny", tmp_path / "run", seed=0)
    answer = answers(bundle)
    assert bundle.model.dgr.to_shear.in_features == encoder.patch_shape[-1]
    assert bundle.model.dgr.to_feature.out_features == encoder.width
    assert (answer.evidence["view"] is None) == (name == "t3")
    assert json.dumps(answer.to_dict())


def test_a_run_killed_while_encoding_continues_to_the_same_model(
    anytouch2, finished, tmp_path, monkeypatch
):
    encode, calls = ReleasedEncoder.encode, []

    def interrupted(self, clips):
        calls.append(len(clips))
        if len(calls) == 2:
            raise KeyboardInterrupt
        return encode(self, clips)

    with monkeypatch.context() as patch:
        patch.setattr(ReleasedEncoder, "encode", interrupted)
        with pytest.raises(KeyboardInterrupt):
            train_heads(anytouch2, "tiny", tmp_path, seed=3)
    assert len((tmp_path / "tokens" / "heads.jsonl").read_text().splitlines()) == BATCH
    resumed = train_heads(anytouch2, "tiny", tmp_path, seed=3)
    for name in ("tokens/heads.npy", "tokens/validation.npy"):
        assert (tmp_path / name).read_bytes() == (finished[0] / name).read_bytes()
    assert resumed.digest() == finished[1].digest()


def test_half_a_line_that_a_kill_left_is_encoded_again(anytouch2, tmp_path):
    whole = encode_examples(anytouch2, tmp_path, WANTED, seed=1)
    before = whole.tokens.patches.clone()
    about = tmp_path / "check.jsonl"
    lines = about.read_text().splitlines(keepends=True)
    about.write_text("".join(lines[:BATCH]) + lines[BATCH][:20])
    again = encode_examples(anytouch2, tmp_path, WANTED, seed=1)
    assert about.read_text() == "".join(lines)
    assert torch.equal(again.tokens.patches, before)
    assert again.labels == whole.labels


@pytest.mark.parametrize("change", ["encoder", "seed"])
def test_a_folder_of_another_run_is_refused(change, anytouch2, finished, tmp_path):
    out = finished[0]
    other = load_encoder(write_small("unit", tmp_path)) if change == "encoder" else anytouch2
    with pytest.raises(UsageError) as caught:
        train_heads(other, "tiny", out, seed=4 if change == "seed" else 3)
    assert str(caught.value) == (
        f"{out} holds a run of another encoder, preset, seed or version of this program; give an "
        f"empty folder by --run-folder, or continue the run as it began."
    )
