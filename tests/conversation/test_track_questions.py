"""What of a whole recording a question asks for, what it is about, and which span it names."""

import pytest

from geotlm_lm.conversation.track_questions import (
    Doing,
    Span,
    TrackAsk,
    asked_doing,
    asked_span,
    track_ask,
)

ASKS = {
    TrackAsk.STORY: (
        "What happened?",
        "What happens in this recording?",
        "In what order did it move?",
        "List the events.",
        "Describe everything step by step.",
    ),
    TrackAsk.FIRST: ("What happened first?", "What did it do first?"),
    TrackAsk.LAST: ("What happens last?", "What was the last motion?"),
    TrackAsk.NEXT: ("And then what?", "What happened next?"),
    TrackAsk.FASTEST: ("When was it turning fastest?", "At which time was the top speed?"),
    TrackAsk.TURNED_BACK: (
        "How often did it turn back?",
        "How many times did the cap change direction?",
        "Did it ever turn back?",
    ),
    TrackAsk.COUNT: ("How many turns were there?", "How many times did it slide?"),
    TrackAsk.DURATION: ("How long was it held?", "For how many seconds did it turn?"),
    TrackAsk.BEGAN: (
        "When did it start to turn?",
        "At what time does the slide begin?",
        "When was it let go?",
        "In which frame was the first contact?",
    ),
    TrackAsk.ENDED: ("When did it stop turning?", "At what second does the slide end?"),
    TrackAsk.SLIPPED: ("Did it slip before it was let go?",),
    None: (
        "Which way is it turning?",
        "How far did it turn in total?",
        "Is it sliding to the left?",
        "How fast does it turn?",
        "Is anything touching?",
    ),
}


@pytest.mark.parametrize(
    ("question", "ask"), [(text, ask) for ask, texts in ASKS.items() for text in texts]
)
def test_what_is_asked_of_a_recording(question, ask):
    assert track_ask(question) is ask


@pytest.mark.parametrize(
    ("question", "doing"),
    [
        ("When was it let go?", Doing.LET_GO),
        ("How often did it slip?", Doing.SLIP),
        ("How long was it at rest?", Doing.STILL),
        ("How long was it held?", Doing.HOLD),
        ("When was it pressed in?", Doing.PRESS),
        ("When did it stop rotating?", Doing.TURN),
        ("How many slides were there?", Doing.SLIDE),
        ("When did it move?", None),
    ],
)
def test_what_it_does_that_is_asked_about(question, doing):
    assert asked_doing(question) is doing


@pytest.mark.parametrize(
    ("question", "span"),
    [
        ("Which way does it turn between 1 s and 2 s?", Span(1, 2, "s")),
        ("Which way does it turn from 0.5 to 1.5 seconds?", Span(0.5, 1.5, "s")),
        ("What happened between frames 40 and 60?", Span(40, 60, "frames")),
        ("How far does it slide in frames 40:60?", Span(40, 60, "frames")),
        ("How far does it turn between 200 and 900 ms?", Span(0.2, 0.9, "s")),
        ("What happens after 2 seconds?", Span(2, None, "s")),
        ("What happens before frame 30?", Span(None, 30, "frames")),
        ("Does it turn in the first two seconds?", Span(None, 2, "s")),
        ("Does it turn in the last 10 frames?", Span(10, None, "frames", is_from_end=True)),
        ("Does it turn in the last second?", Span(1, None, "s", is_from_end=True)),
    ],
)
def test_the_span_that_is_named_is_taken_out_of_the_question(question, span):
    rest, found = asked_span(question)
    assert found == span
    assert not any(letter.isdigit() for letter in rest)
    assert asked_span(rest) is None


@pytest.mark.parametrize(
    "question",
    [
        "Does it turn between 10 and 20 degrees?",
        "Is it faster than 10 degrees per second?",
        "Did it turn by 5 to 8 degrees?",
        "What happens after it is let go?",
    ],
)
def test_other_numbers_are_no_span(question):
    assert asked_span(question) is None
