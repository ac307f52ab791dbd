"""Pieces of text together are the text, for every sentence there is; nothing is told too early."""

import subprocess
import sys
from itertools import cycle

import pytest

from geotlm_lm.answering import Answer, Answerer
from geotlm_lm.answering.streaming import answer_pieces
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.language.parse_answer import KINDS
from tests.answering.scripted import answerer_saying, believed, feeling, recording

QUESTION = "A) left B) right C) up?"
FRAMES = [
    FrameSpec(),
    FrameSpec(viewpoint="object"),
    FrameSpec(image_mirrored=True),
    FrameSpec(image_upside_down=True),
    FrameSpec(image_quarter_turn="clockwise"),
]


@pytest.fixture(scope="module")
def encoded(bundle):
    return Answerer(bundle).encode(recording(fps=25.0))


def streamed(answerer, encoded, question, frame=FRAMES[0]):
    *words, answer = answerer.stream(encoded, question, frame=frame)
    assert all(isinstance(word, str) for word in words)
    assert isinstance(answer, Answer)
    return words, answer


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("threshold", [0.0, 1.1])
def test_the_pieces_of_every_answer_are_its_text(bundle, encoded, kind, threshold):
    for sentence, frame in zip(bundle.grammar.options_for(kind), cycle(FRAMES), strict=False):
        answerer = answerer_saying(bundle, {"*": sentence}, contact_threshold=threshold)
        words, answer = streamed(answerer, encoded, QUESTION, frame)
        assert "".join(words) == answer.text


def test_the_pieces_of_a_speed_where_no_time_is_known_are_its_text(bundle):
    answerer = answerer_saying(bundle, {"*": "A speed of turning, as measured."})
    words, answer = streamed(answerer, answerer.encode(recording()), "How fast?")
    assert "".join(words) == answer.text


@pytest.mark.parametrize(("kind", "parts"), [("direction", True), ("mirrored", False)])
def test_own_words_come_in_pieces_and_those_of_a_rule_in_one(bundle, encoded, kind, parts):
    sentence = bundle.grammar.options_for(kind)[0]
    words, _ = streamed(answerer_saying(bundle, {"*": sentence}), encoded, "Which way?")
    assert (len(words) > 3) == parts


@pytest.mark.parametrize("felt", ["right", "left"])
def test_words_are_only_begun_where_they_say_what_is_decided(bundle, encoded, felt):
    answerer = feeling(bundle, "left", belief=believed(felt, share=0.45 if felt == "left" else 1.0))
    words, answer = streamed(answerer, answerer.encode(encoded.clip), "Which way?")
    assert words == [answer.text]
    assert answer.told_by == "rule"


def test_words_that_are_no_answer_are_told_apart_by_the_answer(bundle, encoded):
    answerer = answerer_saying(bundle, {"*": "Left, in the camera, I suppose."})
    answerer.bundle.speaker.likes = "Left, in the camera image."
    words, answer = streamed(answerer, encoded, "Which way?")
    assert "".join(words) == "Left, in the camera"[: len("".join(words))]
    assert len(words) > 3
    assert answer.text.startswith("I found no words for that")


def test_what_goes_wrong_is_raised_where_the_pieces_are_awaited(bundle, encoded):
    with pytest.raises(UsageError, match="the question is empty"):
        next(feeling(bundle, "left").stream(encoded, " "))


def test_a_session_streams_its_repetitions_and_comparisons_too(bundle, encoded):
    session = feeling(bundle, "left").session(encoded)
    session.add_clip(encoded)
    for question in ("Which way?", "Are you sure?", "Do they go the same way?"):
        *words, reply = session.stream(question)
        assert "".join(words) == reply.text
    assert [turn.question for turn in session.history][-1] == "Do they go the same way?"


def test_pieces_wait_for_nothing_but_the_next_one():
    told = []

    def ask(listen):
        listen("a")
        told.append("after a")
        raise RuntimeError("broken")

    stream = answer_pieces(ask)
    assert next(stream) == "a"
    with pytest.raises(RuntimeError, match="broken"):
        next(stream)
    assert told == ["after a"]


def test_a_thread_that_still_answers_is_waited_for_when_python_ends():
    program = (
        "import time\n"
        "from geotlm_lm.answering.streaming import answer_pieces\n"
        "def ask(listen):\n"
        "    listen('a')\n"
        "    time.sleep(0.3)\n"
        "    print('answered', flush=True)\n"
        "    raise RuntimeError\n"
        "stream = answer_pieces(ask)\n"
        "print(next(stream), flush=True)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (done.stdout, done.stderr, done.returncode) == ("a\nanswered\n", "", 0)
