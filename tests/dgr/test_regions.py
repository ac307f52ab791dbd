"""Expected values: closed forms of Eq. 5 and the reflection laws of Eqs. 6-7."""

import pytest
import torch

from geotlm_lm.core.geometry import REGIONS
from geotlm_lm.dgr.regions import MASS_FLOOR, pool_regions, region_mass


def field_and_mask(seed, rows=6, columns=10):
    generator = torch.Generator().manual_seed(seed)
    field = torch.randn(3, rows, columns, generator=generator, dtype=torch.float64)
    mask = torch.rand(3, rows, columns, generator=generator, dtype=torch.float64)
    return field, mask


def pooled_by_name(field, mask):
    return dict(zip(REGIONS, pool_regions(field, mask).unbind(-1), strict=True))


@pytest.mark.parametrize("seed", range(3))
def test_pooling_equals_the_sum_over_cells_written_out(seed):
    field, mask = field_and_mask(seed)
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


@pytest.mark.parametrize("seed", range(3))
def test_flipping_rows_negates_only_the_vertical_difference(seed):
    field, mask = field_and_mask(seed)
    pooled, flipped = pooled_by_name(field, mask), pooled_by_name(field.flip(1), mask.flip(1))
    torch.testing.assert_close(flipped["upper_minus_lower"], -pooled["upper_minus_lower"])
    torch.testing.assert_close(flipped["left_minus_right"], pooled["left_minus_right"])


@pytest.mark.parametrize("seed", range(3))
def test_flipping_columns_negates_only_the_horizontal_difference(seed):
    field, mask = field_and_mask(seed)
    pooled, flipped = pooled_by_name(field, mask), pooled_by_name(field.flip(2), mask.flip(2))
    torch.testing.assert_close(flipped["left_minus_right"], -pooled["left_minus_right"])
    torch.testing.assert_close(flipped["upper_minus_lower"], pooled["upper_minus_lower"])


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
