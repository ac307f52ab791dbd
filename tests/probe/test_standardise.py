import pytest
import torch

from geotlm_lm.probe.standardise import Standardiser


def test_training_rows_come_out_with_mean_zero_and_spread_one():
    rows = torch.randn(200, 5, generator=torch.Generator().manual_seed(0)) * 7 + 3
    out = Standardiser.fit(rows).apply(rows)
    assert torch.allclose(out.mean(0), torch.zeros(5), atol=1e-6)
    assert torch.allclose(out.std(0, unbiased=False), torch.ones(5), atol=1e-6)


def test_other_rows_do_not_change_the_statistics():
    rows = torch.randn(50, 4, generator=torch.Generator().manual_seed(1))
    fitted = Standardiser.fit(rows)
    before = (fitted.mean.clone(), fitted.scale.clone())
    fitted.apply(rows * 100 + 5)
    assert torch.equal(fitted.mean, before[0])
    assert torch.equal(fitted.scale, before[1])


@pytest.mark.parametrize("constant", [0.0, 3.3, 1e6])
def test_a_constant_feature_becomes_zero_and_never_infinite(constant):
    rows = torch.full((10, 1), constant)
    assert torch.equal(Standardiser.fit(rows).apply(rows), torch.zeros(10, 1))


def test_a_large_offset_does_not_hide_a_small_signal():
    signal = torch.arange(64, dtype=torch.float64)[:, None]
    fitted = Standardiser.fit(1e4 + signal)
    # Closed form: the standard deviation of 0..n-1 is sqrt((n^2 - 1) / 12).
    assert fitted.scale.item() == pytest.approx(((64**2 - 1) / 12) ** 0.5)


def test_state_round_trips():
    fitted = Standardiser.fit(torch.randn(9, 3, generator=torch.Generator().manual_seed(2)))
    again = Standardiser.from_state(fitted.state())
    assert torch.equal(again.mean, fitted.mean)
    assert torch.equal(again.scale, fitted.scale)


@pytest.mark.parametrize("shape", [(0, 3), (3,)])
def test_rows_are_required(shape):
    with pytest.raises(ValueError, match="expected features"):
        Standardiser.fit(torch.zeros(shape))
