"""Questions whose words a rule reads, whatever a model would make of them."""

import pytest

from geotlm_lm.answering import OPEN_QUESTION
from geotlm_lm.answering.overruling import read_by_rule
from geotlm_lm.conversation.either_or import OF_THE_END
from geotlm_lm.conversation.untold import ONE_KIND
from geotlm_lm.core.labels import Motion
from geotlm_lm.language.parse_answer import Slots
from tests.answering.scripted import answerer_saying, feeling, recording


def asked(bundle, felt, question):
    """The answer of a model that feels `felt` and takes the question for one about any motion."""
    opened = bundle.grammar.sentence(Slots("direction", Motion(felt)))
    answerer = answerer_saying(bundle, {"*": "Yes, it is moving.", OPEN_QUESTION: opened})
    encoded = answerer.encode(recording())
    answer = answerer.ask(encoded, question)
    *words, streamed = answerer.stream(encoded, question)
    assert ("".join(words), streamed.decided) == (answer.text, answer.decided)
    return answer


@pytest.mark.parametrize(
    ("question", "felt", "text", "decided"),
    [
        (
            "It is not moving, right?",
            "still",
            "Yes, that is so: it is touching but not moving.",
            "yes",
        ),
        (
            "Is it correct that nothing moves?",
            "clockwise",
            "No, that is not so: it goes clockwise in the camera image.",
            "no",
        ),
        (
            "It isn't sliding, is it?",
            "clockwise",
            "Yes, that is so: it goes clockwise in the camera image.",
            "yes",
        ),
        (
            "Is it false that it slides left?",
            "left",
            "No, that is not so: it goes left in the camera image.",
            "no",
        ),
        ("Any rotation?", "left", "No, it goes left in the camera image.", "no"),
        ("translation detected?", "left", "Yes, it goes left in the camera image.", "yes"),
        ("Does it slide while being pressed?", "press", "No, it is pressing in.", "no"),
        (
            "Does the top go right?",
            "clockwise",
            "Yes, the upper half goes right: it goes clockwise in the camera image.",
            "yes",
        ),
        (
            "Does the upper half go right?",
            "left",
            "No, the upper half goes left: it goes left in the camera image.",
            "no",
        ),
        (
            "Which way does the top edge move?",
            "clockwise",
            "The upper half goes right, in the camera image.",
            "right",
        ),
        (
            "(a) clockwise (b) counterclockwise (c) not rotating",
            "counterclockwise",
            "Counterclockwise, in the camera image, option B.",
            "B) counterclockwise",
        ),
        (
            "A) slips B) does not slip",
            "still",
            "It is still: touching but not moving, option B.",
            "B) does not slip",
        ),
        ("left, right or neither?", "up", "Neither: it goes up in the camera image.", "up"),
        ("left, right or neither?", "left", "Left, in the camera image.", "left"),
    ],
)
def test_what_a_rule_reads_is_answered_by_the_motion_told_openly(
    bundle, question, felt, text, decided
):
    answer = asked(bundle, felt, question)
    assert (answer.text, answer.decided, answer.told_by) == (text, decided, "rule")
    assert answer.confidence == pytest.approx(answer.options[answer.decided])
    assert answer.direction == Motion(felt)


@pytest.mark.parametrize(
    ("felt", "text", "decided"),
    [
        ("left", "A slide.", "slide"),
        ("still", "A still contact.", "still"),
        ("clockwise", "None of these: it goes clockwise in the camera image.", "rotation"),
        ("none", "None of these: the gel is untouched.", "none"),
    ],
)
def test_of_a_kind_or_rest_it_is_told_which(bundle, felt, text, decided):
    answer = asked(bundle, felt, "Is it slipping or stationary?")
    assert (answer.text, answer.decided, answer.kind) == (text, decided, "class")


@pytest.mark.parametrize(
    ("felt", "text", "is_limited"),
    [
        ("clockwise", "Yes, it goes clockwise in the camera image.", True),
        ("left", "No, it goes left in the camera image.", False),
        ("still", "No, it is touching but not moving.", False),
    ],
)
def test_whether_it_goes_on_is_told_as_far_as_it_is_known(bundle, felt, text, is_limited):
    answer = asked(bundle, felt, "Is it still turning or did it stop?")
    assert (answer.text, OF_THE_END in answer.notes) == (text, is_limited)


@pytest.mark.parametrize(("question", "decided"), [("turning?", "yes"), ("Up or not?", "no")])
def test_a_word_alone_is_judged(bundle, question, decided):
    assert asked(bundle, "clockwise", question).decided == decided


@pytest.mark.parametrize(
    ("question", "decided"),
    [
        ("does the row index decrease?", "yes"),
        ("is dy positive?", "no"),
        ("is it moving along -y?", "yes"),
        ("is it moving along +y?", "no"),
        ("The image is upside down. Is dy positive?", "yes"),
        ("The image is upside down. Does the row index decrease?", "yes"),
    ],
)
def test_a_sign_of_an_axis_is_a_way_and_rows_are_those_recorded(bundle, question, decided):
    assert asked(bundle, "up", question).decided == decided


@pytest.mark.parametrize(
    ("question", "felt", "decided"),
    [
        ("Is it anything but a rotation?", "clockwise", "no"),
        ("Is it anything but a rotation?", "left", "yes"),
        ("Sorry to bother you, but it can't be sliding, can it?", "left", "no"),
    ],
)
def test_a_denial_in_other_words_is_judged(bundle, question, felt, decided):
    assert asked(bundle, felt, question).decided == decided


@pytest.mark.parametrize(
    ("question", "limit"),
    [
        ("Does it slide as well as rotate?", ONE_KIND),
        ("Which way does it turn in the world frame?", "Nothing tells how the camera stands in"),
    ],
)
def test_what_no_recording_tells_is_said_beside_the_answer(bundle, question, limit):
    answer = asked(bundle, "clockwise", question)
    assert answer.text == "Clockwise, in the camera image."
    assert any(note.startswith(limit) for note in answer.notes)


def test_a_model_of_few_kinds_is_judged_by_the_same_rules(bundle):
    answerer = feeling(bundle, "still")
    answer = answerer.ask(answerer.encode(recording()), "It's not slipping, right?")
    assert (answer.kind, answer.decided) == ("verify", "yes")


def test_a_frame_told_before_holds_for_a_claim_about_a_half(bundle):
    answer = asked(bundle, "clockwise", "The image is mirrored. Does the top go left?")
    assert answer.decided == "yes"


@pytest.mark.parametrize(
    "question",
    [
        "Is it not turning left?",
        "Is it moving?",
        "Where does the upper half go?",
        "Is it not moving, played backwards?",
        "Which way does it move?",
        "A) left B) right",
        "How sure are you that it does not move?",
    ],
)
def test_what_the_model_reads_is_left_to_it(question):
    assert read_by_rule(question) is None
