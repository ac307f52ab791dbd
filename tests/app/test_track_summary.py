"""A track is told in the frame that was asked for; how far it went is the same in each."""

import numpy as np
import pytest

from app.parameters import frame_of
from app.track_summary import summary_of
from geotlm_lm.track.tracker import track_of
from tests.track.recordings import there_and_back


@pytest.fixture(scope="module")
def recording():
    return there_and_back()


@pytest.fixture(scope="module")
def track(recording):
    return track_of(recording)


def told(track, recording, rows=0, **facts):
    return summary_of(track, recording, frame_of(**facts), rows)


def ways(summary):
    return [one["way"] for one in summary["events"] if one["event"] == "turn"]


def test_a_turn_reverses_where_one_looks_from_the_other_side(track, recording):
    plain, behind = (told(track, recording, **one) for one in ({}, {"viewpoint": "object"}))
    assert ways(plain) == ["clockwise", "counterclockwise"]
    assert ways(behind) == ["counterclockwise", "clockwise"]
    amounts = [[one.get("amount") for one in each["events"]] for each in (plain, behind)]
    assert amounts[0] == amounts[1]
    net, other = (each["totals"]["turn_net"] for each in (plain, behind))
    assert (net["amount"], net["low"], net["high"]) == (
        -other["amount"], -other["high"], -other["low"],
    )  # fmt: skip


@pytest.mark.parametrize(
    ("facts", "of_right_down"),
    [
        ({"mirrored": True}, lambda right, down: (-right, down)),
        ({"turned": 180}, lambda right, down: (-right, -down)),
        ({"turned": 90}, lambda right, down: (down, -right)),
        ({"turned": 270}, lambda right, down: (-down, right)),
        ({"actor": "sensor"}, lambda right, down: (-right, -down)),
    ],
)
def test_travel_turns_with_the_image(track, recording, facts, of_right_down):
    plain, seen = told(track, recording, rows=5), told(track, recording, rows=5, **facts)
    totals = [each["totals"] for each in (plain, seen)]
    right_down = [(each["slide_right"], each["slide_down"]) for each in totals]
    assert right_down[1] == of_right_down(*right_down[0])
    for before, after in zip(plain["rows"], seen["rows"], strict=True):
        assert (after["right_px"], after["down_px"]) == of_right_down(
            before["right_px"], before["down_px"]
        )


def test_rows_are_spread_from_the_first_frame_to_the_last(track, recording):
    frames = [row["frame"] for row in told(track, recording, rows=5)["rows"]]
    assert (len(frames), frames[0], frames[-1]) == (5, 0, len(track) - 1)
    assert np.ptp(np.diff(frames)) <= 1
    assert len(told(track, recording, rows=500)["rows"]) == len(track)


def test_travel_is_told_in_millimetres_where_a_pixel_has_a_size(track, recording):
    totals = told(track, recording, mm_per_px=0.1)["totals"]
    pixels = told(track, recording)["totals"]
    assert totals["slide_in_all"]["unit"] == "mm"
    assert totals["slide_net"]["amount"] == pytest.approx(
        0.1 * pixels["slide_net"]["amount"], rel=0.05, abs=0.01
    )
