"""What is no encoded clip, no frame or no kind is refused in one sentence wherever it is given."""

from pathlib import Path

import pytest

from tests.answering.scripted import feeling, recording

ENCODE_FIRST = (
    "an encoded clip was expected, found {}; encode it first, by answerer.encode(read_clip(path)) "
    "or answerer.encode(Clip(frames))"
)


@pytest.fixture(scope="module")
def answerer(bundle):
    return feeling(bundle, "left")


@pytest.fixture(scope="module")
def encoded(answerer):
    return answerer.encode(recording())


CALLS = {
    "ask": lambda answerer, encoded, given: answerer.ask(given, "Which way?"),
    "session": lambda answerer, encoded, given: answerer.session(given),
    "add_clip": lambda answerer, encoded, given: answerer.session(encoded).add_clip(given),
    "compare": lambda answerer, encoded, given: answerer.compare(encoded, given),
    "why": lambda answerer, encoded, given: answerer.why(
        given, answerer.ask(encoded, "Which way?")
    ),
}


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize(
    ("given", "found"),
    [
        ("clip.npz", "str"),
        (Path("clip.npz"), "PosixPath"),
        (recording(), "Clip"),
        (recording().frames, "ndarray"),
        (None, "NoneType"),
    ],
    ids=["text", "path", "clip", "array", "none"],
)
def test_what_is_not_encoded_is_told_to_be_encoded(answerer, encoded, call, given, found):
    with pytest.raises(TypeError) as caught:
        CALLS[call](answerer, encoded, given)
    assert str(caught.value) == ENCODE_FIRST.format(found)


@pytest.mark.parametrize(("given", "found"), [(None, "NoneType"), ({}, "dict"), ("object", "str")])
def test_what_is_no_frame_is_refused_with_what_to_give(answerer, encoded, given, found):
    calls = (
        lambda: answerer.ask(encoded, "Which way?", frame=given),
        lambda: answerer.compare(encoded, encoded, frame=given),
        lambda: answerer.session(encoded, given),
    )
    for call in calls:
        with pytest.raises(TypeError) as caught:
            call()
        assert str(caught.value) == (
            f"a frame is a FrameSpec, found {found}; give for example "
            f"FrameSpec(viewpoint='object'), or leave it out"
        )


def test_reasons_are_given_for_an_answer_about_one_clip(answerer, encoded):
    with pytest.raises(TypeError) as caught:
        answerer.why(encoded, answerer.compare(encoded, encoded))
    assert str(caught.value) == (
        "reasons are given for an Answer, found Comparison; pass on what answerer.ask(encoded, "
        "question) returns"
    )


@pytest.mark.parametrize("span", [5, (0.0, 2.5), (1,), (0, 2, 3), "ab", ()])
def test_a_span_is_two_whole_numbers(answerer, span):
    with pytest.raises(TypeError) as caught:
        answerer.encode(recording(frames=6), span=span)
    assert str(caught.value) == (
        f"a span is two frame numbers, found {span}; give the first and the last to use, such as "
        f"(40, 60)"
    )


def test_a_span_may_be_a_list(answerer):
    encoded = answerer.encode(recording(frames=6), span=[0, 3])
    assert (encoded.clip.frame_numbers, encoded.track) == ((0, 1, 2, 3), None)
