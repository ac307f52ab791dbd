"""A whole recording with the shipped model: turned, held, turned back, let go; one of real life."""

from pathlib import Path

import pytest

from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENTS
from geotlm_lm.data.touch_table import read_gold_turns
from geotlm_lm.recordings.read import read_clip
from tests.track.stream import (
    BACK,
    BACK_DEG,
    BACK_END,
    FPS,
    RELEASE,
    TOUCH,
    TURN,
    TURN_DEG,
    TURN_END,
    stream,
)

NEAR_S = 0.3

EXAMPLES = sorted((Path(__file__).resolve().parents[2] / "app" / "examples").glob("*.npz"))


@pytest.fixture(scope="module")
def whole(answerer):
    return answerer.encode(stream())


def decided_s(answerer, encoded, question):
    return float(answerer.ask(encoded, question).decided.removesuffix(" s"))


def test_its_turns_are_found_in_order_with_their_times_and_amounts(whole):
    turn, back = (one for one in whole.track.events if one.kind == "turn")
    assert turn.amount.mean == pytest.approx(TURN_DEG, rel=0.3)
    assert back.amount.mean == pytest.approx(-BACK_DEG, rel=0.3)
    found = [turn.begin_s, turn.end_s, back.begin_s, back.end_s]
    planned = [place / FPS for place in (TURN, TURN_END, BACK, BACK_END)]
    assert found == pytest.approx(planned, abs=NEAR_S)


def test_times_and_counts_are_answered(answerer, whole):
    begin = decided_s(answerer, whole, "When did it start turning?")
    assert begin == pytest.approx(TURN / FPS, abs=NEAR_S)
    end = decided_s(answerer, whole, "When did it stop turning?")
    assert end == pytest.approx(BACK_END / FPS, abs=NEAR_S)
    held = decided_s(answerer, whole, "How long was it touched?")
    assert held == pytest.approx((RELEASE - TOUCH) / FPS, abs=2 * NEAR_S)
    assert answerer.ask(whole, "How often did it turn back?").decided == "1"


def test_the_order_of_what_happened_is_answered(answerer, whole):
    text = answerer.ask(whole, "What happened, step by step?").text
    told = ("It touches", "turns clockwise", "counterclockwise", "is let go")
    places = [text.index(part) for part in told]
    assert places == sorted(places)


def test_the_net_turn_holds_the_truth_and_spans_are_tracked_inside(answerer, whole):
    net = answerer.ask(whole, "What is the net rotation?")
    low, high = net.amount.span
    assert low <= TURN_DEG - BACK_DEG <= high
    # It came back by more than half: how far it turned is how far it got.
    low, high = answerer.ask(whole, "How far did it turn?").amount.span
    assert low <= TURN_DEG <= high
    part = answerer.ask(whole, f"Which way did it turn after {BACK / FPS:.1f} s?")
    assert part.direction is Motion.COUNTERCLOCKWISE
    bracketed = answerer.encode(whole.recording, span=(TURN, TURN_END), track=whole.track)
    assert answerer.ask(bracketed, "Which way is it turning?").direction is Motion.CLOCKWISE


def test_a_motion_of_a_stream_is_answered_by_its_track_and_the_frames_that_are_kept(
    answerer, whole
):
    part = whole.track.between(TURN, TURN_END)
    kept = whole.recording.select(range(TURN, TURN_END, 2))
    answer = answerer.ask(answerer.encode(kept, track=part), "How far did it turn?")
    assert answer.amount.value == pytest.approx(part.net_twist.turn_deg, rel=0.1)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_the_track_of_a_clip_says_what_its_answers_say(answerer, path):
    clip = read_clip(path)
    encoded, track, tracker = answerer.encode(clip), answerer.track(clip), answerer.tracker(clip)
    assert [tracker.feed(frame, k / FPS) for k, frame in enumerate(clip.frames)] == [[]] * len(clip)
    assert tracker.finish().events == track.events
    belief = encoded.belief
    touches = answerer.ask(encoded, "Is anything touching the gel?").decided == "yes"
    assert touches == bool(track.contacts()) == bool(track.events)
    for component in COMPONENTS:
        events = track.of(component)
        assert bool(events) == (belief.moves(component) >= 0.5)
        for event in events:
            assert event.motion is belief.way(component)
            assert abs(event.amount.mean) == pytest.approx(belief.amount(component))
            assert abs(track.net(component).mean) == pytest.approx(belief.amount(component))


@pytest.mark.real
@pytest.mark.parametrize("name", ["mandarin_orange_2", "pen_base_1"])
def test_a_real_turn_is_told_whole_and_bracketed(answerer, real, name):
    (turn,) = (
        turn for turn in read_gold_turns(real / "physiclear") if turn.recording.path.stem == name
    )
    clip = read_clip(turn.recording.path)
    track = answerer.track(clip)
    for span in (None, (turn.first_frame, turn.last_frame)):
        encoded = answerer.encode(clip, span=span, track=track)
        assert answerer.ask(encoded, "Which way is it turning?").direction is Motion.CLOCKWISE
        answer = answerer.ask(encoded, "How far did it turn?")
        assert answer.amount.value == pytest.approx(turn.turn_deg, rel=0.3)
