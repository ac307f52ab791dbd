"""Expected values: closed forms, and scikit-learn's solution of the same logistic loss."""

import numpy as np
import pytest
import torch

from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion
from geotlm_lm.probe.linear import LinearProbe, fit_logistic
from geotlm_lm.probe.standardise import Standardiser

LABELS = (Motion.STILL, Motion.CLOCKWISE, Motion.LEFT)


@pytest.fixture
def identity_probe():
    """Logits equal the token, so every prediction can be read off."""
    probe = LinearProbe(3, LABELS)
    with torch.no_grad():
        probe.head.weight.copy_(torch.eye(3))
        probe.head.bias.zero_()
    return probe


def test_the_largest_logit_wins_among_the_asked_motions(identity_probe):
    tokens = torch.tensor([[9.0, 1.0, 2.0], [0.0, 1.0, 2.0]])
    assert identity_probe.predict(tokens) == [Motion.STILL, Motion.LEFT]
    asked = (Motion.LEFT, Motion.CLOCKWISE)
    assert identity_probe.predict(tokens + torch.tensor([0, 2.0, 0]), asked) == [asked[1]] * 2


def test_probabilities_follow_the_order_asked_and_the_odds_of_the_logits(identity_probe):
    found = identity_probe.probabilities(
        torch.tensor([[5.0, 1.0, 2.0]]), (Motion.LEFT, Motion.CLOCKWISE)
    )
    odds = torch.e
    assert found[0].tolist() == pytest.approx([odds / (1 + odds), 1 / (1 + odds)])


def test_an_unknown_motion_is_refused_by_name(identity_probe):
    with pytest.raises(ValueError, match="'press'"):
        identity_probe.predict(torch.zeros(1, 3), (Motion.PRESS,))


def rows_of(labels, count=90, width=3, seed=0):
    rng = np.random.default_rng(seed)
    codes = np.arange(count) % len(labels)
    means = rng.standard_normal((len(labels), width))
    features = means[codes] + rng.standard_normal((count, width))
    return torch.from_numpy(features), [labels[code] for code in codes]


@pytest.mark.parametrize(("labels", "penalty"), [(ROTATIONS, 1.0), (SLIDES, 20.0)])
def test_the_probabilities_are_those_of_scikit_learn(labels, penalty):
    linear_model = pytest.importorskip("sklearn.linear_model", reason="needs the extra eval")
    features, motions = rows_of(labels)
    fitted = fit_logistic(features, motions, labels, penalty=penalty)
    # scikit-learn weighs one line between two classes, where a softmax has two opposite ones.
    strength = (2 if len(labels) == 2 else 1) / penalty
    other = linear_model.LogisticRegression(C=strength, tol=1e-10, max_iter=1000)
    other.fit(features.numpy(), [labels.index(motion) for motion in motions])
    expected = torch.from_numpy(other.predict_proba(features.numpy())).float()
    found = fitted.probabilities(features.float(), labels)
    torch.testing.assert_close(found, expected, atol=2e-5, rtol=0)


def test_separable_rows_are_told_apart_and_the_weights_stay_finite():
    features = torch.tensor([[-1.0], [-2.0], [1.0], [2.0]])
    motions = [ROTATIONS[0]] * 2 + [ROTATIONS[1]] * 2
    probe = fit_logistic(features, motions, ROTATIONS)
    assert probe.predict(features) == motions
    assert bool(torch.isfinite(probe.head.weight).all())
    with pytest.raises(ValueError, match="not in list"):
        fit_logistic(torch.zeros(1, 1), [SLIDES[0]], ROTATIONS)


def test_a_constant_feature_becomes_zero_and_never_infinite():
    rows = torch.tensor([0.0, 3.3, 1e6]).expand(10, 3)
    assert torch.equal(Standardiser.fit(rows).apply(rows), torch.zeros(10, 3))


def test_a_large_offset_does_not_hide_a_small_signal():
    signal = torch.arange(64, dtype=torch.float64)[:, None]
    fitted = Standardiser.fit(1e4 + signal)
    # Closed form: the standard deviation of 0..n-1 is sqrt((n^2 - 1) / 12).
    deviation = ((64**2 - 1) / 12) ** 0.5
    torch.testing.assert_close(fitted.apply(1e4 + signal), (signal - 31.5) / deviation)


def test_rows_are_required():
    with pytest.raises(ValueError, match="expected features"):
        Standardiser.fit(torch.zeros(0, 3))
