"""The rigid motion in a learned field, told in the recording's own pixels."""

import numpy as np
import pytest
import torch

from geotlm_lm.backbone.view import View
from geotlm_lm.core.geometry import FLOW_SCALE_PX, filled_size
from geotlm_lm.dgr.encoder import DGR
from geotlm_lm.model import contact_centre, rigid_motion

SIZES = [(240, 320), (320, 240), (480, 640), (240, 240), (1080, 1920)]


def geometry_of(field):
    """What DGR holds of a field in pixels of the view, touched everywhere."""
    late = torch.tensor(np.float32(field / FLOW_SCALE_PX))[None]
    with torch.no_grad():
        return DGR(4).pool(torch.zeros(1, 2, 14, 14, 2), late, torch.ones(1, 14, 14))


def on_gel(rows, columns, view):
    """Return where the patches' middles are, pixels of the recording, and these per view pixel."""
    filled_rows, filled_columns = filled_size(rows, columns)
    per_px = np.array([columns / filled_columns, rows / filled_rows]) * view.side_px / 224
    middles = (np.arange(14) - 6.5) * 16
    return np.stack(np.meshgrid(middles, middles), axis=-1) * per_px, per_px


@pytest.mark.parametrize("size", SIZES)
def test_a_turn_and_a_slide_come_out_in_the_recordings_pixels_whatever_its_shape(size):
    view = View(100.0, 120.0, 112.0)
    places, per_px = on_gel(*size, view)
    turn = np.radians(5.0)
    turned = places @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    field = (turned - places + (3.0, -2.0)) / per_px
    found = rigid_motion(geometry_of(field), view, size)
    assert found == pytest.approx((5.0, 3.0, -2.0), abs=0.02)


@pytest.mark.parametrize("size", SIZES)
def test_the_middle_of_the_contact_is_drawn_to_where_the_mask_is_sure(size):
    mask = torch.zeros(1, 14, 14)
    mask[0, 3, 4], mask[0, 11, 8] = 0.9, 0.3
    with torch.no_grad():
        geometry = DGR(4).pool(torch.zeros(1, 2, 14, 14, 2), torch.zeros(1, 14, 14, 2), mask)
    rows, columns = filled_size(*size)
    view = View(picture_height_px=rows, picture_width_px=columns)
    # A tenth of the way from the surer patch to the other: by squares nine to one.
    place = np.array([4.5 + 0.4, 3.5 + 0.8]) * 16 - (224 - np.array([columns, rows])) / 2
    expected = place / (columns, rows) * size[::-1]
    assert contact_centre(geometry, view, size) == pytest.approx(tuple(expected), rel=1e-4)
