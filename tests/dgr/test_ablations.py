"""Expected values: the full DGR, closed forms of linear fields, and counted parameters."""

import pytest
import torch

from geotlm_lm.core.geometry import REGION_COUNT, REGIONS
from geotlm_lm.dgr.ablations import OPERATORS, AblatedDGR, DGRParts, differential_operators
from geotlm_lm.dgr.encoder import DGR
from geotlm_lm.dgr.regions import MASS_FLOOR

GLOBAL = REGIONS.index("global")


def patches(seed=0):
    generator = torch.Generator().manual_seed(seed)
    return torch.randn(3, 2, 6, 10, 5, generator=generator)


def ablated(**parts):
    torch.manual_seed(0)
    return AblatedDGR(5, 7, DGRParts(**parts))


def test_all_parts_of_the_paper_are_dgr_itself():
    torch.manual_seed(0)
    full, same = DGR(5, 7), ablated()
    same.load_state_dict(full.state_dict())
    for name, value in vars(full(patches())).items():
        assert torch.equal(getattr(same(patches()), name), value)


def test_without_the_mask_every_patch_weighs_the_same():
    dgr, tokens = ablated(mask=False), patches()
    found = dgr(tokens)
    assert torch.equal(found.mask, torch.ones(3, 6, 10))
    upper = found.shear_change[:, :3, :, 0].sum(dim=(1, 2)) / (30 + MASS_FLOOR)
    torch.testing.assert_close(found.descriptor[:, 0], upper)
    assert not any(name.startswith("to_mask") for name in dgr.state_dict())


def test_without_regions_the_descriptor_is_the_mean_over_the_whole_contact():
    dgr, full = ablated(regions=False), ablated()
    full.load_state_dict(dgr.state_dict() | {"to_feature.weight": full.to_feature.weight})
    found, whole = dgr(patches()), full(patches()).descriptor
    torch.testing.assert_close(found.descriptor, whole[:, [GLOBAL, REGION_COUNT + GLOBAL]])


def test_there_are_as_many_parameters_as_the_paper_counts():
    # W_s 1538, W_m 769, W_o (14 + 1) x 768.
    assert sum(p.numel() for p in AblatedDGR(768, None, DGRParts()).parameters()) == 13_827


def test_every_parameter_there_is_is_trained():
    for parts in (DGRParts(mask=False), DGRParts(regions=False), DGRParts(operators=True)):
        dgr = AblatedDGR(5, 7, parts)
        dgr(patches()).feature.square().sum().backward()
        assert all(p.grad is not None for p in dgr.parameters())


def test_operators_are_pooled_behind_what_they_are_of():
    plain, more = ablated(), ablated(operators=True)
    feature = {f"to_feature.{n}": v for n, v in more.to_feature.state_dict().items()}
    more.load_state_dict(plain.state_dict() | feature)
    found = more(patches())
    assert torch.equal(found.descriptor[:, :14], plain(patches()).descriptor)
    assert found.descriptor.shape == (3, 14 + 7 * len(OPERATORS))


def linear_field(matrix, rows=6, columns=9):
    y, x = torch.meshgrid(torch.arange(rows), torch.arange(columns), indexing="ij")
    place = torch.stack([x, y], dim=-1).double()
    return (place @ torch.tensor(matrix, dtype=torch.float64).T)[None]


@pytest.mark.parametrize(
    ("matrix", "expected"),
    [
        # Rows are d(x component), d(y component) by x and y: exact for central differences.
        ([[0.0, -3.0], [3.0, 0.0]], {"curl": 6.0}),  # clockwise as drawn
        ([[2.0, 0.0], [0.0, 2.0]], {"divergence": 4.0}),
        ([[2.0, 0.0], [0.0, -2.0]], {"stretch": 4.0}),
        ([[0.0, 1.5], [1.5, 0.0]], {"shear_strain": 3.0}),
    ],
)
def test_an_operator_of_a_linear_field_is_its_closed_form_everywhere(matrix, expected):
    found = differential_operators(linear_field(matrix))[0]
    for number, name in enumerate(OPERATORS):
        constant = torch.full((6, 9), expected.get(name, 0.0), dtype=torch.float64)
        torch.testing.assert_close(found[..., number], constant)
