"""Weights that fit no released encoder in their values, shapes or parts are refused in words."""

import pytest
import torch

from geotlm_lm.backbone.released import ENCODERS, load_encoder
from geotlm_lm.core.errors import IncompatibleWeights, UsageError
from tests.backbone.small_files import write_small


def test_values_that_are_not_finite_are_refused(tmp_path):
    def spoil(tensors):
        tensors["norm.weight"][3] = float("nan")

    path = write_small("sparsh", tmp_path, spoil)
    with pytest.raises(IncompatibleWeights) as caught:
        load_encoder(path, heads=2)
    assert str(caught.value) == (
        f"{path}: norm.weight holds values that are not finite; get the file of Sparsh V-JEPA "
        f"again from {ENCODERS['sparsh'].source}."
    )


def test_a_checkpoint_of_two_frames_is_refused_for_having_one_time_bin(tmp_path):
    def spoil(tensors):
        key = "touch_mae_model.touch_model.embeddings.position_embedding.weight"
        tensors[key] = torch.ones(1 + 9, 24)

    path = write_small("anytouch2", tmp_path, spoil)
    with pytest.raises(IncompatibleWeights, match="9 positions, expected 2 times a grid of"):
        load_encoder(path, "anytouch2", heads=2)


def test_unit_of_a_width_its_norms_cannot_have_is_refused(tmp_path):
    def narrow(tensors):
        for own in [one for one in tensors if one.startswith("encoder.")]:
            sizes = [{32: 8, 64: 16}.get(size, size) for size in tensors[own].shape]
            tensors[own] = torch.ones(sizes)

    path = write_small("unit", tmp_path, narrow)
    with pytest.raises(IncompatibleWeights) as caught:
        load_encoder(path)
    assert str(caught.value) == (
        f"{path}: is not UniT: no encoder has the sizes found (num_channels (8) must be divisible "
        f"by num_groups (32)); get the file from {ENCODERS['unit'].source}."
    )


def test_unit_without_levels_is_refused_by_the_name_that_is_missing(tmp_path):
    def flatten(tensors):
        for own in [one for one in tensors if one.startswith("encoder.down.")]:
            del tensors[own]

    path = write_small("unit", tmp_path, flatten)
    with pytest.raises(IncompatibleWeights, match="missing encoder.down.0.block.0.conv1.weight"):
        load_encoder(path)


def test_the_stale_stem_of_anytouch_1_is_not_read(tmp_path):
    changed = {}

    def spoil(tensors):
        stale = next(
            n for n in tensors if n.endswith("touch_model.embeddings.patch_embedding.weight")
        )
        tensors[stale] = torch.full_like(tensors[stale], 9.0)
        changed[stale] = True

    first = load_encoder(write_small("anytouch1", tmp_path / "a"), heads=2)
    second = load_encoder(write_small("anytouch1", tmp_path / "b", spoil), heads=2)
    assert changed
    assert first.digest() == second.digest()


def test_a_file_of_anytouch_1_without_its_video_stem_is_refused(tmp_path):
    def spoil(tensors):
        del tensors["touch_mae_model.video_patch_embedding.weight"]

    path = write_small("anytouch1", tmp_path, spoil)
    with pytest.raises(IncompatibleWeights, match="missing video_patch_embedding.weight"):
        load_encoder(path, "anytouch1", heads=2)


def test_t3_without_its_trunk_is_refused_with_where_it_was_looked_for(tmp_path):
    path = write_small("t3", tmp_path)
    (tmp_path / "trunk.pth").unlink()
    with pytest.raises(IncompatibleWeights) as caught:
        load_encoder(path, heads=2)
    assert str(caught.value) == (
        f"{path}: T3's encoder was found without its trunk, expected trunk.pth beside it or one "
        f"folder up; get both from {ENCODERS['t3'].source}."
    )


def test_other_frequencies_of_positions_are_refused(tmp_path):
    def spoil(tensors):
        tensors["pos_embed.frequency_bands"] *= 2

    path = write_small("sparsh", tmp_path, spoil)
    with pytest.raises(IncompatibleWeights, match="pos_embed.frequency_bands is not the table"):
        load_encoder(path, heads=2)


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
