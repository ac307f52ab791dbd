"""Recognise questions about the frame of reference itself: "is the image mirrored?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.frame_fact_patterns import IMAGE, UPSIDE_DOWN_PHRASE
from geotlm_lm.conversation.kind_words import HOLDER
from geotlm_lm.conversation.motion_claims import CLASS_NAMES
from geotlm_lm.conversation.object_names import THING, with_generic_objects
from geotlm_lm.conversation.question import OPEN_QUESTION
from geotlm_lm.conversation.text_normalisation import normalised_text, without_openers
from geotlm_lm.conversation.wording import frame_summary
from geotlm_lm.core.frame_spec import FrameSpec

_HOW = (
    rf"(?:mirrored|flipped(?: left[ -]to[ -]right)?|(?:turned|rotated)|{UPSIDE_DOWN_PHRASE}|upright"
    r"|right side up|the right way up)"
)
_ASKED = re.compile(
    rf"(?:(?:is|was) {IMAGE} (?:recorded )?{_HOW}"
    rf"|(?:is|was) (?:the|my) sensor mounted {_HOW})"
    rf"(?: or (?:not|{_HOW}))?[ ?.!]*"
)
_LEFT_OPEN = re.compile(
    r"(?:(?:i (?:do not|don't|cannot|can't) (?:know|tell|remember|say)"
    r"|i(?:'m| am) not (?:sure|certain)"
    rf"|maybe|perhaps|possibly|i think|i guess) ?(?:whether|if|that)? ?{IMAGE} (?:is|was) {_HOW}"
    rf"(?: or not)?|{IMAGE} (?:might|may|could) (?:be|have been) {_HOW})[ ?.!]*"
)
_OF_REFERENCE = re.compile(
    r"(?:(?:in|relative to|with respect to) )?(?:what|which)(?:'s| is)?"
    r"(?: (?:the|your))? (?:frame of reference|(?:reference|coordinate) (?:frame|system)"
    r"|frame(?= (?:is|are|was|were|do|did) (?:this|that|it|the|your|you|directions?|they)\b"
    r"(?: (?:answer|directions?|motion|answers))?"
    r"(?: (?:told|given|named|meant|in|us(?:e|ed|ing)|speak in"
    r"|tell (?:it|that|directions)(?: in)?))?\W*$))"
    r"(?: (?:is|are|was|were|do|did|does) .*| of .*)?\W*"
)
_WAY = r"(?:(?:counter|anti)?clockwise|c?cw|left|right|up|down)"
_WHERE_FROM = re.compile(
    r"(?:(?:in|by|with|using) (?:what|which) (?:frame|coordinates?|convention|axes)(?: system)?"
    r"|(?:relative|with respect|compared) to what"
    r"|what(?:'s| is) (?:the|your) (?:reference|convention|viewpoint|point of view|perspective)"
    r"|from (?:what|which) (?:side|view|viewpoint|angle|perspective|point of view|direction)"
    rf"(?: is (?:that|this|it)(?: {_WAY})?)?"
    r"|from where|seen from where|whose (?:view|perspective|left|right|up|down)(?: is (?:it|that))?"
    rf"|{_WAY} (?:(?:as )?(?:seen|viewed|looking) )?(?:from where|by whom|relative to what"
    r"|in (?:what|which) frame|from (?:what|which) side)"
    rf"|what (?:does|do you mean by|is meant by|counts as) '?\"?{_WAY}'?\"?(?: mean)?"
    r"(?: here| for you| to you)?"
    rf"|how do you define {_WAY})\W*"
)
_ITSELF = rf"(?:(?:the|my) (?:tactile )?{HOLDER}|{THING}|me|i|us)"
_MOVES = r"(?: (?:itself|that|which|who|is|was|does|did|has|really))*(?: \w+)?"
_WHO = re.compile(
    r"(?:(?:which|what|who)(?: (?:one|of (?:them|the two)))?"
    r"(?: (?:is|was|did|does|has))?(?: it)?(?: \w+)?[,:]? )?(?:(?:is|was|did|does|has) (?:it )?)?"
    rf"{_ITSELF}{_MOVES},? or (?:(?:is|was|did|does) (?:it )?)?{_ITSELF}{_MOVES}\W*"
)
_SENSOR_NAMED = re.compile(rf"\b(?:{HOLDER}|me|i|us)\b")
RELATIVE = (
    "I feel only how the object moves relative to the sensor, not which of the two moves; I tell "
    "it as the object's motion, and of the sensor the opposite."
)
_ANOTHER = re.compile(
    r",? ?\b(?:expressed )?(?:in|relative to|with respect to|wrt) (?:the |my )?"
    r"(?P<name>(?:world|base|robot(?:'s)?(?: base)?|tool|tcp|flange|wrist|table|global|gripper)"
    r"(?:'s)? (?:frame|coordinate (?:frame|system)|coordinates|axes))(?: of reference)?,?"
)
_FROM = (
    r"(?:above|below|over(?:head)?|underneath|(?:the )?(?:top|bottom|left|right|side|front|outside)"
    r"|(?:the |my )?(?:gripper|robot|hand|arm|wrist|operator|user))"
)
_ANOTHER_VIEW = re.compile(
    rf",? ?(?:\b(?:as )?(?:seen|viewed|looked at|looking|told) from {_FROM}"
    r"|\bfrom (?:the|my) (?:gripper|robot|hand|arm|wrist|operator|user)'s"
    r" (?:perspective|point of view|viewpoint|view|side))(?= *(?:[,:?.!]|$)),?"
    r"|^(?:(?:and|so|but|ok)[, ]+)*(?:(?:what|how) about )?from (?:above|below|over(?:head)?"
    r"|outside|underneath|the front|my (?:side|perspective|point of view|viewpoint|view))\W*$"
)
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
