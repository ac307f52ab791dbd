"""Expected values: Eqs. 2-8 on fields of known motion, and the reflection laws of Eqs. 6-7."""

import pytest
import torch

from geotlm_lm.core.geometry import REGION_COUNT, REGIONS
from geotlm_lm.dgr.encoder import DGR
from geotlm_lm.dgr.regions import MASS_FLOOR, pool_regions, region_mass

X, Y = 0, REGION_COUNT


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


def field_and_mask(seed, rows=6, columns=10):
    generator = torch.Generator().manual_seed(seed)
    field = torch.randn(3, rows, columns, generator=generator, dtype=torch.float64)
    mask = torch.rand(3, rows, columns, generator=generator, dtype=torch.float64)
    return field, mask


def pooled_by_name(field, mask):
    return dict(zip(REGIONS, pool_regions(field, mask).unbind(-1), strict=True))


def test_pooling_equals_the_sum_over_cells_written_out():
    field, mask = field_and_mask(1)
    pooled = pooled_by_name(field, mask)
    cells = {
        "upper": [(i, j) for i in range(3) for j in range(10)],
        "lower": [(i, j) for i in range(3, 6) for j in range(10)],
        "left": [(i, j) for i in range(6) for j in range(5)],
        "right": [(i, j) for i in range(6) for j in range(5, 10)],
        "global": [(i, j) for i in range(6) for j in range(10)],
    }
    for name, members in cells.items():
        top = sum(field[:, i, j] * mask[:, i, j] for i, j in members)
        mass = sum(mask[:, i, j] for i, j in members)
        torch.testing.assert_close(pooled[name], top / (mass + MASS_FLOOR))


def test_a_flip_negates_only_the_difference_across_it():
    field, mask = field_and_mask(0)
    pooled = pooled_by_name(field, mask)
    for axis, across in ((1, "upper_minus_lower"), (2, "left_minus_right")):
        flipped = pooled_by_name(field.flip(axis), mask.flip(axis))
        for name in ("upper_minus_lower", "left_minus_right"):
            torch.testing.assert_close(flipped[name], pooled[name] * (-1 if name == across else 1))


@pytest.mark.parametrize(("mask_value", "expected"), [(1.0, 1.0), (1e-6, 0.98990), (1e-8, 0.49495)])
def test_the_mass_floor_shrinks_a_unit_field_under_a_faint_mask(mask_value, expected):
    # Closed form for the half of a 14 x 14 grid: 98 m / (98 m + 1e-6).
    field = torch.ones(1, 14, 14, dtype=torch.float64)
    pooled = pooled_by_name(field, torch.full_like(field, mask_value))
    assert pooled["upper"].item() == pytest.approx(expected, abs=1e-4)


def test_an_empty_half_pools_to_zero_and_shows_no_mass():
    field, mask = field_and_mask(0)
    mask[:, 3:] = 0
    assert pooled_by_name(field, mask)["lower"].abs().max() == 0
    mass = dict(zip(REGIONS, region_mass(mask).unbind(-1), strict=True))
    assert mass["lower"].max() == 0
    assert mass["upper_minus_lower"].max() == 0
    assert mass["upper"].min() > 0
