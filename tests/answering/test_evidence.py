"""The regions beside an answer are those of the field it was pooled from, each by its own name."""

import pytest
import torch

from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.evidence_of import regions_of as evidence
from geotlm_lm.backbone.view import View
from geotlm_lm.core.geometry import REGIONS
from geotlm_lm.dgr.encoder import DGR
from geotlm_lm.model import Perception
from tests.answering.scripted import recording


def test_every_region_has_its_own_means_of_the_shear_change():
    field = torch.zeros(1, 14, 14, 2)
    field[:, :7, :, 0] = 1.0  # the upper half goes to the right
    field[:, :, :7, 1] = -2.0  # and the left one up
    with torch.no_grad():
        mask = torch.full((1, 14, 14), 0.25)
        geometry = DGR(4).pool(torch.zeros(1, 2, 14, 14, 2), field, mask)
    token = torch.zeros(1, 4)
    clip = Encoded(recording(), Perception(token, geometry, token, (View(),), None), {})
    regions = evidence(clip)["regions"]
    assert tuple(regions) == REGIONS
    means = {name: (one["shear_change_x"], one["shear_change_y"]) for name, one in regions.items()}
    assert means == {
        "upper": pytest.approx((1.0, -1.0)),
        "lower": pytest.approx((0.0, -1.0)),
        "upper_minus_lower": pytest.approx((1.0, 0.0)),
        "left": pytest.approx((0.5, -2.0)),
        "right": pytest.approx((0.5, 0.0)),
        "left_minus_right": pytest.approx((0.0, -2.0)),
        "global": pytest.approx((0.5, -1.0)),
    }
    assert {one["contact_mass"] for one in regions.values()} == {0.25}
