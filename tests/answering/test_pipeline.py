"""From a question to its answer: what is understood, what is asked back, how the whole is told."""

import json
from dataclasses import replace

import numpy as np
import pytest

from geotlm_lm.answering.understanding import understand
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import Component, Twist
from geotlm_lm.motion.belief import Belief
from geotlm_lm.query.lines import read
from tests.answering.scripted import ScriptedReader, believed, feeling, read_by, recording

MIXED = believed("clockwise", "left", deg=20.0, px=20.0)
ASKED = "What about it?"


def ask(answerer, text, **more):
    return answerer.ask(answerer.encode(recording(size=(224, 224), fps=25.0)), text, **more)


def ask_read_as(answerer, *lines, **more):
    """Ask what is read in several ways, each with its chance."""
    answerer.bundle.reader.lines[ASKED] = list(lines)
    return ask(answerer, ASKED, **more)


def test_what_moves_is_told_the_larger_first_with_amounts(bundle):
    answer = ask(feeling(bundle, belief=MIXED), "way all")
    assert answer.text == (
        "It turns clockwise, about 20 degrees, and slides left, about 8 px, in the camera image."
    )
    assert (answer.direction, answer.decided) == (Motion.CLOCKWISE, "clockwise")
    assert (answer.kind, answer.told_by, answer.query) == ("way", "rule", "way all")
    far = ask(feeling(bundle, belief=MIXED), "extent")
    assert far.decided == "20 deg and 8 px"
    assert far.amount.span == (18.0, 22.0)


# Understood


def test_the_probability_holds_that_of_understanding(bundle):
    sure, less = (
        ask(feeling(bundle, "left", understood=share), "way all").confidence for share in (1.0, 0.8)
    )
    assert less == pytest.approx(0.8 * sure)


@pytest.mark.parametrize(("lines", "understood"), [
    ((("way turn", 0.4), ("cw", 0.3)), 0.4),
    ((("way turn", 0.4), ("way all", 0.3)), 0.7),
    ((("amount turn", 0.4), ("unit deg amount turn", 0.3), ("slide", 0.25)), 0.7),
    ((("slide", 0.3), ("turn", 0.25), ("or turn slide", 0.2)), 0.45),
    ((("turn ; slide", 0.4), ("slide ; turn", 0.3)), 0.7),
    ((("fact mirrored ; turn", 0.4), ("turn", 0.3)), 0.4),
])  # fmt: skip
def test_readings_that_come_to_the_same_are_one(bundle, lines, understood):
    answer = ask_read_as(feeling(bundle, "clockwise"), *lines)
    assert answer.understood == pytest.approx(understood)


def test_it_is_asked_back_only_between_close_readings_of_different_values(bundle):
    answerer = feeling(bundle, "clockwise")
    close = ask_read_as(answerer, ("way turn", 0.4), ("amount turn", 0.35))
    assert close.text == "Do you mean which way it turns, or how far it turns?"
    assert (close.abstained, close.decided, close.direction) == (True, None, None)
    assert (close.confidence, close.kind) == (0.0, "fact")
    apart = ask_read_as(answerer, ("way turn", 0.4), ("amount turn", 0.15))
    assert apart.text.startswith("Taken as: which way it turns. It turns clockwise")
    assert (apart.decided, apart.abstained, apart.confidence) == (None, True, 0.0)
    sure = ask_read_as(answerer, ("way turn", 0.6), ("amount turn", 0.35))
    assert sure.decided == "clockwise"
    assert ask_read_as(answerer, ("way turn", 0.35)).text.startswith("Taken as: ")
    unlikely = ask_read_as(answerer, ("way turn", 0.1), ("amount turn", 0.05))
    assert unlikely.text == "I am not sure what you ask; do you mean which way it turns?"


def test_only_a_sentence_says_how_a_question_was_taken(bundle):
    answerer = feeling(bundle, "clockwise", understood=0.45)
    assert ask(answerer, "way turn").text.startswith("Taken as: which way it turns. ")
    assert ask(answerer, "way turn ; as brief").text == "I cannot tell for sure, 44%: clockwise."
    empty = ask(answerer, "turn ; as json")
    assert json.loads(empty.text)["turn"] is None
    assert empty.withheld[0].startswith("Taken as: whether it turns. Yes")
    assert empty.withheld[0] in empty.notes
    answerer = feeling(bundle, "clockwise", understood=0.6)
    assert json.loads(ask(answerer, "turn ; as json").text)["turn"] is True
    assert ask(answerer, "way turn").text.startswith("It turns")


def test_a_doubtful_refusal_or_fact_of_the_file_is_announced_or_asked_back_too(bundle):
    answerer = feeling(bundle, "clockwise")
    refused = ask_read_as(answerer, ("cannot sound", 0.45), ("way turn", 0.1)).text
    assert refused.startswith("Taken as: something that I cannot tell. I cannot hear")
    rate = ask_read_as(answerer, ("file rate", 0.45)).text
    assert rate.startswith("Taken as: the recording's frame rate. ")
    alike = ask_read_as(answerer, ("cannot sound", 0.35), ("cannot look", 0.3))
    assert (alike.understood, alike.text[:13]) == (pytest.approx(0.65), "I cannot hear")
    close = ask_read_as(answerer, ("cannot sound", 0.4), ("way turn", 0.35)).text
    assert close == "I am not sure what you ask; do you mean which way it turns?"
    unlikely = ask_read_as(answerer, ("cannot sound", 0.1)).text
    assert unlikely.startswith("I did not understand all of that")
    assert ask_read_as(answerer, ("talk thanks", 0.1)).text == "You are welcome."


def test_facts_that_turn_an_answer_have_to_be_understood(bundle):
    answerer = feeling(bundle, "clockwise")
    turned = ask_read_as(answerer, ("fact mirrored ; way turn", 0.65), ("way turn", 0.2))
    assert turned.abstained
    assert turned.text.startswith("Do you mean")
    alike = ask_read_as(answerer, ("fact mirrored ; way turn", 0.65), ("fact mirrored ; cw", 0.2))
    assert alike.direction is Motion.COUNTERCLOCKWISE
    sure = ask_read_as(answerer, ("fact mirrored ; way turn", 0.7), ("way turn", 0.2))
    assert sure.direction is Motion.COUNTERCLOCKWISE


@pytest.mark.parametrize(("ways", "line", "text"), [
    (("left",), "fact unclear turned ; way all", "how the image is turned"),
    (("up",), "fact unclear mirrored ; up", "how the image is mirrored"),
    (("clockwise",), "fact unclear turned ; fact unclear mirrored ; cw", "how the image is"),
    (("clockwise",), "fact unclear thread ; tighten", "which thread"),
    (("clockwise",), "fact unclear other ; way turn", "say of the set-up"),
    (("clockwise",), "fact unclear turned", "how the image is turned"),
])  # fmt: skip
def test_an_unclear_fact_that_matters_is_asked_about(bundle, ways, line, text):
    answer = ask(feeling(bundle, *ways), line)
    assert answer.abstained
    assert text in answer.text


@pytest.mark.parametrize(
    "line", ["fact unclear turned ; way turn", "fact unclear thread ; way turn"]
)
def test_an_unclear_fact_that_changes_nothing_is_noted(bundle, line):
    answer = ask(feeling(bundle, "clockwise"), line)
    assert answer.direction is Motion.CLOCKWISE
    assert any("this answer is the same" in note for note in answer.notes)


def test_a_question_can_be_understood_without_a_recording():
    reader = ScriptedReader({ASKED: [("way turn", 0.4), ("way all", 0.35)]})
    found = understand(reader, ASKED)
    assert (found.line, found.probability) == ("way turn", 0.4)
    assert found.ask_back == "Do you mean which way it turns, or which way it moves?"
    more = understand(ScriptedReader(), "mirror again", read("way turn"))
    assert (more.line, more.ask_back) == ("mirror way turn", None)


def test_what_is_asked_back_is_short(bundle):
    long = " ; ".join(f"within part {k} 4 contact amount slide" for k in range(1, 5))
    asked = ask_read_as(feeling(bundle, "clockwise"), (long, 0.2), ("turn", 0.19))
    assert asked.text.startswith("I did not understand all of that")
    asked = ask_read_as(feeling(bundle, "clockwise"), ("turn", 0.2), (long, 0.19))
    assert asked.text == "I am not sure what you ask; do you mean whether it turns?"


def test_a_reading_that_compares_a_thing_with_itself_is_none(bundle):
    answerer = feeling(bundle, "clockwise")
    read_as = ask_read_as(answerer, ("> amount turn amount turn", 0.6), ("turn", 0.3))
    assert read_as.query == "turn"
    assert ask_read_as(answerer, ("and cw cw", 0.6)).query == "and cw cw"  # for want of another


def test_a_doubtful_reading_of_two_recordings_gives_way_where_one_is_open(bundle):
    answerer, of_two = feeling(bundle, "clockwise"), "- of-first amount turn of-second amount turn"
    other = ask_read_as(answerer, (of_two, 0.45), ("way turn", 0.2))
    assert (other.query, other.understood) == ("way turn", pytest.approx(0.2 / 0.55))
    assert other.text.startswith("Taken as: which way it turns. ")
    for chances in ((0.6, 0.3), (0.45, 0.05)):
        lines = zip((of_two, "way turn"), chances, strict=True)
        assert ask_read_as(answerer, *lines).text.endswith(
            "That takes two clips; give me another one to compare with."
        )
    encoded = answerer.encode(recording())
    answerer.bundle.reader.lines[ASKED] = [(of_two, 0.45), ("way turn", 0.2)]
    both = answerer.compare(encoded, answerer.encode(recording(seed=2)), ASKED)
    assert both.resumed == read(of_two)


def test_what_is_out_of_place_is_less_likely(bundle):
    reader = ScriptedReader()
    answerer = feeling(bundle, "clockwise")
    answerer.bundle = read_by(answerer.bundle, reader)
    ask(answerer, "turn")
    assert {"same", "of-second", "again", "it"} <= reader.unlikely
    understand(reader, "again", read("way turn"))
    assert not reader.unlikely  # without a recording nothing is out of place


# Facts and views


def test_a_fact_alone_is_noted(bundle):
    noted = ask(feeling(bundle, "left"), "fact mirrored ; fact thread left")
    assert noted.text == "Noted: the image is mirrored, left-hand thread."
    assert (noted.kind, noted.abstained, noted.confidence) == ("fact", False, 0.98)
    pixel = ask(feeling(bundle, "left"), "fact scale 50.0:mm")
    assert (pixel.abstained, "0.001 to 2 mm" in pixel.text) == (True, True)


def test_a_fact_holds_for_what_is_asked_with_it_and_names_its_frame(bundle):
    answer = ask(feeling(bundle, "left"), "fact mirrored ; way slide")
    assert answer.direction is Motion.RIGHT
    assert answer.text.endswith("in the camera image with the mirror undone.")
    none = ask(feeling(bundle, "clockwise"), "fact mirrored ; fact scale 50.0:mm ; way all")
    assert (none.direction, none.decided, none.abstained) == (None, None, True)
    assert "0.001 to 2 mm" in none.text


@pytest.mark.parametrize(("line", "way", "text"), [
    ("mirror way turn", Motion.COUNTERCLOCKWISE, "in the camera image mirrored."),
    ("mirror backwards way turn", Motion.CLOCKWISE, "mirrored, played backwards."),
    ("as-sensor way turn", Motion.COUNTERCLOCKWISE, "The sensor turns counterclockwise"),
    ("undo way turn", Motion.COUNTERCLOCKWISE, "Turn the object counterclockwise, about 12"),
])  # fmt: skip
def test_a_view_is_told_with_its_name(bundle, line, way, text):
    answer = ask(feeling(bundle, "clockwise"), line)
    assert answer.direction is way
    assert text in answer.text
    assert answer.in_the_image is Motion.CLOCKWISE


@pytest.mark.parametrize(("frame", "right", "down"), [
    ({}, 16, -12),
    ({"image_mirrored": True}, -16, -12),
    ({"actor": "sensor"}, -16, 12),
    ({"image_upside_down": True}, -16, 12),
    ({"image_quarter_turn": "clockwise"}, -12, -16),
])  # fmt: skip
def test_parts_along_the_axes_are_told_in_the_frame(bundle, frame, right, down):
    plain = believed("right")
    mean = Twist(right_px=16.0, down_px=-12.0)
    belief = Belief(mean, np.eye(4) * 0.09, plain.ways, 1.0, 60.0, plain.readable)
    answerer, frame = feeling(bundle, belief=belief), FrameSpec(**frame)
    across = ask(answerer, "way x", frame=frame)
    assert across.direction is (Motion.RIGHT if right > 0 else Motion.LEFT)
    assert across.amount.value == abs(right)
    assert ask(answerer, "way y", frame=frame).amount.value == abs(down)


# Guesses


def _doubtful(share=0.45, small=None):
    """A belief of a turn that is a guess, or of a sure one beside a small slide."""
    belief = believed("clockwise", share=share if small is None else 0.97)
    return replace(belief, ways=belief.ways | ({Motion.LEFT: small} if small else {}))


def test_what_is_more_likely_wrong_than_right_is_told_as_a_guess_and_decides_nothing(bundle):
    belief = replace(_doubtful(), ways=_doubtful().ways | {Motion.COUNTERCLOCKWISE: 0.4})
    answer = ask(feeling(bundle, belief=belief), "way turn")
    assert answer.text.startswith("I cannot tell for sure, 4")
    assert "%: it turns clockwise" in answer.text
    assert (answer.decided, answer.confidence, answer.abstained) == (None, 0.0, True)
    assert answer.direction is None
    answerer = feeling(bundle, belief=belief)
    asked = "as json with 'way' and 'touch'"
    answerer.bundle.reader.lines[asked] = "record @1 way turn , @2 touch end ; as json"
    assert json.loads(ask(answerer, asked).text) == {"way": None, "touch": True}
    brief = ask(feeling(bundle, belief=belief), "way turn ; as brief").text
    assert brief.startswith("I cannot tell for sure")


@pytest.mark.parametrize(("line", "text"), [
    ("cw ; as true-false", "unknown"),
    ("way turn ; as word", "unknown"),
    ("amount turn ; as number", "unknown"),
    ("choose pass cw | fail other ; as bare", "unknown"),
    ("unit mm amount slide ; as number", "unknown"),
    ("record cw , touch end ; as one-zero", "unknown, 1"),
    ("record way turn , touch end ; as word", "Unknown; yes."),
    ("touch ; cw ; as yes-no", "Yes. unknown"),
])  # fmt: skip
def test_a_value_alone_that_is_withheld_is_unknown_and_a_note_says_why(bundle, line, text):
    belief = replace(believed("clockwise", share=0.55, spread=1.0), contact=1.0)
    answer = ask(feeling(bundle, belief=belief, understood=0.8), line)
    assert answer.text == text
    assert answer.withheld[0] in answer.notes
    assert "I cannot tell" in answer.withheld[0] or "size of a pixel" in answer.withheld[0]
    assert answer.decided == ("yes" if line.startswith("touch") else None)


def test_what_only_its_reading_makes_a_guess_is_told_as_one(bundle):
    belief = replace(believed("clockwise", share=0.55), contact=1.0)
    doubtful = feeling(bundle, belief=belief, understood=0.8)
    assert ask(doubtful, "cw").text.startswith("I cannot tell for sure, 4")
    word = ask(doubtful, "cw ; as word")
    assert (word.text, word.abstained) == ("unknown", True)
    assert word.options["yes"] > 0.5
    sure = ask(feeling(bundle, belief=belief, understood=0.95), "cw ; as word")
    assert (sure.text, sure.withheld) == ("Yes.", ())


@pytest.mark.parametrize("line", ["way all", "kind", "extent", "way turn", "record way all end"])
def test_a_doubtful_small_component_never_withholds_a_sure_large_one(bundle, line):
    for small in (0.45, 0.55):
        answer = ask(feeling(bundle, belief=_doubtful(small=small)), line)
        assert not answer.abstained
        assert answer.decided in ("clockwise", "rotation", "12 deg")
        assert answer.confidence > 0.9


def test_options_are_the_probabilities_of_what_was_possible(bundle):
    options = ask(feeling(bundle, belief=MIXED), "way all").options
    assert (options["clockwise"], options["left"]) == (0.97, 0.97)
    assert options["none"] == pytest.approx(0.0)
    so = ask(feeling(bundle, belief=MIXED), "cw").options
    assert so == {"yes": pytest.approx(0.97, abs=0.01), "no": pytest.approx(0.03, abs=0.01)}
    choice = ask(feeling(bundle, belief=MIXED), "choose A cw | B ccw").options
    assert choice == {"A": pytest.approx(0.97, abs=0.01), "B": 0.0}


# Forms


@pytest.mark.parametrize(("text", "told"), [
    ("way turn ; as word", "Clockwise."),
    ("amount turn ; as number", "20"),
    ("way sign ; as sign", "+"),
    ("choose A ccw | B cw ; as letter", "B."),
    ("ccw ; as one-zero", "0"),
])  # fmt: skip
def test_the_form_that_is_asked_for_is_kept(bundle, text, told):
    assert ask(feeling(bundle, belief=MIXED), text).text == told


def test_json_holds_what_was_asked_and_how_sure_it_is(bundle):
    answer = ask(feeling(bundle, belief=MIXED), "way turn ; amount turn ; slide ; as json")
    told = json.loads(answer.text)
    assert (told["way"], told["turn_deg"], told["slide"]) == ("clockwise", 20.0, True)
    assert told["probability"] == pytest.approx(answer.confidence, abs=0.001)


def test_json_has_the_keys_that_were_given(bundle):
    answerer = feeling(bundle, belief=MIXED)
    asked = '{"turning": ?, "turn_deg": ?, "sliding": ?}'
    line = "record @1 way turn , @2 amount turn , @3 slide end ; as json"
    answerer.bundle.reader.lines[asked] = line
    told = {"turning": "clockwise", "turn_deg": 20.0, "sliding": True}
    assert json.loads(ask(answerer, asked).text) == told


# Amounts, pixels and rates


def test_pixels_are_named_and_what_millimetres_take(bundle):
    answerer = feeling(bundle, "left")
    answer = ask(answerer, "amount slide")
    assert any("224x224 frames" in note and "mm per pixel" in note for note in answer.notes)
    assert "size of a pixel" in ask(answerer, "unit mm amount slide").text
    told = ask(answerer, "amount slide", frame=FrameSpec(mm_per_px=0.1))
    assert told.amount.unit == "mm"
    assert not any("pixel" in note.lower() for note in told.notes)


def test_what_the_picture_does_not_tell_is_withheld(bundle):
    belief = believed("left")
    belief.readable[Component.SLIDE] = False
    answerer = feeling(bundle, belief=belief)
    assert ask(answerer, "amount slide").abstained
    assert "how far along the edge cannot be seen" in ask(answerer, "way all").text


def test_a_speed_takes_a_frame_rate(bundle):
    answerer = feeling(bundle, belief=believed("clockwise", deg=30.0))
    timed, untimed = answerer.encode(recording(fps=50.0)), answerer.encode(recording())
    assert answerer.ask(timed, "speed turn").amount.value == pytest.approx(500, rel=0.01)
    assert answerer.ask(timed, "per per-min unit turn speed turn").amount.unit == "turn/min"
    assert "--fps 25" in answerer.ask(untimed, "speed turn").text


def test_a_frame_rate_that_is_stated_holds_for_the_rest_of_a_conversation_but_no_other_clip(bundle):
    answerer = feeling(bundle, "clockwise")
    answerer.bundle.reader.lines["at 50 fps"] = "fact rate #1"
    own, timed = (answerer.encode(recording(fps=rate)) for rate in (10.0, 50.0))
    talk = answerer.session(answerer.encode(recording()))
    assert talk.ask("at 50 fps").text == "Noted: 50 frames per second."
    for clip in (timed, own):
        alone = answerer.ask(clip, "speed turn").amount
        assert talk.ask("speed turn").amount.mean == pytest.approx(alone.mean, rel=0.01)
        talk.add_clip(own)


def test_a_stated_frame_rate_stands_before_a_file_s_but_not_before_uneven_times(bundle):
    answerer = feeling(bundle, "clockwise")
    answerer.bundle.reader.lines["at 50 fps"] = "fact rate #1 ; speed turn"
    timed = answerer.ask(answerer.encode(recording(fps=50.0)), "speed turn")
    file_says_10 = recording(fps=10.0)
    stated = answerer.ask(answerer.encode(file_says_10), "at 50 fps")
    assert stated.amount == timed.amount
    assert "Told at 50 frames per second, not at the 10 that the file tells." in stated.notes
    uneven = answerer.encode(replace(file_says_10, times_s=(0.0, 0.1, 0.21, 0.3)))
    kept = answerer.ask(uneven, "at 50 fps")
    assert kept.amount == answerer.ask(uneven, "speed turn").amount != timed.amount
    untold = answerer.encode(replace(recording(), times_s=(0.0, 0.1, 0.21, 0.3)))
    assert answerer.ask(untold, "at 50 fps").amount == timed.amount


# What is no motion, and two clips


def test_talk_claims_nothing_and_what_cannot_be_felt_is_withheld(bundle):
    answer = ask(feeling(bundle, "left"), "Thanks!")
    assert answer.text.startswith("You are welcome")
    assert (answer.direction, answer.decided, answer.kind) == (None, None, "talk")
    unknown = ask(feeling(bundle, "clockwise"), "cannot look")
    assert (unknown.abstained, unknown.direction) == (True, None)


def test_two_clips_are_compared(bundle):
    answerer = feeling(bundle, "clockwise")
    first, second = (answerer.encode(recording(seed=seed)) for seed in (1, 2))
    same = answerer.compare(first, second, "Do they turn the same way?")
    assert (same.decided, same.relation, same.abstained) == ("yes", "same", False)
    assert same.text.startswith("Yes")
    assert answerer.compare(first, second, "of-second way turn").decided == "clockwise"
    which = answerer.compare(first, second, "which-clip ccw")
    assert (which.decided, which.relation) == ("neither", "same")


def test_of_two_recordings_one_that_is_named_is_asked_about_first(bundle):
    answerer = feeling(bundle, "clockwise")
    of_event, of_clip = "within first turn-events amount turn", "of-first amount turn"
    encoded, other = (answerer.encode(recording(seed=seed)) for seed in (1, 2))
    answerer.bundle.reader.lines[ASKED] = [(of_event, 0.5), (of_clip, 0.4)]
    assert answerer.compare(encoded, other, ASKED).resumed == read(of_clip)
    answerer.bundle.reader.lines[ASKED] = [(of_event, 0.85), (of_clip, 0.1)]
    assert answerer.compare(encoded, other, ASKED).resumed == read(of_event)
