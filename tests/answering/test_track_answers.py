"""What only a whole recording tells, from a track that is written down."""

from dataclasses import replace

import pytest

from geotlm_lm.answering import Answerer
from geotlm_lm.conversation.wording import capitalised
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from tests.answering import scripted
from tests.track.tracks import happened, track_of_events

EVENTS = [
    happened("touch", 10, 10),
    happened("press", 10, 20, inward=0.5),
    happened("turn", 25, 45, turn=40),
    happened("stick", 46, 60),
    happened("turn", 61, 80, turn=-25),
    happened("slip", 61, 80, turn=-25, of="turn"),
    happened("slide", 85, 95, right=-12),
    happened("release", 98, 102, inward=-0.5),
]
"""Clockwise by 40 degrees, held, back by 25, left by 12 px, 3.4 of the recording's."""

RECORDING = scripted.recording(125, fps=25.0)


def encoded(answerer, events=EVENTS, clip=RECORDING, **options):
    return answerer.encode(clip, track=track_of_events(events), **options)


@pytest.fixture(scope="module")
def answerer(bundle):
    return Answerer(bundle)


@pytest.fixture(scope="module")
def whole(answerer):
    return encoded(answerer)


TOUCHED = "It touches at 0.4 s and presses in, about 0.5 mm, until 0.8 s"
TURNED = "it turns clockwise, about 40 degrees, from 1.0 s to 1.8 s"
BACK = "it turns counterclockwise, about 25 degrees, from 2.4 s to 3.2 s"
SLID = "it slides left, about 3.4 px, from 3.4 s to 3.8 s"
LIFTED = "it lifts off, from 3.9 s to 4.1 s"
IMAGE = ", in the camera image"

TOLD = {
    "What happened?": f"{TOUCHED}, then {TURNED}, then {BACK}, then {SLID}, then {LIFTED}{IMAGE}.",
    "What happened first?": f"{TOUCHED}.",
    "What happened last?": "It lifts off, from 3.9 s to 4.1 s.",
    "When did it start turning?": "It turns clockwise, about 40 degrees, from 1.0 s on.",
    "When did it stop turning?": "It turns counterclockwise, about 25 degrees, until 3.2 s.",
    "When did it begin to slide?": "It slides left, about 3.4 px, from 3.4 s on.",
    "When was it touched?": "It touches from 0.4 s on.",
    "When was it let go?": "It lifts off, from 3.9 s to 4.1 s.",
    "How often did it turn back?": f"It turns back once. {capitalised(TURNED)}",
    "Did it turn back?": "Yes: it turns back once. ",
    "How many turns were there?": f"2 turns: {TURNED}, then {BACK}.",
    "How long was it held?": "It is touched for 3.6 s, from 0.4 s to 4.0 s.",
    "How long did it turn?": "It turns for 1.6 s, from 1.0 s to 3.2 s.",
    "How long was it still?": "It is held still for 0.6 s, from 1.8 s to 2.4 s.",
    "When did it turn fastest?": "It is fastest at ",
    "Did it slip before it was let go?": "Yes, it slips before it is let go: it slips counterclock",
}


@pytest.mark.parametrize("question", TOLD)
def test_a_recording_is_told_by_its_events(answerer, whole, question):
    answer = answerer.ask(whole, question)
    assert answer.text.startswith(TOLD[question])
    assert answer.kind == "order"
    assert not answer.abstained
    assert 0.9 < answer.confidence <= 1
    assert answer.decided


def test_the_direction_is_that_of_the_largest_event_told(answerer, whole):
    assert answerer.ask(whole, "What happened?").direction is Motion.CLOCKWISE
    mirrored = answerer.ask(whole, "What happened?", frame=FrameSpec(image_mirrored=True))
    assert mirrored.direction is Motion.COUNTERCLOCKWISE
    assert "it turns counterclockwise, about 40 degrees" in mirrored.text


def test_the_net_turn_is_told_and_what_it_went_there_and_back(answerer, whole):
    answer = answerer.ask(whole, "How far did it turn in total?")
    assert answer.amount.value == 15
    assert answer.text.startswith("About 15 degrees of turning from 1.0 s to 3.2 s, likely ")
    assert answer.text.endswith("There and back it turns by about 65 degrees.")


@pytest.mark.parametrize(
    ("question", "direction"),
    [
        ("Which way did it turn between 1 s and 2 s?", Motion.CLOCKWISE),
        ("Which way did it turn after 2.2 s?", Motion.COUNTERCLOCKWISE),
        ("Which way did it turn in frames 61 to 80?", Motion.COUNTERCLOCKWISE),
    ],
)
def test_a_span_that_a_question_names_is_tracked_inside(answerer, whole, question, direction):
    answer = answerer.ask(whole, question)
    assert answer.direction is direction
    assert min(answer.frames_used) >= 25


def test_an_event_is_told_as_far_as_it_lies_in_the_span(answerer, whole):
    answer = answerer.ask(whole, "What happened between 1.4 s and 1.8 s?")
    assert answer.text == (
        "It turns clockwise, about 20 degrees, from 1.4 s to 1.8 s, in the camera image."
    )
    assert answerer.ask(whole, "When did it slide before 2 s?").text == (
        "It does not slide in this part of the recording."
    )


def test_a_bracketed_span_is_the_recording_that_is_asked_about(answerer):
    part = encoded(answerer, span=(55, 90))
    assert answerer.ask(part, "Which way is it turning?").direction is Motion.COUNTERCLOCKWISE
    assert answerer.ask(part, "How far did it turn?").amount.value == 25
    with pytest.raises(UsageError, match="the recording goes from 0 to 4.96 s"):
        answerer.ask(part, "Which way did it turn between 7 s and 9 s?")


def test_frames_are_told_where_no_rate_is_known(answerer):
    seen = encoded(answerer, clip=replace(RECORDING, fps=None))
    assert answerer.ask(seen, "When did it start turning?").text.endswith(", from frame 25 on.")
    assert answerer.ask(seen, "How long did it turn?").text == (
        "It turns for 39 frames, from frame 25 to 80."
    )


def test_of_many_events_the_largest_are_told(answerer):
    small = [happened("turn", k, k + 2, turn=3 if k % 8 else -3) for k in range(24, 80, 4)]
    events = [EVENTS[0], *small, happened("slide", 82, 95, down=20), EVENTS[-1]]
    text = answerer.ask(encoded(answerer, events), "What happened?").text
    assert text.count("it ") + text.count("It ") == 6
    assert "slides down" in text
    assert "lifts off" in text


def test_what_goes_on_at_the_same_time_is_told_so(answerer):
    events = [*EVENTS[:3], happened("slide", 27, 43, right=20), EVENTS[-1]]
    text = answerer.ask(encoded(answerer, events), "What happened?").text
    assert "; meanwhile it slides right" in text


@pytest.mark.parametrize(
    ("question", "text"),
    [
        ("What happened?", "Nothing touches in the recording."),
        ("When did it start turning?", "It does not turn in the recording."),
        ("How long was it still?", "It is never held still in the recording."),
        ("How many slides were there?", "No slide in the recording."),
    ],
)
def test_what_does_not_happen_is_told(answerer, question, text):
    answer = answerer.ask(encoded(answerer, []), question)
    assert answer.text == text


def test_four_frames_are_a_clip_and_are_answered_as_one(answerer):
    clip = answerer.encode(RECORDING.select([0, 40, 80, 120]))
    assert (clip.track, clip.whole_track) == (None, None)
    assert answerer.ask(clip, "What happened first?").kind != "order"
