"""Check the arguments of an `Answerer`'s methods: one clear sentence in place of a raw error."""

from __future__ import annotations

from geotlm_lm.answering.answer import Answer
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.core.frame_spec import FrameSpec


def require_encoded(*given: object) -> None:
    """Raise unless the argument is an encoded clip.

    Raises:
        TypeError: If one is something else, such as a path or a clip.
    """
    for each in given:
        if not isinstance(each, Encoded):
            raise TypeError(
                f"an encoded clip was expected, found {type(each).__name__}; encode it first, by "
                f"answerer.encode(read_clip(path)) or answerer.encode(Clip(frames))"
            )


def require_frame(given: object) -> None:
    """Raise unless the argument is a frame of reference.

    Raises:
        TypeError: If it is something else, such as None or a dictionary.
    """
    if not isinstance(given, FrameSpec):
        raise TypeError(
            f"a frame is a FrameSpec, found {type(given).__name__}; give for example "
            f"FrameSpec(viewpoint='object'), or leave it out"
        )


def require_answer(given: object) -> None:
    """Raise unless the argument is an answer about one clip.

    Raises:
        TypeError: If it is something else, such as a comparison.
    """
    if not isinstance(given, Answer):
        raise TypeError(
            f"reasons are given for an Answer, found {type(given).__name__}; pass on what "
            f"answerer.ask(encoded, question) returns"
        )
