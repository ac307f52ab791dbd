"""Values in sentences and in the forms that are asked for."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.query import lines
from geotlm_lm.query import program as p
from geotlm_lm.query.answers import answers
from geotlm_lm.query.phrases import with_plurals, with_singulars
from geotlm_lm.query.telling import Teller
from geotlm_lm.query.written import guessed, worded
from tests.query.programs import (
    RECORDING,
    certain,
    expressions,
    of_clip,
    of_track,
    pairs,
    there_and_back,
    turned_and_slid,
)
from tests.query.strategies import turning
from tests.track.tracks import happened, moving_track, track_of_events

FRAME = FrameSpec()
MOST_WORDS = 30


def told(line, *clips, texts=(), frame=FRAME):
    """Return what a line is answered by."""
    clips = clips or (there_and_back(),)
    program = p.filled(lines.read(line), (), texts)
    values = answers(program, clips, frame)
    return worded(values, program.form, Teller(clips[-1].recording, frame), 0.9).text


@pytest.mark.parametrize(("line", "text"), [
    ("> amount cw 30.0:deg", "Yes, about 65 degrees."),
    ("turn ; as one-zero", "1"),
    ("slide ; as yes-no", "No."),
    ("count turn-events ; as number", "3"),
    ("begin first turn-events", "At 1.0 s."),
    ("begins turn-events", "At 1.0 s, 2.0 s and 3.0 s."),
    ("unit ms delay begin contact begin first turn-events", "1000 ms."),
    ("unit frame delay begin contact begin first turn-events", "25 frames."),
    ("way turn ; as word", "Clockwise."),
    ("way sign ; as sign", "+"),
    ("choose A cw | B ccw ; as letter", "A."),
    ("choose -1 left | 1 right | 0 other ; as bare", "0"),
    ("largest ccw-events",
     "It turns counterclockwise 15 degrees from 2.0 to 3.0 s, in the camera image."),
    ("record count turn-events , begin first turn-events end ; as tuple", "(3, 1)"),
    ("begins turn-events ; as brackets", "[1.0, 2.0, 3.0]"),
    ("record turn , slide end ; as one-zero", "1, 0"),
    ("record count turn-events , amount slide end ; as tuple", "(3, 0)"),
    ("amount slide ; as number", "0"),
    ("round 2 amount slide ; as number", "0.00"),
    ("round 2 unit s length contact ; as number", "4.00"),
    ("choose 3.0: turn | 4.0: other", "3."),
    ("if slide choose pass slide amount turn ; as bare", "65 deg"),
    ("each turn-events record begin here , amount turn end ; as csv",
     "begin_s,turn_deg\n1,40\n2,15\n3,40"),
    ("each turn-events record begin here , amount turn end ; as table",
     "1.0 s | 40 deg\n2.0 s | 15 deg\n3.0 s | 40 deg"),
    ("each move-events record begin here , end here end ; as csv",
     "kind,way,begin_s,end_s\nturn,clockwise,1,2\nturn,counterclockwise,2,3\nturn,clockwise,3,4"),
    ("choose pass turn | fail other ; as bare", "pass"),
    ("turn ; as true-false", "True"),
    ("record turn , slide end ; as true-false", "True, False"),
    ("choose 1 cw | -1 ccw | 0 other ; as bare", "1"),
])  # fmt: skip
def test_a_value_in_the_form_that_was_asked_for(line, text):
    assert told(line) == text


@pytest.mark.parametrize(("form", "head"), [
    ("semicolons", "kind;way;begin_s;end_s;value;unit\n"),
    ("markdown", "| kind | way | begin_s | end_s | value | unit |\n| --- | --- |"),
])  # fmt: skip
def test_a_story_in_rows_has_a_head(form, head):
    assert told(f"story ; as {form}").startswith(head)


def test_what_is_no_truth_is_told_in_full_where_truths_are_wanted():
    assert told("record turn , way turn end ; as true-false").startswith("Yes: it turns")


def test_a_label_of_digits_stays_as_it_is_written():
    line = "record @1 choose @2 turn | @3 other end ; as "
    assert told(f"{line}json", texts=("code", "01", "10")) == '{"code": "01"}'
    assert told(f"{line}json", texts=("code", "1", "0")) == '{"code": 1}'
    assert told(f"{line}pairs", texts=("code", "01", "10")) == "code=01"


def test_of_several_kinds_each_event_is_told_as_what_it_is():
    clip = turned_and_slid()
    assert told("each any-events kind ; as csv", clip) == "touch,stick,rotation,slide,release"
    assert told("each move-events extent", clip) == (
        "It turns clockwise, about 20 degrees, in the camera image; it slides left, about 43 px."
    )
    assert told("each any-events record begin here , story end ; as table", clip) == (
        "0.0 s | touch\n0.0 s | stick\n1.0 s | turn clockwise\n2.0 s | slide left\n3.0 s | release"
    )
    line = "backwards each move-events record kind , begin here end ; as "
    assert told(f"{line}markdown", clip).splitlines()[2:] == [
        "| slide | right | 1 |", "| turn | counterclockwise | 2 |",
    ]  # fmt: skip
    assert json.loads(told(f"{line}json", clip))[0]["way"] == "right"
    line = "each move-events record @1 begin here end ; as csv"
    assert told(line, clip, texts=("start",)) == "start\n1\n2"


def test_what_goes_both_ways_is_told_both_ways():
    clip = of_track(turning([40.0, -38.0]))
    assert told("amount turn", clip) == (
        "At its farthest about 40 degrees, likely 29 to 51, at 2.0 s; net 2 degrees clockwise."
    )
    assert told("amount ccw", clip) == (
        "38 degrees counterclockwise and 40 degrees clockwise, in the camera image."
    )
    assert told("count turn-events", clip) == "2 turns."
    assert told("count touch-events", clip) == "1 touch."


def test_own_words_are_printed_as_they_stand():
    assert (
        told("choose @1 > amount cw 30.0:deg | @2 other ; as bare", texts=("STOP", "GO")) == "STOP"
    )
    assert told("choose @1 slide | @2 other ; as bare", texts=("STOP", "GO")) == "GO"


def test_a_template_is_filled_under_its_own_keys():
    line = "record @1 count turn-events , @2 turn end ; as json"
    assert json.loads(told(line, texts=("n", "turns"))) == {"n": 3, "turns": True}
    line = "record @1 count turn-events , @2 begin first turn-events end ; as pairs"
    assert told(line, texts=("n", "t0")) == "n=3\nt0=1"
    line = "each turn-events record @1 begin here , @2 way turn end ; as json"
    assert json.loads(told(line, texts=("t0", "dir")))[1] == {"t0": 2.0, "dir": "counterclockwise"}
    line = "record @1 count turn-events , @2 way turn end ; as csv"
    assert told(line, texts=("n", "dir")) == "n,dir\n3,clockwise"


@pytest.mark.parametrize(("form", "text"), [
    ("semicolons", "n;on;way\n3;1;1"),
    ("tabs", "n\ton\tway\n3\t1\t1"),
    ("pipes", "n|on|way\n3|1|1"),
    ("markdown", "| n | on | way |\n| --- | --- | --- |\n| 3 | 1 | 1 |"),
    ("dict", "{'n': 3.0, 'on': True, 'way': 1}"),
    ("json", '{"n": 3.0, "on": true, "way": 1}'),
    ("tags", "<n>3</n>\n<on>1</on>\n<way>1</way>"),
])  # fmt: skip
def test_fields_in_every_template(form, text):
    line = "record @1 count turn-events , @2 turn , @3 choose 1.0: cw | 0 other end ; as "
    assert told(line + form, texts=("n", "on", "way")) == text


def test_a_story_is_a_list_where_one_is_asked_for():
    lines = told("story ; as list").splitlines()
    assert lines[0] == "1. at 0.0 s touch"
    assert lines[2] == "3. from 1.0 to 2.0 s turn clockwise 40 degrees"


def test_a_story_is_rows_of_a_file():
    head, *rows = told("story ; as csv").splitlines()
    assert head == "kind,way,begin_s,end_s,value,unit"
    assert rows[2] == "turn,clockwise,1.0,2.0,40.0,deg"
    assert [row.partition(",")[0] for row in rows] == [
        "touch", "stick", "turn", "turn", "turn", "release",
    ]  # fmt: skip


def test_a_story_ends_with_the_end_of_contact():
    assert told("story ; as list").splitlines()[-1] == "6. at 4.0 s release"


def test_a_reason_lies_in_the_span_that_is_asked_about():
    assert told("within until begin nth 2 turn-events ccw").startswith(
        "No: it turns clockwise, about 40 degrees"
    )
    assert told("within since begin nth 3 turn-events ccw") == (
        "No: it turns clockwise, about 40 degrees, in the camera image."
    )


def test_what_begins_and_ends_contact_is_pressing_and_lifting_where_that_is_asked():
    twists = np.zeros((101, 4))
    twists[1:11, 3], twists[71:76, 3] = 0.05, -0.1
    events = (
        happened("touch", 0, 0),
        happened("press", 0, 10, inward=0.5),
        happened("release", 70, 75, inward=-0.5),
    )
    contact = (np.arange(101) <= 75).astype(float)
    clip = of_track(moving_track(twists, events, contact=contact, frame_size=(240, 320)))
    assert told("out", clip) == "Yes, from 2.8 to 3.0 s."
    assert told("in", clip) == "Yes, from 0.0 to 0.4 s."
    assert told("not out", clip).startswith("No, that is not so")
    assert told("move", clip).startswith("No")


def test_a_slide_between_two_ways_is_told_by_both():
    both = certain(right=20, down=19)
    assert told("way slide", of_clip(both)) == (
        "It slides right and down, about 35 px, in the camera image."
    )
    little = told("way slide", of_clip(certain(right=20, down=8)))
    assert little.startswith("It slides right and a little down, ")


def test_the_length_of_the_contact_leaves_out_what_lies_between_touches():
    twists = np.zeros((101, 4))
    events = (
        happened("touch", 0, 0),
        happened("release", 25, 25, inward=-0.3),
        happened("touch", 75, 75),
        happened("release", 100, 100, inward=-0.3),
    )
    frames = np.arange(101)
    contact = ((frames <= 25) | (frames >= 75)).astype(float)
    clip = of_track(moving_track(twists, events, contact=contact, frame_size=(240, 320)))
    assert told("length contact", clip) == "2 s."


def test_a_story_tells_how_much_it_leaves_out():
    twists = np.zeros((121, 4))
    turns = [happened("turn", 24 * k, 24 * k + 12, turn=20.0 + k) for k in range(5)]
    for k, event in enumerate(turns):
        twists[event.begin + 1 : event.end + 1, 0] = (20.0 + k) / 12
    clip = of_track(moving_track(twists, turns, frame_size=(240, 320)))
    for line in ("story", "way turn"):
        assert told(line, clip).endswith("; and 2 more turns.")


def test_of_a_moment_is_told_what_goes_on_and_how_far_it_went_until_then():
    twists = np.zeros((121, 4))
    turns = [happened("turn", 20, 40, turn=30.0), happened("turn", 60, 80, turn=-20.0)]
    for event in turns:
        twists[event.begin + 1 : event.end + 1, 0] = event.amount.mean / 20
    clip = of_track(moving_track(twists, turns, frame_size=(240, 320)))
    for line, text in {
        "at t 1 amount turn": "About 8 degrees",
        "at t 2 amount turn": "About 30 degrees",
        "at t 4 net turn": "Net about 10 degrees",
        "at t 1 way turn": "It turns clockwise 30 degrees from 0.8 to 1.6 s",
        "at t 3 way turn": "It turns counterclockwise 20 degrees from 2.4 to 3.2 s",
        "at t 2 way turn": "It does not turn at that moment.",
        "at t 4 turn": "No: it does not turn.",
    }.items():
        assert told(line, clip).startswith(text)


@pytest.mark.parametrize(("line", "text"), [
    ("area", "About 10%."),
    ("within first turn-events area", "About 10%."),
    ("at t 1.5:s area", "About 10%, at 1.48 s."),
    ("backwards at t 3.5:s area", "About 10%, at 3.52 s."),
    ("at t 3.5:s area", "I know where and how much of the image is touched at 1.48 s only."),
    ("within part 2 2 recording area",
     "I know where and how much of the image is touched at 1.48 s only."),
    ("at t 3.5:s lies upper", "I know where and how much of the image is touched at 1.48 s only."),
    ("at t 4.5:s area", "Nothing touches the gel then."),
])  # fmt: skip
def test_the_touched_area_is_that_of_its_own_time(line, text):
    clip = there_and_back()
    used = replace(clip, recording=replace(clip.recording, used=(30, 34, 40, 44)))
    assert told(line, used) == text


def test_there_and_back_is_said_of_what_turned_back():
    ahead, back = of_track(turning([40.0, 38.0])), there_and_back()
    assert told("path turn", back).endswith(", there and back together.")
    assert re.fullmatch(r"About 78 degrees, likely \d+ to \d+\.", told("path turn", ahead))
    assert told("path cw", back).startswith("About 80 degrees")
    assert "back" not in told("path cw", back)
    assert told("> path turn 60.0:deg", back) == "Yes, about 95 degrees there and back."
    assert told("> path turn 60.0:deg", ahead) == "Yes, about 78 degrees."


def test_it_is_said_which_amounts_of_two_recordings_are_compared():
    clips = (of_track(turning([50.0, -40.0])), of_track(turning([40.0, -15.0, 40.0]), 1))
    assert told("which-more amount turn", *clips) == (
        "The second: the first at its farthest about 50 degrees, the second net about 65 degrees."
    )
    assert told("which-more path turn", *clips).startswith(
        "Neither clearly: the first about 90 degrees,"
    )


def test_what_is_unlikely_is_no_guess():
    assert guessed("It turns.", 0.4) == "I cannot tell for sure, 40%: it turns."
    assert guessed("GO.", 0.4) == "I cannot tell for sure, 40%: GO."
    assert "turns" not in guessed("It turns.", 0.001)


def test_no_is_told_with_what_is_so_instead():
    assert told("slide", of_clip(certain(turn=20))).startswith("No: it does not slide")
    assert told("ccw", of_clip(certain(turn=20))).startswith("No: it turns clockwise, about 20")


@given(expressions(), pairs)
@settings(max_examples=60, deadline=None)
def test_whatever_is_asked_is_told_in_every_form(expression, clips):
    values = answers(p.Program((expression,)), clips, FRAME)
    for form in (
        "sentence",
        "word",
        "number",
        "json",
        "csv",
        "pairs",
        "list",
        "table",
        "bare",
        "markdown",
        "dict",
        "tags",
        "tabs",
        "true-false",
    ):
        assert isinstance(worded(values, form, Teller(clips[-1].recording, FRAME)).text, str)


@pytest.mark.parametrize("line", ["turn", "cw", "way turn", "amount turn", "slide", "touch",
                                  "begin first turn-events", "kind", "always turn"])  # fmt: skip
def test_an_answer_is_short(line):
    assert len(told(line).split()) <= MOST_WORDS


@pytest.mark.parametrize(("line", "belief", "text"), [
    ("not turn", certain(turn=12),
     "No, that is not so: it turns clockwise, about 12 degrees, in the camera image."),
    ("mirror backwards way all", certain(turn=12),
     "It turns clockwise, about 12 degrees, in the camera image mirrored, played backwards."),
    ("move", certain(), "No: it touches but does not move."),
    ("way all", certain(contact=0.0), "Nothing touches the gel."),
    ("way y", certain(right=9), "It does not slide vertically."),
    ("tighten", certain(turn=12),
     "If it is an ordinary right-hand thread seen from its head, yes: it turns clockwise, about 12 "
     "degrees, in the camera image."),
    ("/ 1.0:turn amount turn", certain(right=9), "It does not turn."),
    ("sure-of cw", certain(turn=-12),
     "About 0%: it turns counterclockwise, about 12 degrees, in the camera image."),
    ("undo way turn", certain(turn=12),
     "Turn the object counterclockwise, about 12 degrees, in the camera image."),
    ("count turn-events", certain(turn=12),
     "One clip does not show that; give me the whole recording."),
])  # fmt: skip
def test_a_clip_is_told(line, belief, text):
    assert told(line, of_clip(belief)) == text


UNTIMED = replace(RECORDING, rate_hz=None)


def test_a_slide_that_turns_a_corner_goes_as_far_as_both_its_legs():
    legs = [happened("touch", 5, 5), happened("slide", 20, 40, down=30.0),
            happened("slide", 60, 80, right=-30.0), happened("release", 110, 115)]  # fmt: skip
    text = told("amount slide", of_track(track_of_events(legs)))
    net_px, path_px = map(int, re.search(r"about (\d+) px.*; (\d+) px there", text).groups())
    assert path_px == pytest.approx(net_px * 2**0.5, abs=2)


def test_an_amount_along_an_axis_is_told_with_its_own_way_and_path():
    legs = [happened("touch", 5, 5), happened("slide", 20, 40, down=-30.0, right=20.0),
            happened("slide", 60, 80, right=-8.0), happened("release", 110, 115)]  # fmt: skip
    clip = of_track(track_of_events(legs))
    across, down = (told(f"net {axis}", clip) for axis in ("x", "y"))
    assert re.fullmatch(r"Net about 17 px, likely .*: right, in the camera image; 40 px there and "
                        r"back\.", across)  # fmt: skip
    assert re.fullmatch(r"About 32 px, likely .*: up, in the camera image\.", down)


@pytest.mark.parametrize(("line", "clips", "text"), [
    ("length contact", [of_track(turning([40.0]), recording=UNTIMED)], "50 frames."),
    ("time-while turn ; as number", [of_track(turning([40.0]), recording=UNTIMED)], "25"),
    ("way y ; as word", [of_clip(certain(right=9))], "Still."),
    ("way y ; as sign", [of_clip(certain(right=9))], "It does not slide vertically."),
    ("amount y", [of_clip(certain(right=9))], "It does not slide vertically."),
    ("of-first file frames",
     [of_clip(certain()), of_clip(certain(), 1, replace(RECORDING, frames=9))], "100 frames."),
    ("within between t 20.0:s t 30.0:s amount turn", [there_and_back()],
     "That part holds no frames; name two times within the recording."),
    ("within nth 2 turn-events amount turn", [of_track(turning([40.0]))],
     "There is no second turn."),
    ("within nth 2 slide-events way all", [there_and_back()], "There is no second slide."),
    ("within nth 2 slide-events record amount slide , way slide end ; as json",
     [there_and_back()], '{"amount": null, "way": null, "probability": 0.9}'),
    ("begin first slide-events", [there_and_back()], "That does not happen in this recording."),
    ("length largest left-events", [there_and_back()], "There is no slide to the left."),
    ("within since t 4.5:s amount turn", [there_and_back()],
     "It does not turn: nothing touches the gel then."),
    ("at t 20.0:s touch", [there_and_back()],
     "That part holds no frames; name two times within the recording."),
])  # fmt: skip
def test_what_a_recording_lacks_is_told_as_such(line, clips, text):
    assert told(line, *clips) == text


@pytest.mark.parametrize(
    "text", ["About 1 degree per second.", "No: 0.1 degrees.", "1 inch, 11 frames"]
)
def test_a_number_may_be_copied_before_a_unit_of_many(text):
    many = with_plurals(text)
    assert with_singulars(many) == text
    assert with_plurals(many) == many
    assert "1 degree " not in many


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("unit frame clock end contact", "Frame 100."),
        ("unit frame length contact", "100 frames."),
        (
            "largest turn-events",
            "It turns clockwise 40 degrees from 1.0 to 2.0 s, in the camera image.",
        ),
        (
            "choose before begin first turn-events begin first turn-events"
            " | after begin first turn-events begin first turn-events",
            "Neither: at 1.0 s.",
        ),
    ],
)
def test_what_and_when_is_told_of_a_recording(line, text):
    (value,) = answers(lines.read(line), (there_and_back(),), FRAME)
    told = worded([value], "sentence", Teller(RECORDING, FRAME), value.probability).text
    assert told == text


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("way turn ; amount turn", "It does not turn by more than 0.65 degrees."),  # once
        ("touch ; at t 1.0:s touch", "Yes. Yes."),  # but two answers
        (
            "begin contact ; end contact",
            "It is touched from the start. It is still held when the recording ends (4.0 s).",
        ),
    ],
)
def test_several_answers_are_told_apart(line, text):
    still = of_track(moving_track(np.zeros((101, 4)), [happened("touch", 0, 0)]))
    told = answers(lines.read(line), (still,), FRAME)
    sentence = worded(told, "sentence", Teller(RECORDING, FRAME)).text
    assert sentence == text


@pytest.mark.parametrize(("frames", "now"), [(64, "counterclockwise"), (90, "clockwise")])
def test_what_happens_now_is_what_goes_on_at_the_end(frames, now):
    clip = of_track(turning([40.0, -38.0, 36.0, -35.0, 34.0]).between(0, frames))
    assert told("at end recording touch", clip) == "Yes."
    assert told("at end recording turn", clip).startswith("Yes")
    assert f"turns {now}" in told("at end recording way turn", clip)
    assert told("at end recording still", clip).startswith("No")


def test_four_frames_are_all_of_the_present():
    clip = of_clip(certain(turn=12.0))
    for asked in ("turn", "touch", "way all", "still"):
        assert told(f"at end recording {asked}", clip) == told(asked, clip)
