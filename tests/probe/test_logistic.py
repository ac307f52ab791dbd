"""Expected values: scikit-learn's logistic regression, an independent solution of the same loss."""

import numpy as np
import pytest
import torch

from geotlm_lm.core.labels import ROTATIONS, SLIDES
from geotlm_lm.probe.logistic import fit_logistic


def rows_of(labels, count=90, width=3, seed=0):
    rng = np.random.default_rng(seed)
    codes = np.arange(count) % len(labels)
    means = rng.standard_normal((len(labels), width))
    features = means[codes] + rng.standard_normal((count, width))
    return torch.from_numpy(features), [labels[code] for code in codes]


@pytest.mark.parametrize("labels", [ROTATIONS, SLIDES])
@pytest.mark.parametrize("penalty", [1.0, 20.0])
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


def test_a_motion_outside_the_labels_is_refused():
    with pytest.raises(ValueError, match="not in list"):
        fit_logistic(torch.zeros(1, 1), [SLIDES[0]], ROTATIONS)
