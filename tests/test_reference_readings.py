"""What else reads a clip: both beside each other, of the clip as it was."""

import pytest

from geotlm_lm.answering import Answerer
from geotlm_lm.core.labels import Motion
from geotlm_lm.reference_readings import second_opinions
from tests.probe.imprints import moved_clip, textured_imprint


@pytest.mark.parametrize(("step", "motion"), [(3.0, Motion.RIGHT), (-3.0, Motion.LEFT)])
def test_flow_and_probe_each_say_what_they_read(bundle, step, motion):
    answerer = Answerer(bundle)
    clip = moved_clip(textured_imprint(1), [0] * 4, [(step * k, 0.0) for k in range(4)])
    encoded = answerer.encode(clip)
    found = second_opinions(answerer, encoded).to_dict()
    assert found["optical_flow"]["motion"] == motion.value
    assert found["optical_flow"]["slide_x_px"] == pytest.approx(3 * step, rel=0.1)
    probe, motions = bundle.model.probe, tuple(Motion)
    odds = probe.probabilities(encoded.perception.fused_token, motions)[0].tolist()
    assert found["probe"] == {
        "motion": motions[odds.index(max(odds))].value,
        "probability": pytest.approx(max(odds), abs=1e-4),
    }
