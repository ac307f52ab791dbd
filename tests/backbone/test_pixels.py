"""Expected values: formulas of the authors' preparation, on frames where they can be worked out."""

import numpy as np
import pytest
import torch

from geotlm_lm.backbone.encoders import ENCODERS
from geotlm_lm.backbone.pixels import CLIP_STATISTICS, IMAGENET
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import IMAGE_SIDE

RNG = np.random.default_rng(0)
SIZES = {
    "anytouch2": ((224, 224), (4, 3, 224, 224)),
    "anytouch1": ((224, 224), (4, 3, 224, 224)),
    "sparsh": ((320, 240), (3, 4, 320, 240)),
    "t3": ((224, 224), (4, 3, 224, 224)),
    "internvit": ((448, 448), (4, 3, 448, 448)),
    "unit": ((128, 160), (4, 3, 128, 160)),
}


def flat_clip(colours, idle=(100, 120, 140), size=(240, 320)):
    frames = np.array(colours, np.uint8)[:, None, None, :] * np.ones((1, *size, 1), np.uint8)
    return Clip(frames, background=np.full((*size, 3), idle, np.uint8))


COLOURS = [(10, 60, 200), (20, 70, 210), (30, 80, 220), (255, 255, 255)]


def pixels(name, clip):
    return ENCODERS[name].pixels(clip, SIZES[name][0])


def expected_colours(offset, idle, statistics):
    frames = torch.tensor(COLOURS, dtype=torch.float64) / 255
    frames = (frames - torch.tensor(idle) / 255 + offset).clamp(0, 1)
    mean, deviation = (torch.tensor(values, dtype=torch.float64) for values in statistics)
    return (frames - mean) / deviation


@pytest.mark.parametrize(
    ("name", "offset", "idle", "statistics"),
    [
        ("anytouch2", 130 / 255, (100, 120, 140), CLIP_STATISTICS),
        ("anytouch1", 0.0, (0, 0, 0), IMAGENET),
        ("t3", 0.0, (0, 0, 0), IMAGENET),
        ("internvit", 0.0, (0, 0, 0), IMAGENET),
    ],
)
def test_colours_are_the_formulas_oldest_frame_first(name, offset, idle, statistics):
    found = pixels(name, flat_clip(COLOURS)).double()
    expected = expected_colours(offset, idle, statistics)[..., None, None].expand_as(found)
    torch.testing.assert_close(found, expected, atol=2e-6, rtol=2e-6)


def test_sparsh_sees_the_rounded_difference_newest_frame_first():
    found = pixels("sparsh", flat_clip(COLOURS))
    difference = (np.array(COLOURS) - np.array([100, 120, 140])) / 255 + 0.5
    expected = np.floor(difference.clip(0, 1) * 255 + 1e-9)[::-1] / 255
    expected = torch.from_numpy(expected.T.copy()).float()[..., None, None]
    torch.testing.assert_close(found, expected.expand_as(found))


def test_unit_sees_blue_first_between_0_and_1():
    found = pixels("unit", flat_clip(COLOURS))
    expected = torch.tensor(COLOURS).flip(1)[..., None, None] / 255
    torch.testing.assert_close(found, expected.expand_as(found))


def marked_clip(row, column, size=(240, 320)):
    frame = np.full((*size, 3), 100, np.uint8)
    frame[max(row - 8, 0) : row + 8, max(column - 8, 0) : column + 8] = 250
    return Clip(np.stack([frame] * 4), background=np.full((*size, 3), 100, np.uint8))


def brightest(image):
    """Return the centre of what is bright, as shares of rows and columns."""
    weight = (image - image.min()).clamp(min=0)
    weight = torch.where(weight > 0.5 * weight.max(), weight, 0.0)
    rows, columns = image.shape
    at = [torch.arange(n) + 0.5 for n in (rows, columns)]
    return float(weight.sum(1) @ at[0] / weight.sum()) / rows, float(
        weight.sum(0) @ at[1] / weight.sum()
    ) / columns


@pytest.mark.parametrize(
    ("name", "at"),
    [
        *((name, (0.25, 0.75)) for name in ("anytouch2", "anytouch1", "internvit", "unit")),
        # Turned clockwise rows run right to left.
        ("sparsh", (0.75, 0.75)),
        # 256 rows high the picture is 341 wide; 224 of each are kept.
        ("t3", ((75 * 256 / 240 - 16) / 224, (170 * 341 / 320 - 58) / 224)),
    ],
)
def test_each_encoder_sees_a_place_where_its_authors_preparation_puts_it(name, at):
    place = (75, 170) if name == "t3" else (60, 240)
    seen = pixels(name, marked_clip(*place))
    assert brightest(seen[1, 0] if name == "sparsh" else seen[0, 1]) == pytest.approx(at, abs=0.01)


def test_sparshs_grid_is_turned_back_to_the_camera():
    row = ENCODERS["sparsh"]

    class Averages(torch.nn.Module):
        """Each patch token is the mean of its pixels, so that its place can be read."""

        def forward(self, clips):
            tubes = clips.unflatten(2, (2, 2)).mean(dim=(1, 3))
            cells = tubes.unflatten(3, (15, 16)).unflatten(2, (20, 16)).mean(dim=(3, 5))
            return cells.flatten(1)[..., None]

        def normed(self, tokens):
            return tokens

        def patch_grid(self, tokens):
            return tokens.unflatten(1, (2, 20, 15))

    clip = marked_clip(60, 240)
    grid = row.tokens(Averages(), pixels("sparsh", clip)[None]).patches[0, :, :, :, 0]
    assert grid.shape == (2, 15, 20)
    assert brightest(grid[0]) == pytest.approx((0.25, 0.75), abs=0.02)
    moving = Clip(
        np.concatenate([clip.frames[:2], marked_clip(180, 80).frames[:2]]),
        background=clip.background,
    )
    early, late = row.tokens(Averages(), pixels("sparsh", moving)[None]).patches[0, ..., 0]
    assert brightest(early) == pytest.approx((0.25, 0.75), abs=0.02)
    assert brightest(late) == pytest.approx((0.75, 0.25), abs=0.02)


def test_the_view_is_told_where_it_is_a_square_of_the_image():
    camera, square = flat_clip(COLOURS), flat_clip(COLOURS, size=(300, 300))
    assert ENCODERS["anytouch2"].view(camera).side_px == IMAGE_SIDE
    assert ENCODERS["sparsh"].view(camera).side_px == IMAGE_SIDE
    assert ENCODERS["sparsh"].view(flat_clip(COLOURS, size=(300, 500))) is None
    assert ENCODERS["t3"].view(camera) is None
    assert ENCODERS["t3"].view(square).side_px == pytest.approx(196)


def test_a_clip_of_another_length_or_without_its_idle_frame_is_refused():
    for name in SIZES:
        with pytest.raises(ValueError, match="an encoder reads 4 frames, found 3"):
            pixels(name, flat_clip(COLOURS[:3]))
    for name in ("anytouch2", "sparsh"):
        with pytest.raises(ValueError, match="reads the difference from an idle frame, found none"):
            pixels(name, Clip(flat_clip(COLOURS).frames))
