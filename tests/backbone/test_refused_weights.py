"""Weights that fit no released encoder in their values, shapes or parts are refused in words."""

import pytest
import torch

from geotlm_lm.backbone.encoders import ENCODERS
from geotlm_lm.backbone.released import load_encoder
from geotlm_lm.core.errors import IncompatibleWeights, UsageError
from tests.backbone.small_files import write_small


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


def with_other_frequencies(tensors):
    tensors["pos_embed.frequency_bands"] *= 2


@pytest.mark.parametrize(
    ("name", "spoil", "said"),
    [
        ("sparsh", not_finite, "norm.weight holds values that are not finite; get the file of"),
        ("sparsh", with_other_frequencies, "pos_embed.frequency_bands is not the table"),
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
