"""Questions about two clips, through the seam: compared, told of one of them, or declined."""

import pytest

from geotlm_lm.conversation.future import NOT_TO_COME
from geotlm_lm.language.parse_answer import Slots
from tests.answering.scripted import answerer_saying, recording


@pytest.fixture
def two_turns(bundle):
    """An answerer whose model says that every clip turns, and two clips."""
    said = {
        "*": "Clockwise, in the camera image.",
        "How far did it go?": "An amount of turning, as measured.",
        "How fast did it go?": "A speed of turning, as measured.",
    }
    answerer = answerer_saying(bundle, said, temperature=0.1)
    return answerer, [answerer.encode(recording(seed=seed)) for seed in (1, 2)]


@pytest.mark.parametrize(
    "question",
    ["Are they the same object?", "Are both round?", "Is it the same person?", "Tell me a story."],
)
def test_what_is_about_neither_directions_nor_amounts_is_declined(two_turns, question):
    answerer, clips = two_turns
    compared = answerer.compare(*clips, question)
    assert compared.text.startswith("Of two clips I tell whether they go the same way, which one")
    assert (compared.relation, compared.confidence, compared.abstained) == ("unknown", 0.0, True)


def test_what_touch_cannot_tell_of_two_clips_is_declined_as_of_one(bundle, two_turns):
    answerer, clips = two_turns
    refusal = bundle.grammar.sentence(Slots("refusal"))
    assert answerer.compare(*clips, "What colour are they?").text == refusal
    assert "depth" in answerer.compare(*clips, "Which has the greater force?").text
    assert answerer.compare(*clips, "Will it slip?").text == NOT_TO_COME


def test_the_kind_of_motion_is_compared_of_a_clip_supposed_mirrored_too(two_turns):
    answerer, clips = two_turns
    compared = answerer.compare(*clips, "Would they be the same kind if the second was mirrored?")
    assert compared.decided == "yes"
    assert "counterclockwise" in compared.text
    assert compared.text.endswith("with the second mirrored.")


@pytest.mark.parametrize("which", ["first", "second"])
def test_one_of_two_clips_is_told_alone(two_turns, which):
    answerer, clips = two_turns
    compared = answerer.compare(*clips, f"Which way does the {which} one go?")
    assert compared.text == f"Of the {which}: Clockwise, in the camera image."
    assert (compared.relation, compared.abstained) == (which, False)
    assert compared.confidence > 0.9
    assert answerer.compare(*clips, f"And the {which} one?").text == compared.text


def test_how_far_each_goes_is_told_of_both(two_turns):
    answerer, clips = two_turns
    compared = answerer.compare(*clips, "How far do they go?")
    assert compared.text.startswith("Of the first: About 13 degrees of turning")
    assert "Of the second: About 13 degrees of turning" in compared.text
    assert not compared.abstained


def test_a_session_tells_the_first_of_two_clips_when_it_is_asked_about(two_turns):
    answerer, (first, second) = two_turns
    session = answerer.session(first)
    session.add_clip(second)
    for question in ("Which way does the first one go?", "Which way does the first go?"):
        assert session.ask(question).text == "Of the first: Clockwise, in the camera image."
    assert session.ask("Are they the same object?").abstained


@pytest.mark.parametrize(
    "said", ["It is pressing in.", "It is still: touching but not moving.", "It is lifting off."]
)
@pytest.mark.parametrize("question", ["Which one goes further?", "Which is faster?"])
def test_what_goes_no_way_has_no_amount_to_compare(bundle, said, question):
    answerer = answerer_saying(bundle, {"*": said}, temperature=0.1)
    clips = [answerer.encode(recording(seed=seed)) for seed in (1, 2)]
    compared = answerer.compare(*clips, question)
    assert compared.text.startswith("I cannot compare them: not both of them turn or slide.")
    assert (compared.relation, compared.abstained) == ("unknown", True)


@pytest.mark.parametrize(
    "question",
    [
        "Do they match?",
        "Do both clips do the same thing?",
        "Do they go in the same general direction?",
    ],
)
def test_other_words_for_the_same_way_compare(two_turns, question):
    answerer, clips = two_turns
    assert answerer.compare(*clips, question).relation == "same"


def test_a_doubt_about_one_of_two_clips_is_of_that_clip(two_turns):
    answerer, (first, second) = two_turns
    session = answerer.session(first)
    session.add_clip(second)
    session.ask("and the second?")
    assert session.ask("How sure are you of the first?").text.startswith("Of the first: ")
