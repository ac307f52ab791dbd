"""Questions about one labelled clip and their answers; no question betrays its answer.

Knows the label and the templates; never sees a frame or a model.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from geotlm_lm.core.labels import Motion, MotionClass, MotionLabel, motion_class
from geotlm_lm.data.rivals import draw_option_set
from geotlm_lm.data.templates import FORMS, QuestionType, Templates, Wording, load_templates
from geotlm_lm.language.parse_answer import Slots

WORDINGS = Literal["seen", "held_out"]

NEEDS_READABLE = ("T1", "T2", "T3", "T5", "T16")
"""Types not asked where the image does not show the motion: their answer could only be guessed."""

OPTION_STYLES = ("{letter}) {text}", "({letter}) {text}", "{letter}. {text}", "{letter}: {text}")

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
    """A question, its true answer, and the closed set of answers it may be scored over."""

    type_id: str
    wording_id: str
    question: str
    answer: str
    slots: Slots
    options: tuple[str, ...]


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
        if label.is_readable or type_id not in NEEDS_READABLE
        for _ in range(per_type)
    ]


def askable_types(label: MotionLabel) -> tuple[str, ...]:
    """Return the ids of the types whose answer `label` decides."""
    return tuple(
        type_id
        for type_id in load_templates().types
        if label.is_readable or type_id not in NEEDS_READABLE
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
    text, slots, options = _CONTENT[kind.kind](templates, kind, wording, label, rng)
    sentences = {filled: sentence for sentence, filled in kind.answers.items()}
    filled = templates.fill(text, rng, held_out=wordings == "held_out")
    return QuestionAnswer(
        type_id=kind.id,
        wording_id=wording.id,
        question=as_typed(filled, templates, rng),
        answer=sentences[slots],
        slots=slots,
        options=tuple(sentences[option] for option in options),
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


_Content = tuple[str, Slots, list[Slots]]


def _direction(
    _: Templates, kind: QuestionType, wording: Wording, label: MotionLabel, rng: np.random.Generator
) -> _Content:
    return wording.text, Slots("direction", label.motion), list(kind.answers.values())


def _verify(
    templates: Templates,
    kind: QuestionType,
    wording: Wording,
    label: MotionLabel,
    rng: np.random.Generator,
) -> _Content:
    """Claim the true motion or its rival, each half of the time."""
    (rival,) = (m for m in draw_option_set(label.motion, 2, rng) if m != label.motion)
    is_true = bool(rng.random() < 0.5)
    claim = label.motion if is_true else rival
    text = wording.text
    for form in FORMS:
        phrases = templates.phrases[claim][form]
        text = text.replace(f"{{{form}}}", phrases[int(rng.integers(len(phrases)))])
    options = [Slots("verify", motion, motion == claim) for motion in Motion]
    return text, Slots("verify", label.motion, is_true), options


def _choice(
    templates: Templates,
    kind: QuestionType,
    wording: Wording,
    label: MotionLabel,
    rng: np.random.Generator,
) -> _Content:
    """Offer the true motion among one to three rivals, in random order."""
    motions = draw_option_set(label.motion, int(rng.integers(2, 5)), rng)
    motions = [motions[i] for i in rng.permutation(len(motions))]
    letters = "ABCD"[: len(motions)]
    style = OPTION_STYLES[int(rng.integers(len(OPTION_STYLES)))]
    form = templates.phrases
    lines = []
    for letter, motion in zip(letters, motions, strict=True):
        phrases = form[motion]["short"]
        phrase = phrases[int(rng.integers(len(phrases)))]
        lines.append(style.replace("{letter}", letter).replace("{text}", phrase))
    text = wording.text.replace("{options}", (", ", " ", "; ")[int(rng.integers(3))].join(lines))
    options = [
        Slots("choice", motion, letter=letter)
        for letter, motion in zip(letters, motions, strict=True)
    ]
    return text, options[motions.index(label.motion)], options


def _class(
    _: Templates, kind: QuestionType, wording: Wording, label: MotionLabel, rng: np.random.Generator
) -> _Content:
    slots = Slots("class", motion_class=motion_class(label.motion))
    return wording.text, slots, list(kind.answers.values())


def _contact(
    _: Templates, kind: QuestionType, wording: Wording, label: MotionLabel, rng: np.random.Generator
) -> _Content:
    slots = Slots("contact", verdict=label.motion != Motion.NONE)
    return wording.text, slots, list(kind.answers.values())


def _moving(
    _: Templates, kind: QuestionType, wording: Wording, label: MotionLabel, rng: np.random.Generator
) -> _Content:
    rest = motion_class(label.motion)
    is_at_rest = rest in (MotionClass.STILL, MotionClass.NONE)
    slots = Slots("moving", verdict=not is_at_rest, motion_class=rest if is_at_rest else None)
    return wording.text, slots, list(kind.answers.values())


def _refusal(
    templates: Templates,
    kind: QuestionType,
    wording: Wording,
    label: MotionLabel,
    rng: np.random.Generator,
) -> _Content:
    return wording.text, Slots("refusal"), list(kind.answers.values())


_CONTENT: dict[str, Callable[..., _Content]] = {
    "direction": _direction,
    "verify": _verify,
    "choice": _choice,
    "class": _class,
    "contact": _contact,
    "moving": _moving,
    "refusal": _refusal,
}
