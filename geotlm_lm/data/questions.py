"""Questions about one labelled clip and their answers; no question betrays its answer.

Knows the label and the templates; never sees a frame or a model.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.data.question_contents import CONTENTS, Content
from geotlm_lm.data.templates import QuestionType, Templates, Wording, load_templates
from geotlm_lm.language.parse_answer import Slots

WORDINGS = Literal["seen", "held_out"]

ANYTIME = ("T6", "T9", "T17", "T19", "T22")
"""Types asked even where the image does not show the motion: their answer does not depend on it.
Every other answer could only be guessed there."""

# People type as they like: shares of questions written that way.
LOWER_CASE_SHARE = 0.3
UPPER_CASE_SHARE = 0.03
NO_FINAL_MARK_SHARE = 0.25
OPENER_SHARE = 0.08
CLOSER_SHARE = 0.08

TYPO_MIN_LETTERS = 5
"""Shorter words are left alone: one wrong letter makes another word of "left" or "cw"."""


@dataclass(frozen=True)
class QuestionAnswer:
    """A question, its true answer, and the closed set of answers it may be scored over.

    `amount` is the true one, in the unit of the slots; None where none is asked or known.
    """

    type_id: str
    wording_id: str
    question: str
    answer: str
    slots: Slots
    options: tuple[str, ...]
    amount: float | None = None


def questions_for(
    label: MotionLabel,
    rng: np.random.Generator,
    *,
    types: Sequence[str] | None = None,
    wordings: WORDINGS = "seen",
    per_type: int = 1,
) -> list[QuestionAnswer]:
    """Return `per_type` questions of every type that `label` can answer.

    Under motions drawn evenly, a T2 claim is true half of the time whatever it claims, and every
    option of a T3 question is equally likely to be the true one.

    Args:
        label: The truth about the clip.
        rng: Draws wordings, words and options; the same state gives the same questions.
        types: Which types; None for all. Types an unreadable label cannot answer are left out.
        wordings: Which share of the wordings.
        per_type: Questions of each type.
    """
    templates = load_templates()
    wanted = askable_types(label) if types is None else types
    return [
        _ask(templates, templates.types[type_id], label, rng, wordings)
        for type_id in wanted
        if label.is_readable or type_id in ANYTIME
        for _ in range(per_type)
    ]


def askable_types(label: MotionLabel) -> tuple[str, ...]:
    """Return the ids of the types whose answer `label` decides."""
    return tuple(
        type_id for type_id in load_templates().types if label.is_readable or type_id in ANYTIME
    )


def training_corpus(rng: np.random.Generator, rounds: int) -> list[str]:
    """Return seen questions, each followed by its answer, `rounds` per type and motion."""
    texts = []
    for motion in Motion:
        for asked in questions_for(MotionLabel(motion), rng, per_type=rounds):
            texts += [asked.question, asked.answer]
    return texts


def _ask(
    templates: Templates,
    kind: QuestionType,
    label: MotionLabel,
    rng: np.random.Generator,
    wordings: WORDINGS,
) -> QuestionAnswer:
    among = kind.among(wordings)
    wording = among[int(rng.integers(len(among)))]
    content = CONTENTS[kind.kind](templates, kind, wording, label, rng)
    return written(templates, kind, wording, content, label, rng)


def written(
    templates: Templates,
    kind: QuestionType,
    wording: Wording,
    content: Content,
    label: MotionLabel,
    rng: np.random.Generator,
) -> QuestionAnswer:
    """Return the question as somebody types it: its words filled in, with its true answer."""
    text, slots, options = content
    sentences = {filled: sentence for sentence, filled in kind.answers.items()}
    filled = templates.fill(text, rng, held_out=wording.is_held_out)
    return QuestionAnswer(
        type_id=kind.id,
        wording_id=wording.id,
        question=as_typed(filled, templates, rng),
        answer=sentences[slots],
        slots=slots,
        options=tuple(sentences[option] for option in options),
        amount=label.amount if slots.unit is not None else None,
    )


def as_typed(question: str, templates: Templates, rng: np.random.Generator) -> str:
    """Return `question` with the capitals, marks and courtesies of somebody's typing."""
    opens, closes, lowers, uppers, drops = rng.random(5) < (
        OPENER_SHARE,
        CLOSER_SHARE,
        LOWER_CASE_SHARE,
        UPPER_CASE_SHARE,
        NO_FINAL_MARK_SHARE,
    )
    question = question[:1].upper() + question[1:]
    if drops:
        question = question.rstrip("?.")
    if opens:
        question = templates.fill("{opener}", rng) + question
    if closes:
        question = question + templates.fill("{closer}", rng)
    if lowers:
        question = question.lower()
    elif uppers:
        question = question.upper()
    return question


def with_typo(question: str, rng: np.random.Generator) -> str:
    """Return `question` with one letter of one longer word dropped, doubled or swapped.

    The first and the last letter stay. A question without a longer word is returned as it is.
    """
    words = [match.span() for match in re.finditer(r"[A-Za-z]+", question)]
    words = [(start, end) for start, end in words if end - start >= TYPO_MIN_LETTERS]
    if not words:
        return question
    start, end = words[int(rng.integers(len(words)))]
    at = int(rng.integers(start + 1, end - 2))
    letter, following = question[at], question[at + 1]
    slips = [following, letter + letter + following]  # dropped, doubled
    if letter != following:
        slips.append(following + letter)
    return question[:at] + slips[int(rng.integers(len(slips)))] + question[at + 2 :]
