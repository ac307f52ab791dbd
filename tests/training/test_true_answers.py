"""What is told of a clip is true where what was simulated tells it too, or nearly."""

import numpy as np
import pytest

from geotlm_lm.answering.pipeline import Worded
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.query.answers import answers
from geotlm_lm.query.evaluate import Evidence
from geotlm_lm.query.lines import read
from geotlm_lm.query.telling import Teller
from geotlm_lm.query.values import Recording
from geotlm_lm.query.worlds import worlds_of_clip
from geotlm_lm.query.written import worded
from geotlm_lm.training.true_answers import TrueAnswers, is_true, tells, true_belief
from tests.answering.scripted import believed

FRAME = FrameSpec()


def label(deg=12.0, travel_px=(0.0, 0.0), mm=0.0, **changes):
    """A clip that turns clockwise, slides and is pressed so far."""
    parts = {"contact_fraction": (0.1,) * 4, "radius_px": 60.0, **changes}
    return MotionLabel(
        Motion.CLOCKWISE, rotation_deg=deg, travel_px=travel_px, depth_change_mm=mm, **parts
    )


def agrees(query, truth, *ways, **far):
    """Whether what is told of a belief is true by a label."""
    evidence = Evidence(worlds_of_clip(believed(*ways, **far)), Recording(rate_hz=25.0))
    program = read(query)
    values = answers(program, (evidence,), FRAME)
    teller = Teller(evidence.recording, FRAME)
    told = Worded(values, worded(values, program.form, teller), teller, 1.0, (False,) * len(values))
    return TrueAnswers.of(evidence, truth).agree(told, program, FRAME)


@pytest.mark.parametrize(
    ("query", "truth", "is_so"),
    [
        ("way turn", label(), True),
        ("way turn", label(-12.0), False),
        ("way all", label(travel_px=(2.0, 0.0)), True),  # the lesser motion may be left out
        ("way all", label(travel_px=(40.0, 0.0)), False),
        ("turn", label(0.0), False),
        ("slide", label(), True),
        ("slide", label(travel_px=(40.0, 0.0)), False),
        ("slide", label(travel_px=(0.1, 0.0)), True),  # too little to be graded
        ("amount turn", label(13.5), True),
        ("amount turn", label(20.0), False),
        ("chance cw", label(), True),
        ("sure", label(), True),
        ("sure", label(-12.0), False),
        ("> amount turn 10", label(), True),
        ("touch", label(), True),
        ("touch", label(contact_fraction=(0.0,) * 4), False),
        ("choose A cw | B ccw", label(), True),
        ("choose A cw | B ccw", label(-12.0), False),
        ("record turn , slide end ; as json", label(), True),
        ("record turn , slide end ; as json", label(0.0, (40.0, 0.0)), False),
        ("file rate", label(-12.0), True),
        ("mirror way turn", label(), True),
        ("begin first turn-events", label(-12.0), True),  # that it cannot be told is no lie
    ],
)
def test_of_a_belief_of_twelve_degrees_is_told_what(query, truth, is_so):
    assert agrees(query, truth, "clockwise", deg=12.0) == is_so


@pytest.mark.parametrize(("ways", "chances"), [(("clockwise",), 0.0), (("clockwise", "left"), 1.0)])
def test_what_is_not_graded_is_taken_as_it_is_believed(ways, chances):
    belief = true_belief(believed(*ways), label(travel_px=(0.1, 0.0), mm=0.03))
    assert belief.ways[Motion.CLOCKWISE] == 1.0
    assert belief.ways[Motion.RIGHT] == chances  # its own way all the same
    assert belief.ways[Motion.LEFT] == belief.ways[Motion.PRESS] == 0.0


def test_a_record_of_nothing_tells_nothing():
    evidence = Evidence(worlds_of_clip(believed("left")))
    program = read("record begin first turn-events , end first turn-events end ; slide")
    nothing, slides = answers(program, (evidence,), FRAME)
    assert not tells(nothing)
    assert tells(slides)
    assert is_true(slides, slides)
    assert not np.isnan(slides.chance)
