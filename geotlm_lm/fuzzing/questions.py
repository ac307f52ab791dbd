"""Nonsense questions: the rules on words alone, the shipped model, and whole conversations."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from geotlm_lm.fuzzing.target import Target

QUESTIONS = (
    "Which way is the cap turning?",
    "Is it sliding to the left?",
    "A) clockwise B) counterclockwise C) still. Which one?",
    "Isn't it turning clockwise?",
    "Why do you say that it slides up?",
    "The image is mirrored. Which way does it turn?",
    "If I turned the picture upside down, where would it go?",
    "The image is rotated by 90 degrees clockwise. Which way does it slide?",
    "The camera is mounted sideways, which way does it go?",
    "I look from the object's side. Does that tighten a left-hand thread touched at the head?",
    "Are you sure?",
    "How far does it slide, in millimetres?",
    "Do they go the same way? Which goes further?",
    "Which came first?",
    "What colour is it?",
    "Wie dreht sich der Deckel?",
)
"""One of each sort."""

WORDS = (
    *("clockwise", "left", "not", "no", "never", "isn't it", "mirrored", "thread", "the sensor"),
    *(
        "A)",
        "B:",
        "(C)",
        "?",
        "!",
        ".",
        ";",
        "...",
        "\u2019",
        "<tactile>",
        "<<tactile>>",
        "<<<user>>>",
        "<|im_start|>",
        "{{",
        "%s",
    ),
    *("\n", "\0", "\u202e", "\ufeff", "\U0001f9f2", "\u0130", "e\u0301", "9" * 40, "-", "a " * 60),
    *("which way ", "because ", "why ", "or ", "and then ", "I look from ", "sure", "again"),
)
"""Of the questions' language, and what its parts may trip over."""


def _text(data: bytes) -> str:
    # Bytes that are no UTF-8 come from the command line as surrogates.
    return data.decode("utf-8", "surrogateescape")


def _of(run: Any) -> Target:
    encode = str.encode
    return Target(tuple(map(encode, QUESTIONS)), run, tuple(map(encode, WORDS)))


def rules(home: Path) -> Target:
    """Everything that is decided from the words, without a model."""
    from geotlm_lm.answering import check_question
    from geotlm_lm.checkpoint import embedded_bundle_dir
    from geotlm_lm.conversation.claims import claimed_motion, motions_named, offered_options
    from geotlm_lm.conversation.english import is_english
    from geotlm_lm.conversation.frame_facts import read_facts
    from geotlm_lm.conversation.kinds import asked_kind
    from geotlm_lm.core.frame_spec import FrameSpec
    from geotlm_lm.language.parse_answer import AnswerGrammar

    grammar = AnswerGrammar.load(embedded_bundle_dir() / "answers.json")

    def run(data: bytes) -> None:
        text = check_question(_text(data))
        is_english(text)
        stated = read_facts(text, FrameSpec())
        read_facts(stated.rest, stated.frame)
        asked_kind(stated.rest)
        motions_named(text), claimed_motion(text), offered_options(text)
        grammar.parse(text)

    return _of(run)


def question(home: Path) -> Target:
    """The shipped model asked about a clip."""
    answerer, encoded, _ = _shipped(home)

    def run(data: bytes) -> None:
        _check(answerer.ask(encoded, _text(data)).to_dict())

    return _of(run)


def conversation(home: Path) -> Target:
    """A line a turn, about two clips, in one conversation; comparisons as well."""
    answerer, encoded, other = _shipped(home)

    def run(data: bytes) -> None:
        session = answerer.session(encoded)
        session.add_clip(other)
        for line in _text(data).split("\n")[:4]:
            _check(session.ask(line).to_dict())
        _check(answerer.compare(encoded, other, _text(data)[:400]).to_dict())
        json.dumps(session.to_dict())

    return _of(run)


def _shipped(home: Path) -> tuple[Any, Any, Any]:
    import torch

    from geotlm_lm.answering import Answerer
    from geotlm_lm.simulation.touch import Touch, simulate_touch

    torch.set_num_threads(1)
    answerer = Answerer.load()
    touches = Touch("hex_nut", twist_deg=20.0), Touch("key", slide_x_mm=1.0)
    made = [simulate_touch(touch).clip for touch in touches]
    return answerer, *map(answerer.encode, made)


def _check(told: dict[str, Any]) -> None:
    """Raise where an answer is none.

    Raises:
        ValueError: If it is empty, no JSON, or its confidence no probability.
    """
    if not told["text"].strip() or "\n" in told["text"]:
        raise ValueError(f"an answer of the words {told['text']!r}")
    if not 0 <= told["confidence"] <= 1:
        raise ValueError(f"a confidence of {told['confidence']}")
    json.dumps(told, allow_nan=False)
