"""Readings become events; the expected values come from a motion of constant speed.

A window's reading of a motion from a to b is its speed times the share of the window's middle two
samples inside [a, b].
"""

import pytest

from geotlm_lm.core.labels import Motion
from geotlm_lm.live.events import Reading, Segmenter

SAMPLE_S = 0.1


def readings(motion, start_s, end_s, per_sample, until_s=2.0):
    """Return what overlapping windows would say of one motion of constant speed."""
    for number in range(round(until_s / SAMPLE_S)):
        centre = number * SAMPLE_S
        low, high = max(centre - SAMPLE_S, start_s), min(centre + SAMPLE_S, end_s)
        share = max(high - low, 0.0) / (2 * SAMPLE_S)
        is_seen = share > 0.3
        yield Reading(
            centre,
            SAMPLE_S,
            motion if is_seen else Motion.STILL,
            0.9,
            turn_deg=share * per_sample if motion is Motion.CLOCKWISE else 0.0,
            slide_x_px=-share * per_sample if motion is Motion.LEFT else 0.0,
        )


def events_of(all_readings):
    segmenter = Segmenter()
    events = [event for reading in all_readings for event in segmenter.push(reading)]
    return events + segmenter.finish()


def test_a_turn_begins_ends_and_adds_up():
    start, end = events_of(readings(Motion.CLOCKWISE, 0.5, 1.2, per_sample=3.0))
    assert (start.phase, start.motion, start.end_s) == ("start", Motion.CLOCKWISE, None)
    assert start.start_s == pytest.approx(0.5, abs=SAMPLE_S / 2 + 1e-9)
    assert end.end_s == pytest.approx(1.2, abs=SAMPLE_S / 2 + 1e-9)
    assert end.rotation_deg == pytest.approx(7 * 3.0, rel=0.05)
    assert end.probability == pytest.approx(0.9)


def test_a_slide_to_the_left_is_negative_in_x():
    _, end = events_of(readings(Motion.LEFT, 0.5, 1.2, per_sample=2.0))
    assert end.slide_x_px == pytest.approx(-7 * 2.0, rel=0.05)
    assert end.sentence().split("  ")[-1] == "left ends: 14.0 px in 0.70 s"


def test_a_single_stray_reading_is_no_event():
    stray = [Reading(0.1 * k, 0.1, Motion.STILL, 1.0) for k in range(9)]
    stray[4] = Reading(0.4, 0.1, Motion.CLOCKWISE, 0.6, turn_deg=5.0)
    assert events_of(stray) == []


def test_a_stray_reading_within_a_turn_does_not_end_it():
    turning = list(readings(Motion.CLOCKWISE, 0.5, 1.2, per_sample=3.0))
    turning[9] = Reading(0.9, 0.1, Motion.STILL, 0.5, turn_deg=3.0)
    assert [event.phase for event in events_of(turning)] == ["start", "end"]


def test_motions_that_follow_each_other_do_not_overlap():
    first = list(readings(Motion.CLOCKWISE, 0.2, 1.0, 3.0, until_s=1.0))
    second = list(readings(Motion.LEFT, 1.0, 1.6, 2.0))[10:]
    _, turned, began, slid = events_of(first + second)
    assert (turned.motion, began.motion) == (Motion.CLOCKWISE, Motion.LEFT)
    assert turned.end_s <= began.start_s <= 1.0 + SAMPLE_S
    assert slid.end_s == pytest.approx(1.6, abs=SAMPLE_S / 2 + 1e-9)


def test_the_end_of_the_stream_ends_a_motion():
    begun = list(readings(Motion.CLOCKWISE, 0.5, 9.0, 3.0, until_s=1.0))
    events = events_of(begun)
    assert [event.phase for event in events] == ["start", "end"]
    assert events[-1].end_s <= 1.0


def test_an_event_is_told_in_plain_json_values():
    start, end = (event.to_dict() for event in events_of(readings(Motion.CLOCKWISE, 0.5, 1.2, 3.0)))
    assert start["end_s"] is None
    assert (end["type"], end["phase"], end["motion"]) == ("motion", "end", "clockwise")
