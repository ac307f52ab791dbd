"""Detect statements about the recording in which no fact could be read."""

from __future__ import annotations

import re

from geotlm_lm.conversation.motion_names import motions_named
from geotlm_lm.conversation.text_normalisation import normalised_text

UNREAD = (
    "I read no fact about the recording in that; say for example 'left-hand thread', 'the image is "
    "mirrored' or 'I look from the object's side'."
)

TURN_TOLD_AFTER = (
    "What was said of the image after the question is not counted in; tell it before the question."
)

_STATEMENT = re.compile(
    r"(?:(?:no|well|actually|note(?: that)?|fyi|but|and|so|please note(?: that)?)[,:]? )*"
    r"(?:the|my|our|it'?s|it is|this is|i|we|there(?:'s| is))\b"
)
_OF_A_FRAME = re.compile(
    r"\b(?:mirror\w*|flipped|upside|image|picture|camera|sensor|gripper|robot|gel|thread\w*|head"
    r"|shank|viewpoint|mounted|clamped|fixed)\b"
)
_STATES = re.compile(
    r"\b(?:is|was|are|were|has|have|had|moved?|moves|stay\w*|stood|look\w*|press\w*|touch\w*|hold\w*"
    r"|turned|rotated|it's)\b"
)
_OF_A_SETUP = re.compile(
    r"(?:(?:no|well|actually|and|but|so|note(?: that)?)[,:]? )*(?:the|my|our) (?:sensor|camera"
    r"|image|picture|gripper|robot|gel)(?:'s \w+)? (?:(?:is|was|are|were) (?!\w+ing\b)|points?\b"
    r"|sits?\b|hangs?\b|faces?\b|comes? out\b|goes (?:in|out)\b)"
)
"""Says how something stands, where a word such as "right" or "up" is a place and no motion."""

_ASKS = re.compile(
    r"[?]|\b(?:which|what|how|why|when|where|who|whose|whether|if|do|does|did|tell|say|describe|know"
    r"|want|wonder|motion|movement|direction|touch\w*|contact|tighten\w*|loosen\w*|is it)\b"
    r"|\bit (?:is|was) \w+ing\b|\bmov\w+ (?:on|over|across|along|relative to) the (?:gel|sensor)\b"
)


def is_unread_statement(text: str) -> bool:
    """Tell whether `text`, in which no fact was read, seems to state one about the recording.

    Such a statement is no question: an answer to it would pass over what was meant.
    """
    text = normalised_text(text)
    if _OF_A_SETUP.match(text) and not _ASKS.search(text):
        return True
    is_said = bool(_STATEMENT.match(text) and _STATES.search(text))
    is_of_a_frame = bool(_OF_A_FRAME.search(text)) and not motions_named(text)
    return is_said and is_of_a_frame and not _ASKS.search(text)
