"""Muon's steps are orthogonal, of AdamW's size, and go on from a stored state."""

import pytest
import torch

from geotlm_lm.training.muon import Muon, orthogonal


@pytest.mark.parametrize("shape", [(8, 8), (24, 8), (8, 40)])
def test_a_matrix_is_made_orthogonal(shape):
    matrices = torch.randn((2, *shape), generator=torch.Generator().manual_seed(1))
    together = orthogonal(torch.stack([1e-3 * matrices[0], 40 * matrices[1]]))
    assert torch.allclose(together[1:], orthogonal(matrices[1:]), atol=1e-5)
    found = torch.linalg.svdvals(together)
    assert 0.6 < float(found.min()) <= float(found.max()) < 1.3


def _trained(steps, optimiser=None, weights=None):
    generator = torch.Generator().manual_seed(2)
    inputs, wanted = torch.randn(64, 6, generator=generator), torch.randn(6, 4, generator=generator)
    matrix = torch.nn.Parameter(torch.zeros(6, 4))
    shift = torch.nn.Parameter(torch.ones(4))
    if weights is not None:
        matrix.data, shift.data = (one.clone() for one in weights)
    groups = [
        {"params": [matrix], "weight_decay": 0.0, "is_orthogonal": True},
        {"params": [shift], "weight_decay": 0.0},
    ]
    used = Muon(groups, betas=(0.9, 0.98))
    if optimiser is not None:
        used.load_state_dict(optimiser)
    for group in used.param_groups:
        group["lr"] = 0.05
    for _ in range(steps):
        used.zero_grad()
        loss = ((inputs @ (matrix - wanted) + shift) ** 2).mean()
        loss.backward()
        used.step()
    return float(loss.detach()), (matrix.detach(), shift.detach()), used.state_dict()


def test_both_kinds_of_weights_are_learned():
    assert _trained(200)[0] < 0.05 * _trained(1)[0]


def test_a_stored_state_goes_on_as_if_never_stopped():
    _, whole, _ = _trained(20)
    _, weights, state = _trained(10)
    _, resumed, _ = _trained(10, state, weights)
    for one, other in zip(whole, resumed, strict=True):
        assert torch.equal(one, other)
