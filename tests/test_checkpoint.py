"""Laws: what is loaded is what was saved; what is not recognised is refused in one sentence."""

import json
import shutil

import numpy as np
import pytest
import torch
from safetensors.torch import load_file, save_file

from geotlm_lm.backbone.stem import PATCH_INPUT_DIM
from geotlm_lm.checkpoint import Calibration, load_bundle, reading_of, save_bundle
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import IncompatibleBundle
from geotlm_lm.language.sequence import SequenceDecoder
from geotlm_lm.motion.belief import BELIEF_NUMBERS
from geotlm_lm.motion.measured import measured
from geotlm_lm.motion.network import belief_of_one
from geotlm_lm.query.reader import Reader
from tests.tiny_bundle import WIDTH, tiny_bundle, tiny_reader


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    folder, bundle = tmp_path_factory.mktemp("saved") / "bundle", tiny_bundle()
    save_bundle(folder, bundle)
    return folder, bundle


def clip():
    rng = np.random.default_rng(0)
    frames = rng.integers(90, 120, (4, 32, 40, 3)).astype(np.uint8)
    return Clip(frames, background=np.full((32, 40, 3), 105, np.uint8))


@torch.no_grad()
def reading(bundle, seen):
    motions = torch.from_numpy(np.stack([one.numbers() for one in seen.motions]))
    found = measured(seen.inputs, motions, seen.geometry, seen.fused_token)
    return reading_of(seen.fused_token, [belief_of_one(bundle.motion(found))])


def test_a_loaded_bundle_perceives_and_speaks_as_the_saved_one(saved):
    folder, bundle = saved
    loaded = load_bundle(folder)
    before, after = bundle.model.perceive([clip()]), loaded.model.perceive([clip()])
    # Weights are stored in half precision: 2^-11 relative, a few layers deep.
    torch.testing.assert_close(after.fused_token, before.fused_token, atol=2e-2, rtol=2e-2)
    read, read_again = reading(bundle, before), reading(loaded, after)
    assert read.shape == (1, WIDTH + BELIEF_NUMBERS)
    torch.testing.assert_close(read_again, read, atol=2e-2, rtol=2e-2)
    one, other = (each.speaker.prefix(read[0].numpy()) for each in (bundle, loaded))
    for slot, words in one.slots.items():
        np.testing.assert_array_equal(other.slots[slot], words)
    said = [each.speaker.sentence(one, "Which way?", "way all", "") for each in (bundle, loaded)]
    assert said[0] == said[1]
    assert loaded.calibration == bundle.calibration
    assert loaded.provenance == {"command": "test"}
    assert loaded.reader.spelling.words == bundle.reader.spelling.words
    assert loaded.reader.calibration == bundle.reader.calibration


def test_saving_what_was_loaded_changes_no_byte(saved, tmp_path):
    folder, _ = saved
    save_bundle(tmp_path / "again", load_bundle(folder))
    for path in folder.rglob("*"):
        if path.is_file():
            copy = tmp_path / "again" / path.relative_to(folder)
            assert copy.read_bytes() == path.read_bytes(), path.name


def test_the_digest_tells_bundles_apart_by_weights_and_calibration(saved):
    folder, _ = saved
    one, two = load_bundle(folder), load_bundle(folder)
    assert one.digest() == two.digest()
    two.calibration = Calibration(felt_temperature=3.0)
    assert one.digest() != two.digest()
    two.calibration, before = one.calibration, two.digest()
    with torch.no_grad():
        next(two.model.probe.parameters())[0] += 1e-3
    between = two.digest()
    embeddings = two.reader.decoder.stored["model.embed_tokens.weight"]
    embeddings[len(embeddings) // 2] += 1
    assert len({before, between, two.digest()}) == 3


def without(name):
    return lambda bundle: (bundle / name).unlink()


def with_config(change):
    def spoil(bundle):
        config = json.loads((bundle / "config.json").read_text())
        (bundle / "config.json").write_text(json.dumps(change(config)))

    return spoil


def with_truncated_weights(bundle):
    path = bundle / "perception.safetensors"
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def with_an_unknown_part(bundle):
    path = bundle / "perception.safetensors"
    save_file(load_file(path) | {"wheels.weight": torch.zeros(2)}, path)


def with_a_speaker_of_another_width(bundle):
    reader = tiny_reader()
    numbers = dict.fromkeys(("mean", "scale"), np.ones(5, np.float16))
    decoder = reader.decoder
    other = SequenceDecoder(decoder.config, decoder.stored, decoder.projector | numbers)
    Reader(other, reader.spelling, (1.0, 0.0)).save(bundle / "language")


OTHER_FORMAT = with_config(lambda config: config | {"format": 99})
OTHER_STEM = with_config(
    lambda config: config | {"backbone": config["backbone"] | {"input_dim": PATCH_INPUT_DIM + 1}}
)


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (
            lambda bundle: (bundle / "config.json").unlink(),
            ": found no model bundle there (no config.json); give the folder that",
        ),
        (OTHER_FORMAT, ": the bundle has format 99, this version reads 13; train it again or"),
        (OTHER_STEM, f"(patch inputs have {PATCH_INPUT_DIM + 1} numbers"),
        (with_truncated_weights, ": perception.safetensors does not fit config.json ("),
        (
            lambda bundle: (bundle / "language" / "tokenizer.json").unlink(),
            "language: the language model's files are missing, broken",
        ),
        (with_a_speaker_of_another_width, ": language reads 5 numbers of a clip, perception.safe"),
        (with_an_unknown_part, "(unknown parts ['wheels']); train or copy the bundle again."),
    ],
)
def test_what_is_not_recognised_is_refused_in_one_sentence(saved, tmp_path, spoil, reason):
    folder = tmp_path / "bundle"
    shutil.copytree(saved[0], folder)
    spoil(folder)
    with pytest.raises(IncompatibleBundle) as caught:
        load_bundle(folder)
    assert str(caught.value).startswith(str(folder))
    assert reason in str(caught.value)
