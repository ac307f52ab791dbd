"""Recognise questions about the frame of reference itself: "is the image mirrored?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.motion_claims import CLASS_NAMES
from geotlm_lm.conversation.object_names import with_generic_objects
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.question import OPEN_QUESTION
from geotlm_lm.conversation.text_normalisation import normalised_text, without_openers
from geotlm_lm.conversation.wording import frame_summary
from geotlm_lm.core.frame_spec import FrameSpec

_PHRASES = Phrases("frame_questions")
_ASKED = _PHRASES.pattern("ASKED")
_LEFT_OPEN = _PHRASES.pattern("LEFT_OPEN")
_OF_REFERENCE = _PHRASES.pattern("OF_REFERENCE")
_WHERE_FROM = _PHRASES.pattern("WHERE_FROM")
_WHO = _PHRASES.pattern("WHO")
_SENSOR_NAMED = _PHRASES.pattern("SENSOR_NAMED")
RELATIVE = (
    "I feel only how the object moves relative to the sensor, not which of the two moves; I tell "
    "it as the object's motion, and of the sensor the opposite."
)
_ANOTHER = _PHRASES.pattern("ANOTHER")
_ANOTHER_VIEW = _PHRASES.pattern("ANOTHER_VIEW")
_NOT_KNOWN = "Nothing tells how the camera stands in the {}: ways are told as its image shows them."
_NO_SUCH_VIEW = (
    "Nothing tells how the camera stands to that view: ways are told as its image shows them."
)
_TOLD = (
    "No touch tells whether the image is mirrored or turned; I take this frame: {}; say for "
    "example 'the image is mirrored' or 'the image is not mirrored'."
)


def frame_clarification(text: str, frame: FrameSpec) -> str | None:
    """Return what is assumed of the image, where a question asks for it or leaves it open.

    Args:
        text: What is left once the facts that could be read are taken out.
        frame: What is known.
    """
    text = without_openers(text)
    if not (_ASKED.fullmatch(text) or _LEFT_OPEN.fullmatch(text)):
        return None
    return _TOLD.format(frame_summary(frame))


def unknown_frame_request(question: str) -> tuple[str, str] | None:
    """Return a request for a frame no recording defines, with the sentence that says so.

    None where no such frame is named: "which way does it go in the world frame?" names one.
    """
    text = normalised_text(question)
    said = _ANOTHER.search(text)
    limit = _NO_SUCH_VIEW if said is None else _NOT_KNOWN.format(said["name"])
    said = said or _ANOTHER_VIEW.search(text)
    if said is None:
        return None
    rest = f"{text[: said.start()]}{text[said.end() :]}".strip()
    is_asked = len(re.findall(r"\w+", rest)) > 1
    return rest if is_asked else OPEN_QUESTION, limit


def asks_frame(question: str) -> bool:
    """Tell whether `question` asks for the frame of reference of directions."""
    text = without_openers(question)
    return bool(_OF_REFERENCE.fullmatch(text) or _WHERE_FROM.fullmatch(text))


def asks_which_moves(question: str) -> bool:
    """Tell whether `question` asks if it is the sensor or the object that moves."""
    plain = without_openers(question)
    if sum(bool(re.search(words, plain)) for _, words in CLASS_NAMES) > 1 or "still" in plain:
        return False  # "is the sensor turning or the object sliding?"
    texts = with_generic_objects(plain)
    return any(_WHO.fullmatch(text) and len(_SENSOR_NAMED.findall(text)) == 1 for text in texts)
