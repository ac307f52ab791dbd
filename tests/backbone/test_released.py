"""Expected values: sizes in the authors' code; what a file must hold, by taking parts out of it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from geotlm_lm.backbone.encoders import ENCODERS
from geotlm_lm.backbone.released import ReleasedEncoder, encoder_row, fitted, load_encoder
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import IncompatibleWeights, UsageError
from tests.backbone.small_files import FILES, write_small

TABLE = {
    # encoder: numbers in the file's part, tensors, width, patch tokens of a clip, image
    "anytouch2": (87_010_185, 202, 768, (2, 14, 14, 768), (224, 224)),
    "anytouch1": (305_221_632, 393, 1024, (2, 16, 16, 1024), (224, 224)),
    "sparsh": (86_256_000, 174, 768, (2, 15, 20, 768), (320, 240)),
    "t3": (22_006_272 + 63_792_384, 150, 768, (2, 14, 14, 768), (224, 224)),
    "internvit": (304_012_288, 340, 1024, (2, 32, 32, 1024), (448, 448)),
    "unit": (25_179_663, 128, 960, (2, 16, 20, 3), (128, 160)),
}

CONSTANTS = {"anytouch2": 393, "sparsh": 3 * 128}
"""Numbers in the file's part that are no weights: an index table, the frequencies of positions."""


@pytest.mark.parametrize("name", TABLE)
def test_a_released_file_has_the_names_shapes_and_numbers_it_is_known_for(name):
    numbers, tensors, width, patches, size = TABLE[name]
    file = FILES[name]()
    assert (sum(value.numel() for value in file.values()), len(file)) == (numbers, tensors)
    module, image, parts = fitted(ENCODERS[name], file, Path("released"))
    encoder = ReleasedEncoder(ENCODERS[name], module, image)
    held = sum(parameter.numel() for parameter in module.parameters())
    assert held == numbers - CONSTANTS.get(name, 0)
    assert sum(len(pairs) for pairs in parts.values()) == tensors - (name in CONSTANTS)
    assert (encoder.width, encoder.patch_shape, encoder.image) == (width, patches, size)


@pytest.mark.parametrize("name", TABLE)
def test_a_file_is_recognised_by_its_names_alone(name, tmp_path):
    path = write_small(name, tmp_path)
    options = {} if name == "unit" else {"heads": 2}
    encoder = load_encoder(path, **options)
    assert encoder.row.name == name
    assert load_encoder(path, name, **options).digest() == encoder.digest()


@pytest.mark.parametrize("other", TABLE)
def test_a_file_of_another_encoder_is_refused_with_names(other, tmp_path):
    path = write_small(other, tmp_path)
    for name in TABLE.keys() - {other}:
        with pytest.raises(IncompatibleWeights) as caught:
            load_encoder(path, name, heads=2)
        text, row = str(caught.value), ENCODERS[name]
        if (other, name) == ("anytouch1", "anytouch2"):
            # It has every name of AnyTouch 2, with a stem of another shape.
            assert "patch_embedding.weight has shape (24, 3, 14, 14), expected 5 axes" in text
            continue
        assert text.startswith(f"{path}: is not {row.title}: missing ")
        assert text.endswith(f"; get the file from {row.source}.")
        missing, unexpected = text.split(": missing ")[1].split(", unexpected ", 1)
        assert missing.split(",")[0] in row.anchors
        assert unexpected
        assert "\n" not in text


def test_the_vision_part_of_a_chat_model_is_found_beside_its_language_part(tmp_path):
    def embed(tensors):
        for own in list(tensors):
            tensors[f"vision_model.{own}"] = tensors.pop(own)
        tensors["language_model.layers.0.weight"] = torch.ones(2)

    path = write_small("internvit", tmp_path, embed)
    assert load_encoder(path, heads=2).row.name == "internvit"


def test_an_unknown_name_is_answered_with_the_nearest_or_all():
    with pytest.raises(UsageError, match="no encoder 'anytuch2'; did you mean 'anytouch2'[?]"):
        encoder_row("anytuch2")
    with pytest.raises(UsageError, match="choose one of anytouch2, anytouch1, sparsh, t3"):
        encoder_row("resnet")


def test_the_trunk_of_t3_is_told_from_the_encoder_of_a_sensor(tmp_path):
    write_small("t3", tmp_path)
    for name in (None, "t3"):
        with pytest.raises(IncompatibleWeights) as caught:
            load_encoder(tmp_path / "trunk.pth", name, heads=2)
        assert str(caught.value) == (
            f"{tmp_path / 'trunk.pth'}: is T3's trunk, expected the encoder of a sensor; give that "
            f"file, encoders/mini.pth for GelSight Mini, and leave the trunk beside its folder."
        )


def not_finite(tensors):
    tensors["norm.weight"][3] = float("nan")


def of_two_frames(tensors):
    key = "touch_mae_model.touch_model.embeddings.position_embedding.weight"
    tensors[key] = torch.ones(1 + 9, 24)


def narrow(tensors):
    for own in [one for one in tensors if one.startswith("encoder.")]:
        sizes = [{32: 8, 64: 16}.get(size, size) for size in tensors[own].shape]
        tensors[own] = torch.ones(sizes)


def without_levels(tensors):
    for own in [one for one in tensors if one.startswith("encoder.down.")]:
        del tensors[own]


def without_video_stem(tensors):
    del tensors["touch_mae_model.video_patch_embedding.weight"]


def with_a_surplus(tensors):
    tensors["surplus.weight"] = torch.ones(3)


def with_other_frequencies(tensors):
    tensors["pos_embed.frequency_bands"] *= 2


@pytest.mark.parametrize(
    ("name", "spoil", "said"),
    [
        ("sparsh", not_finite, "norm.weight holds values that are not finite; get the file of"),
        ("sparsh", with_other_frequencies, "pos_embed.frequency_bands is not the table"),
        ("sparsh", with_a_surplus, "unexpected surplus.weight; get the file from"),
        ("anytouch2", of_two_frames, "9 positions, expected 2 times a grid of"),
        ("anytouch1", without_video_stem, "missing video_patch_embedding.weight"),
        ("unit", narrow, "is not UniT: no encoder has the sizes found (num_channels (8) must be"),
        ("unit", without_levels, "missing encoder.down.0.block.0.conv1.weight"),
    ],
)
def test_a_file_that_fits_in_part_is_refused_with_what_is_wrong(tmp_path, name, spoil, said):
    path = write_small(name, tmp_path, spoil)
    with pytest.raises(IncompatibleWeights) as caught:
        load_encoder(path, name, heads=None if name == "unit" else 2)
    assert str(caught.value).startswith(f"{path}: ")
    assert said in str(caught.value)
    assert ENCODERS[name].source in str(caught.value)


def test_heads_must_be_told_for_a_width_that_was_not_released(tmp_path):
    path = write_small("sparsh", tmp_path)
    with pytest.raises(UsageError) as caught:
        load_encoder(path)
    assert str(caught.value) == (
        f"{path}: Sparsh V-JEPA of width 24, expected 768; a file does not tell its attention "
        f"heads, give them by --heads."
    )
    with pytest.raises(UsageError, match="width 24 does not divide among 7 attention heads"):
        load_encoder(path, heads=7)


# Every encoder stands behind the embedded backbone's seam: DGR and the probes read its tokens.

RNG = np.random.default_rng(1)


def clip(size=(240, 320)):
    frames = RNG.integers(60, 180, (4, *size, 3)).astype(np.uint8)
    return Clip(frames, background=np.full((*size, 3), 120, np.uint8))


@pytest.fixture(scope="module", params=list(ENCODERS))
def encoder(request, tmp_path_factory):
    path = write_small(request.param, tmp_path_factory.mktemp(request.param))
    return load_encoder(path, None if request.param != "sparsh" else "sparsh", heads=2)


def test_tokens_have_the_shapes_the_encoder_tells_beforehand(encoder):
    tokens = encoder.encode([clip(), clip((224, 224))])
    assert tokens.global_token.shape == (2, encoder.width)
    assert tokens.patches.shape == (2, *encoder.patch_shape)
    assert tokens.patches.dtype == tokens.global_token.dtype == torch.float32
    assert len(tokens.views) == 2


def test_a_batch_equals_its_clips_one_by_one(encoder):
    clips = [clip() for _ in range(5)]
    together = encoder.encode(clips)
    for index, one in enumerate(clips):
        alone = encoder.encode([one])
        torch.testing.assert_close(together.patches[index], alone.patches[0], rtol=1e-4, atol=1e-5)
        torch.testing.assert_close(
            together.global_token[index], alone.global_token[0], rtol=1e-4, atol=1e-5
        )


def test_a_pair_changes_only_with_what_a_bin_sees(encoder):
    # a, a, b, b: transformers whose bins attend to each other are left out by construction.
    if encoder.row.name in ("anytouch2", "sparsh"):
        pytest.skip("its time-bins attend to each other")
    a, b, c = (clip().frames[0] for _ in range(3))
    idle = clip().background

    def patches(*frames):
        return encoder.encode([Clip(np.stack(frames), background=idle)]).patches[0]

    first, second = patches(a, a, b, b), patches(a, a, c, c)
    torch.testing.assert_close(first[0], second[0], rtol=1e-4, atol=1e-5)
    assert not torch.allclose(first[1], second[1], atol=1e-3)


def test_a_clip_that_stands_still_has_equal_bins_where_bins_have_no_position(encoder):
    still = clip()
    frames = np.repeat(still.frames[:1], 4, axis=0)
    early, late = encoder.encode([replace(still, frames=frames)]).patches[0]
    has_time = encoder.row.name in ("anytouch2", "sparsh")
    assert torch.allclose(early, late, atol=1e-5) != has_time
