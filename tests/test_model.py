"""The middle of a contact, told in the recording's own pixels."""

import numpy as np
import pytest
import torch

from geotlm_lm.backbone.view import View
from geotlm_lm.core.geometry import filled_size
from geotlm_lm.dgr.encoder import DGR
from geotlm_lm.model import contact_centre

SIZES = [(240, 320), (320, 240), (480, 640), (240, 240), (1080, 1920)]


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
