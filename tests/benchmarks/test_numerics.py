"""Numerics of the pooling, and the same model in other number formats; weights are random."""

import numpy as np
import pytest
import torch

from geotlm_lm.benchmarks.judging import Case
from geotlm_lm.benchmarks.numerics import MASKS, contact_rows, format_rows
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import Motion
from geotlm_lm.dgr.encoder import DGR


@pytest.fixture(scope="module")
def cases():
    idle = np.full((48, 48, 3), 100, np.uint8)
    frames = np.repeat(idle[None], 4, axis=0)
    frames[:, 20:28, 10:20] = 140
    return [Case(Clip(frames, background=idle), Motion.RIGHT, "block", "block", {})]


def test_the_floor_shrinks_as_its_closed_form_says_and_the_mass_undoes_it():
    for mask, row in zip(MASKS, contact_rows(), strict=True):
        # 196 cells of the mask over themselves and the floor.
        assert row.detail["pooled"] == pytest.approx(196 * mask / (196 * mask + 1e-6), rel=1e-5)
        assert row.detail["recovered"] == pytest.approx(1.0, rel=1e-5)
        assert row.detail["its_mass"] == 0
    assert next(contact_rows()).detail["empty_half"] == pytest.approx(-1.0, rel=1e-5)


def test_gradients_stay_bounded_by_the_logit_while_contact_vanishes():
    first, second, last = (row.detail for row in contact_rows((1e-3, 1e-4, 1e-12)))
    assert last["by_logit"] < 1e-3 * first["by_logit"]  # 98e-12 against a floor of 1e-6
    # By the mask itself it grows tenfold a decade until the floor holds it.
    assert second["by_mask"] / first["by_mask"] == pytest.approx(10, rel=0.2)


@pytest.mark.parametrize("mask", [1e-3, 1e-12])
def test_the_gradient_of_dgr_agrees_with_central_differences_under_faint_contact(mask):
    generator = torch.Generator().manual_seed(0)
    dgr = DGR(6).double()
    with torch.no_grad():
        for parameter in dgr.parameters():
            parameter.normal_(0.0, 0.5, generator=generator)
        # Noise on the mask's logit, so that the cells differ; its middle gives `mask`.
        dgr.to_mask.weight.mul_(0.1)
        dgr.to_mask.bias.fill_(float(torch.logit(torch.tensor(mask, dtype=torch.float64))))
    patches = torch.randn((1, 2, 4, 4, 6), generator=generator, dtype=torch.float64)
    patches.requires_grad_(True)
    assert torch.autograd.gradcheck(lambda tokens: dgr(tokens).feature, patches)


def test_coarser_formats_err_more(tiny_answerer, cases):
    rows = [row for row in format_rows(tiny_answerer, cases) if row.case == "geometry"]
    errors = {row.variant: row.error for row in rows}
    assert 0 == errors["float64"] < errors["float32"] < errors["float16"] < errors["bfloat16"]
    assert errors["float32"] < 1e-4
