"""Expected values: the paper's parameter count and Eqs. 2-8 on fields of known motion."""

import pytest
import torch

from geotlm_lm.core.geometry import REGION_COUNT, REGIONS
from geotlm_lm.dgr.encoder import DGR

X, Y = 0, REGION_COUNT


def test_the_three_projections_hold_13827_parameters_at_width_768():
    assert sum(parameter.numel() for parameter in DGR(768).parameters()) == 13_827


def geometry_of(displacement, contact=None):
    """Geometry of a DGR whose shear is the token's first two numbers and whose mask is the third.

    Displacement (gh, gw, 2) enters in the late bin; the grid is not square on purpose.
    """
    gh, gw, _ = displacement.shape
    contact = torch.ones(gh, gw) if contact is None else contact
    patches = torch.zeros(1, 2, gh, gw, 5)
    patches[0, 1, :, :, :2] = displacement
    patches[..., 2] = torch.logit(contact, eps=1e-7)
    dgr = DGR(5)
    with torch.no_grad():
        dgr.to_shear.weight.copy_(torch.eye(5)[:2])
        dgr.to_mask.weight.copy_(torch.eye(5)[2:3])
        dgr.to_shear.bias.zero_()
        dgr.to_mask.bias.zero_()
        return dgr(patches)


def grid(gh=10, gw=8):
    y, x = torch.meshgrid(
        torch.arange(gh) - (gh - 1) / 2, torch.arange(gw) - (gw - 1) / 2, indexing="ij"
    )
    return x, y


def test_a_clockwise_turn_shows_in_opposite_halves_with_opposite_signs():
    x, y = grid()
    clockwise = torch.stack([-y, x], dim=-1)  # x towards y, y down
    r = geometry_of(clockwise).descriptor[0]
    assert r[X + REGIONS.index("upper_minus_lower")] == pytest.approx(5.0, rel=1e-4)
    assert r[Y + REGIONS.index("left_minus_right")] == pytest.approx(-4.0, rel=1e-4)
    assert r[X + REGIONS.index("global")].abs() < 1e-5
    assert r[Y + REGIONS.index("upper_minus_lower")].abs() < 1e-5


def test_a_slide_shows_in_the_means_and_in_no_difference():
    x, _ = grid()
    right = torch.stack([torch.full_like(x, 3.0), torch.zeros_like(x)], dim=-1)
    r = geometry_of(right).descriptor[0]
    assert r[X + REGIONS.index("global")] == pytest.approx(3.0, rel=1e-4)
    assert r[X + REGIONS.index("upper_minus_lower")].abs() < 1e-5


def test_a_mirror_turns_the_sign_of_two_of_the_four_differences():
    # A vector field under a left-right mirror: columns reverse and x changes sign.
    generator = torch.Generator().manual_seed(0)
    field = torch.randn(10, 8, 2, generator=generator)
    mirrored = field.flip(1) * torch.tensor([-1.0, 1.0])
    r, m = geometry_of(field).descriptor[0], geometry_of(mirrored).descriptor[0]
    up, left = REGIONS.index("upper_minus_lower"), REGIONS.index("left_minus_right")
    torch.testing.assert_close(m[X + up], -r[X + up])
    torch.testing.assert_close(m[X + left], r[X + left])
    torch.testing.assert_close(m[Y + up], r[Y + up])
    torch.testing.assert_close(m[Y + left], -r[Y + left])


def test_the_descriptor_has_rank_ten():
    generator = torch.Generator().manual_seed(1)
    rows = [
        geometry_of(
            torch.randn(10, 8, 2, generator=generator), torch.rand(10, 8, generator=generator)
        ).descriptor
        for _ in range(40)
    ]
    assert torch.linalg.matrix_rank(torch.cat(rows).double(), rtol=1e-4) == 10


def test_contact_in_one_corner_shows_as_mass_in_two_halves_only():
    contact = torch.zeros(10, 8)
    contact[:3, :3] = 1.0
    x, _ = grid()
    mass = geometry_of(torch.stack([x, x], dim=-1), contact).region_mass[0]
    assert mass[REGIONS.index("upper")] > 0.2
    assert mass[REGIONS.index("lower")] < 1e-5
    assert mass[REGIONS.index("left_minus_right")] < 1e-5


def test_a_single_time_bin_is_refused():
    with pytest.raises(
        ValueError, match=r"patches are \(b, 2, gh, gw, d\), found \(1, 1, 4, 4, 5\)"
    ):
        DGR(5)(torch.zeros(1, 1, 4, 4, 5))
