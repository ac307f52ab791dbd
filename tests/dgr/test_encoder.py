"""Expected values: Eqs. 2-8 on fields of known motion."""

import pytest
import torch

from geotlm_lm.core.geometry import REGION_COUNT, REGIONS
from geotlm_lm.dgr.encoder import DGR
from geotlm_lm.dgr.regions import MASS_FLOOR, pool_regions, region_mass

X, Y = 0, REGION_COUNT


def test_a_clockwise_turn_shows_in_opposite_halves_with_opposite_signs():
    """Shear is the token's first two numbers, which turn in the late bin; its third is contact."""
    y, x = torch.meshgrid(torch.arange(10) - 4.5, torch.arange(8) - 3.5, indexing="ij")
    patches = torch.zeros(1, 2, 10, 8, 5)
    patches[0, 1, :, :, :2] = torch.stack([-y, x], dim=-1)  # x towards y, y down
    patches[..., 2] = 16.0
    dgr = DGR(5)
    with torch.no_grad():
        dgr.to_shear.weight.copy_(torch.eye(5)[:2])
        dgr.to_mask.weight.copy_(torch.eye(5)[2:3])
        dgr.to_shear.bias.zero_()
        dgr.to_mask.bias.zero_()
        r = dgr(patches).descriptor[0]
    assert r[X + REGIONS.index("upper_minus_lower")] == pytest.approx(5.0, rel=1e-4)
    assert r[Y + REGIONS.index("left_minus_right")] == pytest.approx(-4.0, rel=1e-4)
    assert r[X + REGIONS.index("global")].abs() < 1e-5
    assert r[Y + REGIONS.index("upper_minus_lower")].abs() < 1e-5


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
    for first, second in (("upper", "lower"), ("left", "right")):
        difference = pooled[f"{first}_minus_{second}"]
        torch.testing.assert_close(difference, pooled[first] - pooled[second])


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
