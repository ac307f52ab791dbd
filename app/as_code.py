"""The question that was answered last, as a program would ask it."""

from __future__ import annotations

import json
import shlex
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

from .facts import sentences_of
from .parameters import given_by

if TYPE_CHECKING:
    from geotlm_lm import FrameSpec


@dataclass(frozen=True)
class Calls:
    """The same call three times: of the shell, of Python, of the page's interface."""

    command: str
    python: str
    rest: str


def calls_of(
    path: str,
    questions: list[str],
    frame: FrameSpec,
    span: tuple[int, int] | None = None,
    address: str = "http://127.0.0.1:7860",
    topic: str | None = None,
) -> Calls:
    """Return the calls that ask the last of these questions.

    Args:
        path: Of the recording, as its owner knows it.
        questions: Of the conversation so far; only Python's call keeps it, where it is longer.
        frame: That was checked in the page.
        span: First and last frame, where only a part is asked about.
        address: Of the page.
        topic: Of a bag's images, where it was named.
    """
    question = " ".join([*sentences_of(frame), questions[-1]])
    command = ["geotlm-lm", "answer", "--clip", path, "--q", question]
    if frame.mm_per_px is not None:
        command += ["--mm-per-px", f"{frame.mm_per_px:g}"]
    asked: dict[str, Any] = {"question": questions[-1]} | given_by(frame)
    if span is not None:
        command += ["--frames", f"{span[0]}:{span[1]}"]
        asked["frames"] = list(span)
    if topic is not None:
        command += ["--topic", topic]
        asked["topic"] = topic
    return Calls(
        shlex.join(command),
        _python(path, questions, frame, span, topic),
        _rest(path, asked, address),
    )


def _python(
    path: str, questions: list[str], frame: FrameSpec, span: tuple | None, topic: str | None
) -> str:
    of_span = "" if span is None else f", span=({span[0]}, {span[1]})"
    of_topic = "" if topic is None else f", topic={topic!r}"
    told = {
        one.name: getattr(frame, one.name)
        for one in fields(frame)
        if getattr(frame, one.name) != one.default
    }
    stated = ", ".join(f"{name}={value!r}" for name, value in told.items())
    in_frame = f", frame=FrameSpec({stated})" if told else ""
    lines = [
        f"from geotlm_lm import Answerer, {'FrameSpec, ' * bool(told)}read_clip",
        "",
        "answerer = Answerer.load()",
        f"seen = answerer.encode(read_clip({path!r}{of_topic}){of_span})",
    ]
    if len(questions) == 1:
        return "\n".join([*lines, f"print(answerer.ask(seen, {questions[0]!r}{in_frame}).text)"])
    return "\n".join(
        [
            *lines,
            f"talk = answerer.session(seen{in_frame})",
            *[f"talk.ask({one!r})" for one in questions[:-1]],
            f"print(talk.ask({questions[-1]!r}).text)",
        ]
    )


def _rest(path: str, asked: dict[str, Any], address: str) -> str:
    quoted = json.dumps(asked)[1:].replace("'", "'\\''")
    return "\n".join(
        [
            f"url={address}/gradio_api",
            f"clip=$(curl -s -F files=@{shlex.quote(path)} $url/upload | cut -d'\"' -f2)",
            f"asked='{{\"recording\": \"'$clip'\", {quoted}'",
            'call=$(curl -s $url/call/v2/ask --json "$asked")',
            "curl -s $url/call/ask/$(echo $call | cut -d'\"' -f4)",
        ]
    )
