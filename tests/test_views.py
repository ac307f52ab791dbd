"""Pictures show what they are drawn from, where it is: pixels against known geometry."""

from dataclasses import replace

import numpy as np
import pytest

from geotlm_lm import views
from geotlm_lm.backbone.view import View
from geotlm_lm.views import (
    ARROW_COLOUR,
    LEARNED_SHEAR,
    PICTURE_SIDE,
    TRUE_DISPLACEMENT,
    VIEW_NAMES,
    Seen,
    draw_arrows,
    draw_contact,
    draw_legend,
    in_image,
    picture,
    views_of,
)

GREY = np.full((448, 448, 3), 90, np.uint8)
WHOLE = View()


def one_patch(row, column, side=14):
    mask = np.zeros((side, side), np.float32)
    mask[row, column] = 1
    return mask


def centre_of(change):
    """Return (x, y) of the middle of an image's weight."""
    rows, columns = np.indices(change.shape)
    return tuple(float((places * change).sum() / change.sum()) for places in (columns, rows))


def yellow(image):
    return (np.abs(image.astype(int) - ARROW_COLOUR) < 40).all(axis=-1)


@pytest.mark.parametrize(
    ("step", "axis", "sign"), [((1, 0), 0, 1), ((-1, 0), 0, -1), ((0, 1), 1, 1), ((0, -1), 1, -1)]
)
def test_an_arrow_goes_from_the_middle_of_its_patch_the_way_of_the_shear(step, axis, sign):
    field = np.broadcast_to(np.float32(step), (14, 14, 2))
    drawn = yellow(draw_arrows(GREY, 10 * field, one_patch(6, 8), WHOLE))
    tail = (8.5 * 32, 6.5 * 32)
    middle = centre_of(drawn)
    # 40 px of the view, 80 of the picture, drawn from the middle of the patch on.
    assert sign * (middle[axis] - tail[axis]) > 0.4 * 80
    assert abs(middle[1 - axis] - tail[1 - axis]) < 2


def test_arrows_stand_in_the_views_place():
    view = View(centre_x_px=150.0, centre_y_px=70.0, side_px=112.0)
    field = np.broadcast_to(np.float32((5, 0)), (14, 14, 2))
    drawn = yellow(draw_arrows(GREY, field, one_patch(0, 0), view))
    x, y = centre_of(drawn)
    # The view's corner is at (94, 14) of 224, its patches are 8 px of 224, 16 of the picture.
    assert 2 * 94 + 8 < x < 2 * 94 + 8 + 20
    assert y == pytest.approx(2 * 14 + 8, abs=2)


def test_the_contact_stands_in_its_place_where_idle_gel_fills_up_the_square():
    portrait = np.full((448, 336, 3), 90, np.uint8)
    view = View(picture_height_px=224, picture_width_px=126)
    tinted = draw_contact(portrait, one_patch(10, 6), view).astype(int) - 90
    x, y = centre_of(np.maximum(tinted[..., 0], 0)[4:-4, 4:-4])
    # Patch 6 begins at 96 of 224, 47 of the 126 that the picture fills.
    assert x + 4 == pytest.approx((6.5 * 16 - 49) / 126 * 336, abs=2)
    assert y + 4 == pytest.approx(10.5 / 14 * 448, abs=2)


@pytest.mark.parametrize("view", [WHOLE, View(120.0, 104.0, 112.0)])
def test_a_grid_is_read_at_the_middle_of_every_pixel(view):
    grid = np.tile(np.arange(14, dtype=np.float32), (14, 1))
    drawn = in_image(grid, view, (56, 56))  # a pixel is 4 of 224
    left, cell = (view.centre_x_px - view.side_px / 2) / 4, view.side_px / 4 / 14
    read_at = (np.arange(56) + 0.5 - left) / cell - 0.5
    inside = (read_at > 1) & (read_at < 12)
    assert drawn[28][inside] == pytest.approx(read_at[inside], abs=0.04)
    covered = in_image(np.ones((14, 14), np.float32), view, (56, 56))[28]
    assert covered[inside] == pytest.approx(1, abs=1e-5)
    assert covered[(read_at < -2) | (read_at > 15)].sum() == 0


def length_of(drawn):
    """Return how many columns an arrow to the right takes up."""
    columns = np.flatnonzero(drawn.any(axis=0))
    return int(columns[-1] - columns[0]) if len(columns) else 0


@pytest.mark.parametrize("side_px", [224.0, 112.0])
def test_arrows_are_as_long_as_the_motion_whatever_else_is_drawn(side_px):
    mask, view = one_patch(6, 1) + 0.5 * one_patch(9, 1), View(side_px=side_px)
    for units in (3, 6, 9):
        field = np.zeros((14, 14, 2), np.float32)
        field[6, 1, 0], field[9, 1, 0] = units, 9
        drawn = yellow(draw_arrows(GREY, field, mask, view))
        row = round(6.5 / 14 * side_px * 2 + 224 - side_px)
        # A unit is 4 px of the view, and a pixel of the image two of the picture.
        expected = units * 4 * side_px / 224 * 2
        assert length_of(drawn[row - 4 : row + 5]) == pytest.approx(expected, abs=4)


def test_no_arrow_is_drawn_outside_of_the_contact():
    field, mask = np.full((14, 14, 2), 9, np.float32), np.full((14, 14), 0.01, np.float32)
    mask[:, :3] = 0.4
    drawn = yellow(draw_arrows(GREY, field, mask, WHOLE))
    assert drawn[:, : 3 * 32].any()
    assert not drawn[:, 6 * 32 :].any()


def test_nothing_is_drawn_over_a_gel_that_nothing_touches():
    touched = seen()
    noisy = replace(touched, shear_change=np.full((14, 14, 2), 9, np.float32))
    assert not np.array_equal(picture(noisy, "arrows"), picture(noisy, "raw"))
    untouched = replace(noisy, has_contact=False)
    assert np.array_equal(picture(untouched, "arrows"), picture(untouched, "raw"))


@pytest.mark.parametrize("scale", [LEARNED_SHEAR, TRUE_DISPLACEMENT])
def test_the_legends_arrow_is_as_long_as_one_of_the_picture(scale):
    legend = draw_legend(GREY, WHOLE, scale)
    field = np.zeros((14, 14, 2), np.float32)
    field[..., 0] = scale.shown
    arrow = draw_arrows(GREY, field, one_patch(6, 3), WHOLE, scale)
    assert length_of(yellow(legend)) == pytest.approx(length_of(yellow(arrow)), abs=1)
    assert length_of(yellow(legend)) > 30
    assert (legend[:400] == GREY[:400]).all()
    assert (legend[400:] > 200).all(axis=-1).sum() > 100  # its words


def seen(depth=None):
    frames = np.full((4, 60, 80, 3), 100, np.uint8)
    frames[2, 20:30, 40:50] = 120
    idle = np.full((60, 80, 3), 100, np.uint8)
    field, mask = np.ones((14, 14, 2), np.float32), one_patch(3, 3)
    return Seen(frames, idle, field, mask, WHOLE, depth)


def test_a_difference_is_neutral_where_nothing_changed_and_bright_where_it_grew():
    image = picture(seen(), "difference", 2)
    scale = PICTURE_SIDE / 80
    changed = image[round(25 * scale), round(45 * scale)]
    assert changed.tolist() == [128 + 4 * 20] * 3
    assert image[5, 5].tolist() == [128] * 3
    assert (picture(seen(), "difference", 0) == 128).all()


def test_depth_is_shown_only_where_it_is_known():
    depth = np.zeros((4, 14, 14), np.float32)
    depth[1, :, 7:] = 0.5
    assert views_of(seen()) == VIEW_NAMES[:-1]
    image = picture(seen(depth), "depth", 1).astype(int).sum(axis=-1)
    assert image[:, -60:].min() > image[:, :60].max()
    with pytest.raises(ValueError, match="there is no view 'depth', expected one of raw, "):
        picture(seen(), "depth")


@pytest.mark.parametrize(
    ("way", "expected"),
    [((0, 20, 0), (20, 0)), ((0, 0, -20), (0, -20)), ((90, 0, 0), None), ((0, 0, 0), None)],
)
def test_arrows_of_a_motion_lead_from_each_point_to_where_it_goes(way, expected, monkeypatch):
    ends = []
    monkeypatch.setattr(views, "_draw_arrow", lambda image, drawn: ends.append(drawn))
    mask = np.zeros((14, 14), np.float32)
    mask[4:9, 4:9] = 1
    frames = np.zeros((4, 224, 224, 3), np.uint8)
    seen = Seen(frames, frames[0], np.zeros((14, 14, 2), np.float32), mask, View())
    views.draw_motion(frames[0], seen, *way)
    if not any(way):
        assert ends == []
        return
    tails, tips = np.array(ends).transpose(1, 0, 2)
    if expected is not None:
        assert np.allclose(tips - tails, expected)
        return
    middle = tails.mean(axis=0)
    (right, down), turned = (tails - middle).T, tips - middle
    assert np.allclose(turned, np.stack([-down, right], axis=-1), atol=0.1)  # clockwise as drawn
