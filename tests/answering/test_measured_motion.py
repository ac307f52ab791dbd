"""A belief in the units that what is known of the recording allows, and amounts told of it."""

import re
from dataclasses import replace

import numpy as np
import pytest

from geotlm_lm.answering.measured_motion import felt_of, measured
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import Component, Twist
from geotlm_lm.motion.belief import Belief
from tests.answering.scripted import answerer_saying, believed, feeling, measuring, recording

CAMERA = FrameSpec()
MIXED = believed("clockwise", "left", deg=20.0, px=20.0)


def sliding(bundle, size, way, px=14.0):
    """A clip believed to slide by `px` pixels of the 224-pixel image along a unit vector."""
    right, down = px * np.array(way)
    plain = believed("right")
    mean = Twist(right_px=right, down_px=down)
    belief = Belief(mean, np.eye(4) * 0.09, plain.ways, 1.0, 60.0, plain.readable)
    encoded = answerer_saying(bundle, {}, belief=belief).encode(recording(size=size))
    return replace(encoded, is_untouched=False)  # noise on so many pixels


@pytest.mark.parametrize(
    ("size", "way", "factor"),
    [
        ((224, 224), (1.0, 0.0), 1.0),
        ((480, 640), (1.0, 0.0), 640 / 224),
        ((480, 640), (0.0, -1.0), 480 / 224),
        ((480, 640), (0.6, 0.8), np.hypot(0.6 * 640, 0.8 * 480) / 224),
        # Idle gel fills up a square that a portrait picture leaves.
        ((320, 240), (1.0, 0.0), 240 / 126),
        ((320, 240), (0.0, 1.0), 320 / 224),
    ],
)
def test_without_a_scale_a_slide_is_told_in_the_recordings_own_pixels(bundle, size, way, factor):
    found = measured(sliding(bundle, size, way), Component.SLIDE, CAMERA)
    assert found.unit == "px"
    assert found.mean == pytest.approx(14 * factor)
    assert (found.deviation, found.tolerance) == pytest.approx((0.3 * factor, 2 * factor), rel=0.1)


@pytest.mark.parametrize(
    ("size", "way", "mm_per_224_px"),
    [
        # A 224-pixel image was squashed from a camera of four to three: 10 of its pixels across are
        # as wide as 13.3 are high.
        ((224, 224), (1.0, 0.0), 0.1),
        ((224, 224), (0.0, 1.0), 0.075),
        ((240, 320), (0.0, 1.0), 0.1 * 240 / 224),
        ((400, 400), (0.0, 1.0), 0.1 * 400 / 224),
    ],
)
def test_with_a_scale_it_is_told_in_millimetres(bundle, size, way, mm_per_224_px):
    found = measured(sliding(bundle, size, way), Component.SLIDE, FrameSpec(mm_per_px=0.1))
    assert (found.unit, found.mean) == ("mm", pytest.approx(14 * mm_per_224_px))


@pytest.mark.parametrize(
    ("frame", "parts"),
    [
        ({}, "+16 in x and -12 in y"),
        ({"image_mirrored": True}, "-16 in x and -12 in y"),
        ({"actor": "sensor"}, "-16 in x and +12 in y"),
        ({"image_upside_down": True}, "-16 in x and +12 in y"),
        ({"image_quarter_turn": "clockwise"}, "-12 in x and -16 in y"),
    ],
)
def test_parts_are_told_in_the_frame(bundle, frame, parts):
    answerer = answerer_saying(bundle, {"*": "An amount of sliding, as measured."})
    encoded = sliding(bundle, (224, 224), (0.8, -0.6), 20.0)
    answerer.belief = encoded.belief
    answer = answerer.ask(encoded, "How much in x and in y?", frame=FrameSpec(**frame))
    assert parts in answer.text
    assert answer.text.endswith("likely 19 to 21.")


def test_of_one_axis_its_own_part_is_told(bundle):
    encoded = sliding(bundle, (224, 224), (0.8, -0.6), 20.0)
    across, down = (measured(encoded, Component.SLIDE, CAMERA, axis).mean for axis in (0, 1))
    assert (across, down) == pytest.approx((16.0, 12.0))


def test_pixels_are_named_and_what_millimetres_take(bundle):
    answerer = measuring(bundle, "left")
    seen = answerer.encode(recording())
    answer = answerer.ask(seen, "How far?")
    assert re.match("About .+ pixels of sliding", answer.text)
    assert any("64x48 frames" in note and "mm per pixel" in note for note in answer.notes)
    asked_for = answerer.ask(seen, "How many mm did it go?")
    assert asked_for.text.endswith(" In millimetres only if you tell me the size of a pixel.")
    told = answerer.ask(seen, "0.06 mm per pixel. How many mm did it go?")
    assert told.amount.unit == "mm"
    assert not any("pixel" in note for note in told.notes)


def test_a_speed_is_told_by_the_frame_as_its_amount_is(bundle):
    answerer = measuring(bundle, "clockwise", deg=30.0)
    for fps in (2.0, 50.0):
        seen = answerer.encode(recording(fps=fps))
        asked = ("How far per frame?", "How fast?", "How fast, in degrees per frame?")
        far, fast, by_frame = (
            float(re.findall(r"(?:About|That is) ([\d.]+)", answerer.ask(seen, one).text)[-1])
            for one in asked
        )
        assert by_frame == pytest.approx(fast / fps, rel=0.05)
        assert by_frame == pytest.approx(far, rel=0.1)


def test_all_that_counts_is_told_the_larger_first_with_amounts(bundle):
    answerer = feeling(bundle, "clockwise", belief=MIXED)
    encoded = answerer.encode(recording(size=(224, 224)))
    for asked in ("What happens?", "Which way is it moving?"):
        answer = answerer.ask(encoded, asked)
        assert answer.text == (
            "It turns clockwise, about 20 degrees, and slides left, about 8 px, "
            "in the camera image."
        )
        assert (answer.direction, answer.told_by) == (Motion.CLOCKWISE, "rule")
    far = answerer.ask(encoded, "How far did it go?")
    assert far.text.startswith("About 20 degrees of turning, likely 18 to 22. About 8 pixels of")
    assert far.decided == "20 deg"
    assert answerer.ask(encoded, "How far did it slide?").decided == "8 px"


def test_what_the_picture_does_not_tell_is_withheld(bundle):
    belief = believed("left")
    belief.readable[Component.SLIDE] = False
    answerer = feeling(bundle, "left", belief=belief)
    encoded = answerer.encode(recording())
    answer = answerer.ask(encoded, "How far did it slide?")
    assert answer.text == "It slides; how far along the edge cannot be seen."
    assert (answer.abstained, answer.amount) == (True, None)
    opened = answerer.ask(encoded, "Which way does it go?")
    assert opened.text == (
        "It slides left in the camera image; how far along the edge cannot be seen."
    )
    assert not opened.motion.to_dict()["slide"]["readable"]


def test_how_deep_it_presses_is_told(bundle):
    answerer = feeling(bundle, "press", belief=believed("press", mm=0.4))
    answer = answerer.ask(answerer.encode(recording()), "How hard is it pressed?")
    assert answer.text == "About 0.4 millimetres of pressing in, likely 0.3 to 0.5."
    assert answer.amount.unit == "mm"
    other = feeling(bundle, "left")
    denied = other.ask(other.encode(recording()), "How deep does it press in?")
    assert denied.text.startswith("It does not press in or lift off; it slides left")


def test_a_slide_between_two_ways_is_told_so(bundle):
    encoded = sliding(bundle, (224, 224), (0.8, -0.6))
    assert felt_of(encoded).aslant is Motion.UP
    assert felt_of(sliding(bundle, (224, 224), (0.98, -0.2))).aslant is None
