"""What else reads a clip: both beside each other, of the clip as it was."""

import pytest

from geotlm_lm.core.labels import Motion
from geotlm_lm.reference_readings import second_opinions
from tests.app.fakes import FakeAnswerer
from tests.probe.imprints import moved_clip, textured_imprint


@pytest.mark.parametrize(("step", "motion"), [(3.0, Motion.RIGHT), (-3.0, Motion.LEFT)])
def test_flow_and_probe_each_say_what_they_read(step, motion):
    answerer = FakeAnswerer()
    clip = moved_clip(textured_imprint(1), [0] * 4, [(step * k, 0.0) for k in range(4)])
    found = second_opinions(answerer, answerer.encode(clip)).to_dict()
    assert found["optical_flow"]["motion"] == motion.value
    assert found["optical_flow"]["slide_x_px"] == pytest.approx(3 * step, rel=0.1)
    assert found["probe"] == {"motion": "right", "probability": 0.9}  # whatever there is
