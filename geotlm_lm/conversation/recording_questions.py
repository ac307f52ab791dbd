"""Answer questions about the recording itself: frame size, frame rate, frames used."""

from __future__ import annotations

import re
from typing import Literal

from geotlm_lm.conversation.text_normalisation import without_openers

Topic = Literal["size", "rate", "frames", "duration", "interval"]

_FRAMES = r"(?:frames?|images?|pictures?|photos?|recording|video|clip|camera)"
_OPENS = (
    r"(?:(?:what|which)(?:'s| is| are| was| were)? (?:the |its |their )?|at what |with what "
    r"|(?:tell|give) me (?:the |its )?|the |its )?"
)
_OF_IT = rf"(?: (?:of|in|for) (?:the |this |that |my |your |a |one |each )?(?:{_FRAMES}|it|this))*"
_DOES_IT_HAVE = (
    rf" (?:(?:is|was|were|are|do|does|did|has|have) )?(?:there|(?:the|this|my|each) {_FRAMES}|it)"
    r"(?: (?:have|hold|contain|taken|recorded|at|made|shot|in))*"
)
_MOVEMENT = r"(?:slip|slide|turn|rotation|motion|movement|twist|spin)"
_HOLDER = r"(?:sensor|gel|gripper|robot|finger|clip|recording|video|camera)\b"
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
        rf"{_OPENS}number of (?:pixels|px) (?:in|of) {_IT}"
        rf"|how many (?:pixels|px) (?:(?:wide|high|tall|large)(?: and (?:wide|high|tall))? "
        rf"(?:is|are|was|were) {_IT}s?|(?:does|do|has|have) {_IT}s?(?: have)?|(?:are|is) in {_IT}"
        r"|per (?:image|picture|photo))",
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
    (
        "frames",
        rf"(?:which|what) frames{_USED}"
        rf"|{_OPENS}(?:number of frames|frame count)(?:{_OF_IT}|{_USED})?",
    ),
    (
        "duration",
        rf"(?:for )?how long (?:is|was|are|were) {_IT}(?: in (?:s|seconds))?"
        rf"|(?:for )?how long (?:does|did|do) (?:it|this|that|(?:the|my) (?!{_HOLDER})\w+) "
        r"(?:slide|slip|turn|rotate|move|last|take(?: to (?:slide|slip|turn|rotate|move))?)"
        rf"|how long (?:does|did) the {_MOVEMENT} (?:last|take)|how long (?:is|was) the {_MOVEMENT}"
        rf"|{_OPENS}(?:duration|length in seconds)"
        rf"(?: of (?:the |this |my )?(?:{_MOVEMENT}|{_FRAMES}))?"
        r"|how much time (?:passes|passed|is|lies|elapses|elapsed) between (?:the )?first "
        rf"(?:{_FRAMES} )?and (?:the )?last(?: used)? {_FRAMES}(?: used| you used)?"
        r"|(?:what(?:'s| is) )?the time (?:from|between) the first (?:frame )?(?:to|and) the last "
        r"(?:used )?frame",
    ),
    (
        "interval",
        rf"{_OPENS}(?:time|interval|time step|time difference) (?:between|from) "
        r"(?:two |the |consecutive |successive |one |each )*frames?(?: to the next)?"
        r"|how (?:long|much time) (?:is|lies|passes) (?:there )?between (?:two |the )?frames",
    ),
)

_PATTERNS = tuple((topic, re.compile(words)) for topic, words in _TOPICS)


def recording_topic(question: str) -> Topic | None:
    """Return the property of the recording that is asked for; None for other questions.

    The whole text has to: "how many frames does it turn?" asks of a motion.
    """
    text = without_openers(question).strip(" ?!.")
    return next((topic for topic, words in _PATTERNS if words.fullmatch(text)), None)


def recording_sentence(
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
    if topic in ("duration", "interval"):
        return _told_time(topic, fps, numbers)
    used = ", ".join(str(number) for number in sorted(set(numbers)))
    return (
        f"I look at few frames of a recording, here at {used}, counted from 0; `geotlm-lm info` "
        f"tells how many it has."
    )


def _told_time(topic: Topic, fps: float | None, numbers: tuple[int, ...]) -> str:
    if fps is None:
        return "The recording gives no frame rate, and so no time; give it by fps."
    if topic == "interval":
        return f"At {fps:g} frames per second, {1 / fps:.3g} s from one frame to the next."
    first, last = min(numbers), max(numbers)
    seconds = (last - first) / fps
    return (
        f"From frame {first} to frame {last}, the first and the last used, {seconds:.3g} s "
        f"pass; `geotlm-lm watch` tells when each motion of a recording begins and ends."
    )
