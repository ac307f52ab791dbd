"""Parse statements of how far and which way the recorded image is rotated.

What is turned decides the sense. Of an image that is turned clockwise, what was up is on the right.
A camera mounted turned clockwise, as seen from behind it looking where it looks, or a sensor with
its camera in it, records an image turned counterclockwise; a mirror counts as standing before that
camera. To the right is clockwise and to the left counterclockwise, as pictures are turned on a
screen.

A turn is read to the letter or not at all. One that is told without its angle or its sense is not
guessed: `unclear_rotation` says what is missing.
"""

from __future__ import annotations

import re
from typing import Any

from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import normalised_text
from geotlm_lm.core.frame_spec import FrameSpec

_PHRASES = Phrases("image_rotation")
_ASIDE = _PHRASES.group("ASIDE")


_FACTS = tuple(re.compile(words) for words in _PHRASES.each("FACTS"))
"""What may be said, to the letter; of all that is no image a camera is turned."""

_NO_TURN = _PHRASES.pattern("NO_TURN")
_SIZED = _PHRASES.pattern("SIZED")
_NUMBER = re.compile(r"\d+(?:\.\d+)?")
_SENSE = _PHRASES.pattern("SENSE")


def read_image_rotation(clause: str) -> dict[str, Any] | None:
    """Return the fields of `FrameSpec` that a clause, lower case, on a rotated image sets."""
    if (denied := _NO_TURN.fullmatch(clause)) is not None:
        said = denied["by"] or denied["so"]
        return {"image_quarter_turn": None} if said else FrameSpec.fields_of_turn(0)
    for words in _FACTS:
        if (said := words.fullmatch(clause)) is None:
            continue
        degrees, sense = _degrees(clause), _SENSE.search(clause)
        if degrees not in (90, 180, 270) or (sense is None and degrees != 180):
            return None
        of_whom = said.groupdict()
        # To the left once, and once more for a camera: two inversions are none.
        inversions = bool(sense and sense["counter"]) + (of_whom.get("image") is None)
        mirrored = {"image_mirrored": True} if of_whom.get("mirrored") else {}
        return FrameSpec.fields_of_turn(-degrees if inversions % 2 else degrees) | mirrored
    return None


def _degrees(text: str) -> float | None:
    """Return by how many degrees something is said to be turned; None where it is not said."""
    if (size := _SIZED.search(text)) is None:
        return None
    number = _NUMBER.search(size[0])
    return 90.0 if number is None else float(number[0])


_BEFORE = _PHRASES.text("BEFORE")

_MENTIONS = tuple(re.compile(_BEFORE + words) for words in _PHRASES.each("MENTIONS"))
"""Words that say of the image, or of what holds the camera, that it does not stand upright."""

_SAYS_NO_TURN = _PHRASES.pattern("SAYS_NO_TURN")
_TAG = _PHRASES.pattern("TAG")
_OF_A_CLIP = _PHRASES.pattern("OF_A_CLIP")
_OF_AN_IMAGE = _PHRASES.pattern("OF_AN_IMAGE")
_EXAMPLES = (
    "the image is turned by 90 degrees clockwise",
    "the camera is mounted turned by 90 degrees clockwise",
)

_SAY_SENSE = (
    "I cannot tell a direction without the way it is turned: say clockwise or counterclockwise, "
    "such as '{}'."
)
_SAY_SIZE = (
    "I cannot tell a direction without knowing how it is turned: say by 90 degrees which way, or "
    "by 180, such as '{}'."
)
_SAY_MOUNTED = (
    "I turn an image back only where it was recorded so: say 'the sensor is mounted upside down' "
    "if it is; a sensor that is turned for once, with its camera in it, shows the same image."
)
_HALF_TURNED = _PHRASES.pattern("HALF_TURNED")

_OTHER_SIZE = (
    "I tell directions for an image turned by 90, 180 or 270 degrees, not by {:g}: turn the "
    "recording upright first."
)
_SAY_IT_FIRST = (
    "I turn an image back only where it is said before the question that it was recorded so, such "
    "as '{}'."
)
_ONE_TURN = (
    "I turn an image back only where it is said before the question by one turn: upside down and "
    "turned by 90 degrees are two; give one of the two, or both taken together, such as '{}'."
)
_TWO_TURNS = _PHRASES.pattern("TWO_TURNS")
_ON_HEAD_AND = _PHRASES.pattern("ON_HEAD_AND")


def unclear_rotation(text: str, typed: str = "") -> str | None:
    """Return what is missing in a stated image rotation; None where none is stated.

    Args:
        text: What is left once the facts that could be read are taken out. A question whether the
            image is turned tells no turn; one that supposes it does.
        typed: All that was typed, with the facts.
    """
    text = normalised_text(text)
    if _HALF_TURNED.search(text):
        return _SAY_MOUNTED
    for words in _MENTIONS:
        said = words.search(text)
        if said is None or _SAYS_NO_TURN.search(text[: said.end("before")]):
            continue
        if asks_whether_clip_turned(said[0], text[said.end() :]):
            continue
        return _missing(said[0], f"{text} {typed.lower()}")
    return None


def asks_whether_clip_turned(said: str, after: str) -> bool:
    """Tell whether a "turned" clip is mentioned only to ask whether its content turned.

    Args:
        said: What is said of the clip.
        after: What follows: a tag such as ", right?".
    """
    is_of_clip = _OF_A_CLIP.search(said.lower()) and re.search(r"\d", said)
    return bool(is_of_clip and _TAG.fullmatch(after.lower()))


def _missing(said: str, text: str) -> str:
    example = _EXAMPLES[_OF_AN_IMAGE.search(said) is None]
    told = _ON_HEAD_AND.sub("", said)
    degrees = _degrees(told)
    if degrees is None and re.search(_ASIDE, told):
        degrees = 90.0
    if degrees is None:
        return _SAY_SIZE.format(example)
    if degrees not in (90, 180, 270):
        return _OTHER_SIZE.format(degrees)
    if degrees != 180 and _SENSE.search(told) is None:
        return _SAY_SENSE.format(example)
    if degrees != 180 and _TWO_TURNS.search(text):
        return _ONE_TURN.format(example)
    return _SAY_IT_FIRST.format(example)
