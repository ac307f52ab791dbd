"""From a query to a sentence: what is decided, whose words tell it, how sure the whole is."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import Component, Twist
from geotlm_lm.motion.belief import Belief
from tests.answering.scripted import believed, feeling, recording

MIXED = believed("clockwise", "left", deg=20.0, px=20.0)


def ask(answerer, text, **more):
    return answerer.ask(answerer.encode(recording(size=(224, 224), fps=25.0)), text, **more)


def test_the_models_own_sentence_is_told_where_it_would_write_it(bundle):
    answer = ask(feeling(bundle, "clockwise"), "Which way is it turning?")
    assert (answer.text, answer.told_by) == ("Clockwise, in the camera image.", "model")
    other = ask(feeling(bundle, "left", belief=believed("clockwise")), "Which way is it turning?")
    assert other.told_by == "rule"
    assert other.text == "It turns clockwise, about 12 degrees, in the camera image."


@pytest.mark.parametrize("text", ["mirror > way", "way ; amount", "way ; as word"])
def test_what_edits_or_reckons_is_told_by_rule(bundle, text):
    assert ask(feeling(bundle, "clockwise"), text).told_by == "rule"


def test_all_that_counts_is_told_the_larger_first_with_amounts(bundle):
    answer = ask(feeling(bundle, "clockwise", belief=MIXED), "way")
    assert answer.text == (
        "It turns clockwise, about 20 degrees, and slides left, about 8 px, in the camera image."
    )
    assert (answer.direction, answer.decided) == (Motion.CLOCKWISE, "clockwise")
    far = ask(feeling(bundle, "clockwise", belief=MIXED), "amount")
    assert far.decided == "20 deg"
    assert far.amount.span == (18.0, 22.0)


def test_the_probability_holds_that_of_understanding(bundle):
    sure, less = (
        ask(feeling(bundle, "left", understood=share), "way").confidence for share in (1.0, 0.8)
    )
    assert less == pytest.approx(0.8 * sure)


def test_what_is_hardly_understood_is_asked_back(bundle):
    answer = ask(feeling(bundle, "left", understood=0.3), "mirror > way slide")
    assert answer.abstained
    assert "Which way it slides, in the mirror? It slides right" in answer.text
    assert (answer.direction, answer.decided, answer.confidence) == (None, None, 0)


def test_beside_what_is_not_understood_at_all_it_is_told_what_is_felt(bundle):
    answer = ask(feeling(bundle, "left", understood=0.05), "mirror > way slide")
    assert answer.abstained
    assert re.search(r"say it in other words\. What I feel: .*left", answer.text)


def test_a_fact_alone_is_noted_and_one_not_understood_is_named(bundle):
    noted = ask(feeling(bundle, "left"), "fact mirrored ; fact thread left")
    assert noted.text.startswith("Noted: camera image with the mirror undone")
    assert "left-hand thread" in noted.text
    unclear = ask(feeling(bundle, "left"), "fact unclear turned ; way")
    assert unclear.abstained
    assert "how the image is turned" in unclear.text
    turn = ask(feeling(bundle, "clockwise"), "fact unclear turned ; way turn")
    assert turn.direction is Motion.CLOCKWISE
    assert any("the same however it is" in one for one in turn.notes)
    both = ask(
        feeling(bundle, "clockwise"), "fact unclear turned ; fact unclear mirrored ; claim cw"
    )
    assert both.abstained
    assert ask(feeling(bundle, "up"), "fact unclear mirrored ; claim up").abstained
    unknown = ask(feeling(bundle, "clockwise"), "fact unclear thread ; claim tighten")
    assert unknown.abstained
    assert "which thread" in unknown.text


def test_a_fact_holds_for_what_is_asked_with_it_and_names_its_frame(bundle):
    answer = ask(feeling(bundle, "left"), "fact mirrored ; way slide")
    assert answer.direction is Motion.RIGHT
    assert answer.text.endswith("in the camera image with the mirror undone.")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("way turn ; as word", "Clockwise."),
        ("amount turn ; as number", "20"),
        ("way sign ; as sign", "+"),
        ("choice A ccw , B cw ; as letter", "B."),
    ],
)
def test_the_form_that_is_asked_for_is_kept(bundle, text, told):
    assert ask(feeling(bundle, "clockwise", belief=MIXED), text).text == told


def test_json_holds_what_was_asked_and_how_sure_it_is(bundle):
    answer = ask(feeling(bundle, "clockwise", belief=MIXED), "way ; claim slide ; as json")
    told = json.loads(answer.text)
    assert (told["turn"], told["turn_deg"], told["verdict"]) == ("clockwise", 20.0, True)
    assert told["probability"] == pytest.approx(answer.confidence, abs=0.001)


@pytest.mark.parametrize(
    ("given", "names"),
    [
        ('{"turning": ?, "turn_deg": ?, "sliding": ?}', ["turning", "turn_deg", "sliding"]),
        ("(a: str, b: float, c: bool), valid JSON only", ["a", "b", "c"]),
        ('with "a", "b" and "c" please', ["a", "b", "c"]),
    ],
)
def test_json_has_the_keys_that_were_given(bundle, monkeypatch, given, names):
    answerer = feeling(bundle, "clockwise", belief=MIXED)
    line = "way turn ; amount turn deg ; claim slide ; as json"
    read = answerer.bundle.reader.readings
    monkeypatch.setattr(answerer.bundle.reader, "readings", lambda *_: read(line))
    told = json.loads(ask(answerer, given).text)
    assert list(told) == names
    assert list(told.values()) == ["clockwise", 20.0, True]


def test_undoing_names_both_movers(bundle):
    answer = ask(feeling(bundle, "clockwise"), "undo > way turn")
    assert answer.text == (
        "Turn the object counterclockwise, about 12 degrees, or turn the sensor clockwise, in the "
        "camera image."
    )
    assert answer.direction is Motion.COUNTERCLOCKWISE


@pytest.mark.parametrize(
    ("frame", "right", "down"),
    [
        ({}, 16, -12),
        ({"image_mirrored": True}, -16, -12),
        ({"actor": "sensor"}, -16, 12),
        ({"image_upside_down": True}, -16, 12),
        ({"image_quarter_turn": "clockwise"}, -12, -16),
    ],
)
def test_parts_along_the_axes_are_told_in_the_frame(bundle, frame, right, down):
    plain = believed("right")
    mean = Twist(right_px=16.0, down_px=-12.0)
    belief = Belief(mean, np.eye(4) * 0.09, plain.ways, 1.0, 60.0, plain.readable)
    answerer, frame = feeling(bundle, "right", belief=belief), FrameSpec(**frame)
    across = ask(answerer, "way x", frame=frame)
    assert across.direction is (Motion.RIGHT if right > 0 else Motion.LEFT)
    assert across.amount.value == abs(right)
    assert ask(answerer, "way y", frame=frame).amount.value == abs(down)


def test_pixels_are_named_and_what_millimetres_take(bundle):
    answerer = feeling(bundle, "left")
    answer = ask(answerer, "amount slide")
    assert any("224x224 frames" in note and "mm per pixel" in note for note in answer.notes)
    assert "size of a pixel" in ask(answerer, "amount slide mm").text
    told = ask(answerer, "amount slide", frame=FrameSpec(mm_per_px=0.1))
    assert told.amount.unit == "mm"
    assert not any("pixel" in note.lower() for note in told.notes)


def test_what_the_picture_does_not_tell_is_withheld(bundle):
    belief = believed("left")
    belief.readable[Component.SLIDE] = False
    answerer = feeling(bundle, "right", belief=belief)
    assert ask(answerer, "amount slide").abstained
    assert "how far along the edge cannot be seen" in ask(answerer, "way").text


def test_a_speed_takes_a_frame_rate(bundle):
    answerer = feeling(bundle, "clockwise", belief=believed("clockwise", deg=30.0))
    timed = answerer.encode(recording(fps=50.0))
    assert answerer.ask(timed, "amount turn per-s").amount.value == pytest.approx(500, rel=0.01)
    assert answerer.ask(timed, "amount turn turn per-min").amount.unit == "turn/min"
    untimed = answerer.encode(recording())
    assert "--fps 25" in answerer.ask(untimed, "amount turn per-s").text


def test_a_frame_rate_that_is_said_holds_for_the_rest_of_a_conversation_but_no_other_clip(bundle):
    answerer = feeling(bundle, "clockwise")
    answerer.bundle.reader.lines["at 50 fps"] = "fact rate #1"
    own, timed = (answerer.encode(recording(fps=rate)) for rate in (10.0, 50.0))
    talk = answerer.session(answerer.encode(recording()))
    assert talk.ask("at 50 fps").text.endswith("50 frames per second.")
    for clip in (timed, own):
        alone = answerer.ask(clip, "amount turn per-s").amount
        assert talk.ask("amount turn per-s").amount == alone
        talk.add_clip(own)


def test_a_frame_rate_that_is_said_stands_before_a_file_s_but_not_before_uneven_times(bundle):
    answerer = feeling(bundle, "clockwise")
    answerer.bundle.reader.lines["at 50 fps"] = "fact rate #1 ; amount turn per-s"
    timed = answerer.ask(answerer.encode(recording(fps=50.0)), "amount turn per-s")
    file_says_10 = recording(fps=10.0)
    said = answerer.ask(answerer.encode(file_says_10), "at 50 fps")
    assert said.amount == timed.amount
    assert "Told at 50 frames per second, not at the 10 that the file tells." in said.notes
    uneven = answerer.encode(replace(file_says_10, times_s=(0.0, 0.1, 0.21, 0.3)))
    kept = answerer.ask(uneven, "at 50 fps")
    assert kept.amount == answerer.ask(uneven, "amount turn per-s").amount != timed.amount
    assert any("not at the 50" in note for note in kept.notes)
    untold = answerer.encode(replace(recording(), times_s=(0.0, 0.1, 0.21, 0.3)))
    assert answerer.ask(untold, "at 50 fps").amount == timed.amount


def test_talk_claims_nothing_and_is_no_failure_but_what_cannot_be_felt_is_withheld(bundle):
    answer = ask(feeling(bundle, "left"), "Thanks!")
    assert re.match("You are welcome", answer.text)
    assert (answer.abstained, answer.direction) == (False, None)
    unknown = ask(feeling(bundle, "clockwise"), "unanswerable look")
    assert (unknown.abstained, unknown.direction) == (True, None)


def test_two_clips_are_compared(bundle):
    answerer = feeling(bundle, "clockwise")
    first, second = (answerer.encode(recording(seed=seed)) for seed in (1, 2))
    same = answerer.compare(first, second, "Do they turn the same way?")
    assert (same.decided, same.relation, same.abstained) == ("yes", "same", False)
    assert same.text.startswith("Yes: the first turns clockwise, about 12 degrees; the second ")
    assert answerer.compare(first, second, "of-second > way turn").decided == "clockwise"
    which = answerer.compare(first, second, "which-clip ccw")
    assert (which.decided, which.relation) == ("neither", "same")


def test_a_pixel_no_camera_has_answers_nothing(bundle):
    answer = ask(feeling(bundle, "clockwise"), "fact mirrored ; fact scale 50.0:mm ; way")
    assert (answer.direction, answer.decided, answer.abstained) == (None, None, True)
    assert "0.001 to 2 mm" in answer.text
