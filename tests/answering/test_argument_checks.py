"""What is no clip, no frame, no question or no kind is refused in one sentence wherever given."""

import pytest

from geotlm_lm.core.errors import UsageError, check_question
from tests.answering.scripted import feeling, recording

ENCODE_FIRST = (
    "an encoded clip was expected, found {}; encode it first, by answerer.encode(read_clip(path)) "
    "or answerer.encode(Clip(frames))"
)
FRAME = (
    "a frame is a FrameSpec, found {}; give for example FrameSpec(viewpoint='object'), or leave it "
    "out"
)
NO_CLIP = (
    "encode takes a Clip, found str; read a file by read_clip(path), or make one of an array by "
    "Clip(frames)"
)
NO_ANSWER = (
    "reasons are given for an Answer, found Comparison; pass on what answerer.ask(encoded, "
    "question) returns"
)


@pytest.fixture(scope="module")
def answerer(bundle):
    return feeling(bundle, "left")


@pytest.fixture(scope="module")
def encoded(answerer):
    return answerer.encode(recording())


CALLS = {
    "encode": (lambda by, _: by.encode("clip.npz"), NO_CLIP),
    "ask": (lambda by, _: by.ask("clip.npz", "Which way?"), ENCODE_FIRST.format("str")),
    "session": (lambda by, _: by.session(recording()), ENCODE_FIRST.format("Clip")),
    "add_clip": (
        lambda by, clip: by.session(clip).add_clip(recording().frames),
        ENCODE_FIRST.format("ndarray"),
    ),
    "compare": (lambda by, clip: by.compare(clip, None), ENCODE_FIRST.format("NoneType")),
    "why": (
        lambda by, clip: by.why("clip.npz", by.ask(clip, "Which way?")),
        ENCODE_FIRST.format("str"),
    ),
    "ask in a frame": (
        lambda by, clip: by.ask(clip, "Which way?", frame=None),
        FRAME.format("NoneType"),
    ),
    "compare in a frame": (
        lambda by, clip: by.compare(clip, clip, frame={}),
        FRAME.format("dict"),
    ),
    "session in a frame": (lambda by, clip: by.session(clip, "object"), FRAME.format("str")),
    "why of a comparison": (lambda by, clip: by.why(clip, by.compare(clip, clip)), NO_ANSWER),
    "question": (
        lambda *_: check_question(None),
        "a question is a text, found NoneType; give one such as 'Which way is it moving?'",
    ),
}


@pytest.mark.parametrize("call", CALLS)
def test_what_is_of_another_kind_is_refused_with_what_to_give(answerer, encoded, call):
    make, sentence = CALLS[call]
    with pytest.raises(TypeError) as caught:
        make(answerer, encoded)
    assert str(caught.value) == sentence


def test_a_question_that_is_no_text_is_refused():
    with pytest.raises(UsageError, match="holds bytes that are no text"):
        check_question("which way \udce4?")


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
