"""A tool's parameters are checked once, whoever calls it; what fails in it is told as our fault."""

import numpy as np
import pytest

from app import schema as p
from app.api import Api, summary_of
from app.tools import OUR_FAULT, Tool
from geotlm_lm import GeoTLMError
from geotlm_lm.core.twist import Component
from geotlm_lm.simulation.touch import RANGES
from geotlm_lm.track.tracker import track_of
from tests.track.recordings import there_and_back
from tests.track.tracks import happened, track_of_events


def double(number: p.bounded(0.0, 2.0, "A number.") = 1.0) -> dict[str, float]:
    """Return twice a number."""
    return {"double": 2 * number}


def broken() -> dict[str, float]:
    """Fail."""
    raise ZeroDivisionError("a secret of the server")


def test_a_tool_says_what_it_takes_and_gives():
    tool = Tool(double)
    assert tool.input_schema == {
        "type": "object",
        "additionalProperties": False,
        "properties": {
            "number": {
                "type": "number",
                "minimum": 0.0,
                "maximum": 2.0,
                "default": 1.0,
                "description": "A number.",
            }
        },
    }
    assert tool.output_schema == {"type": "object", "additionalProperties": {"type": "number"}}
    assert (tool.name, tool.description) == ("double", "Return twice a number.")
    assert tool.call({"number": 0.5}) == {"double": 1.0}


def test_a_mistake_of_ours_is_logged_and_its_words_are_not_told(caplog):
    with pytest.raises(GeoTLMError) as caught:
        Tool(broken).call({})
    assert str(caught.value) == OUR_FAULT
    assert "a secret of the server" in caplog.text


def test_a_simulated_touch_has_the_bounds_of_the_simulator():
    tools = [Tool(function) for function in Api(None, None).functions]
    (simulate,) = (tool for tool in tools if tool.name == "simulate")
    offered = simulate.input_schema["properties"]
    numbers = {name: one for name, one in offered.items() if "minimum" in one}
    assert len(numbers) == 7
    for name, one in numbers.items():
        assert (one["minimum"], one["maximum"]) == RANGES[name]


@pytest.fixture(scope="module")
def recording():
    return there_and_back()


@pytest.fixture(scope="module")
def track(recording):
    return track_of(recording)


def summary(track, recording, rows=0, **facts):
    return summary_of(track, recording, p.Frame(**facts).spec, rows)


def ways(result):
    return [one["way"] for one in result["events"] if one["event"] == "turn"]


def test_a_turn_reverses_where_one_looks_from_the_other_side(track, recording):
    plain, behind = (summary(track, recording, **one) for one in ({}, {"viewpoint": "object"}))
    assert ways(plain) == ["clockwise", "counterclockwise"]
    assert ways(behind) == ["counterclockwise", "clockwise"]
    amounts = [[one.get("amount") for one in each["events"]] for each in (plain, behind)]
    assert amounts[0] == amounts[1]
    net, other = (each["totals"]["turn_net"] for each in (plain, behind))
    assert (net["amount"], net["low"], net["high"]) == (
        -other["amount"], -other["high"], -other["low"],
    )  # fmt: skip


def test_how_far_is_none_where_the_pictures_do_not_tell_it(track, recording):
    unseen = track.as_readable({Component.TURN: False})
    result = summary(unseen, recording, viewpoint="object")
    assert ways(result) == ["counterclockwise", "clockwise"]
    assert {one["amount"] for one in result["events"] if one["event"] == "turn"} == {None}
    assert result["totals"]["turn_net"]["amount"] is None
    slid = track_of_events([happened("touch", 5, 5), happened("slide", 20, 40, right=8)])
    unseen = summary(slid.as_readable({Component.SLIDE: False}), recording, turned=90)
    assert unseen["totals"]["slide_right"] is None is unseen["totals"]["slide_in_all"]["low"]


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
    plain, seen = summary(track, recording, rows=5), summary(track, recording, rows=5, **facts)
    totals = [each["totals"] for each in (plain, seen)]
    right_down = [(each["slide_right"], each["slide_down"]) for each in totals]
    assert right_down[1] == of_right_down(*right_down[0])
    for before, after in zip(plain["rows"], seen["rows"], strict=True):
        assert (after["right_px"], after["down_px"]) == of_right_down(
            before["right_px"], before["down_px"]
        )


def test_rows_are_spread_from_the_first_frame_to_the_last(track, recording):
    frames = [row["frame"] for row in summary(track, recording, rows=5)["rows"]]
    assert (len(frames), frames[0], frames[-1]) == (5, 0, len(track) - 1)
    assert np.ptp(np.diff(frames)) <= 1
    assert len(summary(track, recording, rows=500)["rows"]) == len(track)


def test_travel_is_told_in_millimetres_where_a_pixel_has_a_size(track, recording):
    totals = summary(track, recording, mm_per_px=0.1)["totals"]
    pixels = summary(track, recording)["totals"]
    assert totals["slide_in_all"]["unit"] == "mm"
    assert totals["slide_net"]["amount"] == pytest.approx(
        0.1 * pixels["slide_net"]["amount"], rel=0.05, abs=0.01
    )
