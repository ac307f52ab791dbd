"""Questions about the recording itself: the size of its frames, their rate, which were used."""

from __future__ import annotations

import re
from typing import Literal

Topic = Literal["size", "rate", "frames"]

_FRAMES = r"(?:frames?|images?|pictures?|photos?|recording|video|clip|camera)"
_OPENS = (
    r"(?:(?:and|so|ok|now|please|hey)[, ]+)*"
    r"(?:(?:what|which)(?:'s| is| are| was| were)? (?:the |its |their )?|at what |with what "
    r"|(?:tell|give) me (?:the |its )?|the |its )?"
)
_OF_IT = rf"(?: (?:of|in|for) (?:the |this |that |my |your |a |one |each )?(?:{_FRAMES}|it|this))*"
_DOES_IT_HAVE = (
    rf" (?:(?:is|was|were|are|do|does|did|has|have) )?(?:there|(?:the|this|my|each) {_FRAMES}|it)"
    r"(?: (?:have|hold|contain|taken|recorded|at|made|shot|in))*"
)
_USED = r"(?: (?:do|did) you (?:see|use|look at|have)| (?:are|were) (?:used|looked at))"
_IT = rf"(?:it|this|that|(?:the|this|my|your|a|one|each) {_FRAMES})"

_TOPICS: tuple[tuple[Topic, str], ...] = (
    (
        "size",
        rf"{_OPENS}(?:(?:image|frame|picture|video|pixel)s? |camera(?:'s)? )?"
        r"(?:resolution|dimensions|(?<=frame )size|(?<=image )size|(?<=picture )size"
        rf"|(?<=video )size|size(?= of (?:the |this |my )?{_FRAMES}))(?:{_OF_IT}|{_DOES_IT_HAVE})",
    ),
    (
        "size",
        r"how (?:large|big|wide|high|tall) (?:is|are|was|were) (?:the |this |my )?"
        r"(?:frames?|images?|pictures?|video)(?: in (?:pixels|px))?",
    ),
    (
        "size",
        rf"how many (?:pixels|px) (?:(?:wide|high|tall|large)(?: and (?:wide|high|tall))? "
        rf"(?:is|are|was|were) {_IT}s?|(?:does|do|has|have) {_IT}s?(?: have)?|(?:are|is) in {_IT}"
        rf"|per {_FRAMES})",
    ),
    (
        "rate",
        rf"{_OPENS}(?:(?:recording|video|camera)(?:'s)? )?(?:frame[ -]?rate|fps|frames per second)"
        rf"(?:{_OF_IT}|{_DOES_IT_HAVE})",
    ),
    (
        "rate",
        rf"how many (?:fps|(?:{_FRAMES} )?(?:per|a|each|every) second)"
        rf"(?:{_OF_IT}|{_DOES_IT_HAVE})?",
    ),
    (
        "frames",
        rf"how many (?:frames|images|pictures)(?:{_OF_IT}|{_DOES_IT_HAVE}{_OF_IT}|{_USED}"
        rf"| (?:are|were) (?:there )?(?:in|of) {_IT})?",
    ),
    ("frames", rf"(?:which|what) frames{_USED}"),
)

_PATTERNS = tuple((topic, re.compile(words)) for topic, words in _TOPICS)


def asked_of_recording(question: str) -> Topic | None:
    """Return what `question` asks of the recording itself; None where it asks something else.

    The whole text has to: "how many frames does it turn?" asks of a motion.
    """
    text = " ".join(question.lower().replace("\u2019", "'").split()).strip(" ?!.")
    return next((topic for topic, words in _PATTERNS if words.fullmatch(text)), None)


def told_of_recording(
    topic: Topic, size: tuple[int, int], fps: float | None, numbers: tuple[int, ...]
) -> str:
    """Return the sentence about the recording.

    Args:
        topic: What is asked.
        size: Rows and columns of its frames.
        fps: Frames per second; None where it says none.
        numbers: Of the frames that were used.
    """
    if topic == "size":
        rows, columns = size
        return f"The frames are {columns} px wide and {rows} px high."
    if topic == "rate":
        if fps is None:
            return "The recording gives no frame rate; give it by fps."
        return f"The recording has {fps:g} frames per second."
    used = ", ".join(str(number) for number in sorted(set(numbers)))
    return (
        f"I look at few frames of a recording, here at {used}, counted from 0; `geotlm-lm info` "
        f"tells how many it has."
    )
