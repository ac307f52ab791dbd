import pytest
import torch

from geotlm_lm.core.labels import Motion
from geotlm_lm.probe.linear import LinearProbe

LABELS = (Motion.STILL, Motion.CLOCKWISE, Motion.LEFT)


@pytest.fixture
def identity_probe():
    """Logits equal the token, so every prediction can be read off."""
    probe = LinearProbe(3, LABELS)
    with torch.no_grad():
        probe.head.weight.copy_(torch.eye(3))
        probe.head.bias.zero_()
    return probe


def test_the_largest_logit_wins(identity_probe):
    tokens = torch.tensor([[9.0, 1.0, 2.0], [0.0, 1.0, 2.0]])
    assert identity_probe.predict(tokens) == [Motion.STILL, Motion.LEFT]


def test_only_the_asked_motions_compete(identity_probe):
    tokens = torch.tensor([[9.0, 1.0, 2.0], [9.0, 3.0, 2.0]])
    asked = (Motion.LEFT, Motion.CLOCKWISE)
    assert identity_probe.predict(tokens, asked) == [Motion.LEFT, Motion.CLOCKWISE]


def test_probabilities_follow_the_order_asked_and_the_odds_of_the_logits(identity_probe):
    found = identity_probe.probabilities(
        torch.tensor([[5.0, 1.0, 2.0]]), (Motion.LEFT, Motion.CLOCKWISE)
    )
    odds = torch.e
    assert found[0].tolist() == pytest.approx([odds / (1 + odds), 1 / (1 + odds)])


def test_an_unknown_motion_is_refused_by_name(identity_probe):
    with pytest.raises(ValueError, match="'press'"):
        identity_probe.predict(torch.zeros(1, 3), (Motion.PRESS,))
