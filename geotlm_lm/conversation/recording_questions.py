"""Answer questions about the recording itself: frame size, frame rate, frames used."""

from __future__ import annotations

import re
from typing import Literal

from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import without_openers
from geotlm_lm.core.geometry import FRAME_COUNT

_PHRASES = Phrases("recording_questions")
Topic = Literal["size", "rate", "frames", "duration", "interval"]


_TOPICS: tuple[tuple[Topic, str], ...] = (
    ("size", _PHRASES.text("FRAME_SIZE")),
    ("size", _PHRASES.text("HOW_LARGE")),
    ("size", _PHRASES.text("PIXEL_COUNT")),
    ("rate", _PHRASES.text("FRAME_RATE")),
    ("rate", _PHRASES.text("FRAMES_PER_SECOND")),
    ("frames", _PHRASES.text("FRAME_COUNT")),
    ("frames", _PHRASES.text("FRAMES_USED")),
    ("duration", _PHRASES.text("DURATION")),
    ("interval", _PHRASES.text("INTERVAL")),
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
        numbers: Of the frames that were used: of a recording that was tracked, of all of them.
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
    if len(numbers) > FRAME_COUNT:
        return f"I track {len(numbers)} frames, from {min(numbers)} to {max(numbers)}."
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
        f"pass; `geotlm-lm track` tells when each motion of a recording begins and ends."
    )
