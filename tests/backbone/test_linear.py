"""Expected values: torch's own linear layer."""

import pytest
import torch
from torch import nn

from geotlm_lm.backbone import linear as engines
from geotlm_lm.backbone.linear import linear


def layer(bias=True):
    torch.manual_seed(0)
    return nn.Linear(160, 96, bias=bias)


@pytest.mark.parametrize("bias", [True, False])
@pytest.mark.parametrize("shape", [(160,), (7, 160), (3, 202, 160), (0, 160), "transposed"])
def test_it_equals_the_layer_but_for_rounding(shape, bias):
    one = layer(bias)
    values = torch.randn(160, 202).T if shape == "transposed" else torch.randn(shape)
    with torch.inference_mode():
        torch.testing.assert_close(linear(one, values), one(values), rtol=1e-5, atol=1e-5)


def test_gradients_are_kept():
    one, values = layer(), torch.randn(5, 160, requires_grad=True)
    linear(one, values).sum().backward()
    expected = one.weight.sum(dim=0).expand(5, -1)
    torch.testing.assert_close(values.grad, expected)


@pytest.mark.skipif(engines._ONEDNN is None, reason="this torch lacks oneDNN's linear product")
def test_plain_layers_go_through_the_faster_engine(monkeypatch):
    monkeypatch.setattr(nn.Linear, "forward", None)
    with torch.inference_mode():
        assert linear(layer(), torch.randn(5, 160)).shape == (5, 96)
