"""Content of each kind of question about one label, and the slots of its true answer.

Kinds that are exact functions of the motion and of the frame (mirrored, played backwards, seen from
the other side, ...) are answered with the motion in the camera image; rules derive the rest.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from geotlm_lm.core.labels import (
    ROTATIONS,
    SLIDES,
    Motion,
    MotionClass,
    MotionLabel,
    motion_class,
)
from geotlm_lm.data.distractors import draw_option_set
from geotlm_lm.data.templates import FORMS, QuestionType, Templates, Wording
from geotlm_lm.language.parse_answer import Slots

OPTION_STYLES = ("{letter}) {text}", "({letter}) {text}", "{letter}. {text}", "{letter}: {text}")

Content = tuple[str, Slots, list[Slots]]
"""A wording's text with what depends on the clip filled in, its true slots, and all possible."""


def _told(
    _: Templates, kind: QuestionType, wording: Wording, label: MotionLabel, rng: np.random.Generator
) -> Content:
    """Answer with the motion in the camera image."""
    return wording.text, Slots(kind.kind, label.motion), list(kind.answers.values())


def _alone(
    _: Templates, kind: QuestionType, wording: Wording, label: MotionLabel, rng: np.random.Generator
) -> Content:
    """Answer what is always answered alike."""
    return wording.text, Slots(kind.kind), list(kind.answers.values())


def _claimed(
    templates: Templates,
    kind: QuestionType,
    wording: Wording,
    label: MotionLabel,
    rng: np.random.Generator,
) -> Content:
    """Claim the true motion or its rival, each half of the time; a negation denies the claim."""
    (rival,) = (m for m in draw_option_set(label.motion, 2, rng) if m != label.motion)
    claim = label.motion if rng.random() < 0.5 else rival
    return claim_question(templates, kind, wording, label, claim, rng)


def claim_question(
    templates: Templates,
    kind: QuestionType,
    wording: Wording,
    label: MotionLabel,
    claim: Motion,
    rng: np.random.Generator,
) -> Content:
    """Return a question that claims `claim`, or denies it where it is a negation."""
    text = wording.text
    for form in FORMS:
        phrases = templates.phrases[claim][form]
        if kind.kind != "verify":  # "is it not not touching?" is no English
            phrases = [phrase for phrase in phrases if "not " not in phrase]
        text = text.replace(f"{{{form}}}", phrases[int(rng.integers(len(phrases)))])
    is_denied = kind.kind == "negation"
    options = [Slots(kind.kind, motion, (motion == claim) != is_denied) for motion in Motion]
    return text, options[list(Motion).index(label.motion)], options


def _choice(
    templates: Templates,
    kind: QuestionType,
    wording: Wording,
    label: MotionLabel,
    rng: np.random.Generator,
) -> Content:
    """Offer the true motion among one to three rivals, in random order."""
    motions = draw_option_set(label.motion, int(rng.integers(2, 5)), rng)
    motions = [motions[i] for i in rng.permutation(len(motions))]
    return choice_question(wording, label, motions, draw_layout(templates, motions, rng))


@dataclass(frozen=True)
class OptionLayout:
    """How the options of a choice are written, whatever their order."""

    style: str
    phrases: Mapping[Motion, str]
    separator: str


def draw_layout(
    templates: Templates, motions: Sequence[Motion], rng: np.random.Generator
) -> OptionLayout:
    """Return how to write a choice among `motions`."""
    style = OPTION_STYLES[int(rng.integers(len(OPTION_STYLES)))]
    phrases = {}
    for motion in motions:
        short = templates.phrases[motion]["short"]
        phrases[motion] = short[int(rng.integers(len(short)))]
    return OptionLayout(style, phrases, (", ", " ", "; ")[int(rng.integers(3))])


def choice_question(
    wording: Wording, label: MotionLabel, motions: Sequence[Motion], layout: OptionLayout
) -> Content:
    """Return a question that offers `motions` in this order."""
    letters = "ABCD"[: len(motions)]
    lines = [
        layout.style.replace("{letter}", letter).replace("{text}", layout.phrases[motion])
        for letter, motion in zip(letters, motions, strict=True)
    ]
    options = [
        Slots("choice", motion, letter=letter)
        for letter, motion in zip(letters, motions, strict=True)
    ]
    text = wording.text.replace("{options}", layout.separator.join(lines))
    return text, options[list(motions).index(label.motion)], options


def _class(
    _: Templates, kind: QuestionType, wording: Wording, label: MotionLabel, rng: np.random.Generator
) -> Content:
    slots = Slots("class", motion_class=motion_class(label.motion))
    return wording.text, slots, list(kind.answers.values())


def _contact(
    _: Templates, kind: QuestionType, wording: Wording, label: MotionLabel, rng: np.random.Generator
) -> Content:
    slots = Slots("contact", verdict=label.motion != Motion.NONE)
    return wording.text, slots, list(kind.answers.values())


def _moving(
    _: Templates, kind: QuestionType, wording: Wording, label: MotionLabel, rng: np.random.Generator
) -> Content:
    rest = motion_class(label.motion)
    is_at_rest = rest in (MotionClass.STILL, MotionClass.NONE)
    slots = Slots("moving", verdict=not is_at_rest, motion_class=rest if is_at_rest else None)
    return wording.text, slots, list(kind.answers.values())


def _measured(
    _: Templates, kind: QuestionType, wording: Wording, label: MotionLabel, rng: np.random.Generator
) -> Content:
    """Answer what sort of amount there is, or why there is none."""
    options = list(kind.answers.values())
    if label.motion in ROTATIONS:
        return wording.text, Slots(kind.kind, unit="deg"), options
    if label.motion in SLIDES:
        return wording.text, Slots(kind.kind, unit="px"), options
    return wording.text, Slots(kind.kind, label.motion), options


CONTENTS: dict[str, Callable[..., Content]] = {
    "direction": _told,
    "verify": _claimed,
    "choice": _choice,
    "negation": _claimed,
    "class": _class,
    "contact": _contact,
    "magnitude": _measured,
    "rate": _measured,
    "comparison": _alone,
    "evidence": _told,
    "viewpoint": _told,
    "actor": _told,
    "thread": _told,
    "mirrored": _told,
    "reversed": _told,
    "moving": _moving,
    "refusal": _alone,
    "premise": _claimed,
    "confidence": _alone,
    "undo": _told,
    "order": _alone,
}
