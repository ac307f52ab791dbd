"""Groups of equivalent questions: a claim and its negation, rewordings, reordered choices.

Knows the label and the templates, as `questions` does; an answerer that reads the clip gets every
question of a group right, one that guesses from the words does not.
"""

from __future__ import annotations

import numpy as np

from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.data.distractors import draw_option_set
from geotlm_lm.data.question_contents import CONTENTS, choice_question, claim_question, draw_layout
from geotlm_lm.data.questions import WORDINGS, QuestionAnswer, written
from geotlm_lm.data.templates import QuestionType, Wording, load_templates

VERIFY, CHOICE, NEGATION = "T2", "T3", "T4"

CLAIMING = frozenset({"verify", "negation", "premise"})
"""Kinds whose questions claim a motion."""


def said_and_denied(
    label: MotionLabel, rng: np.random.Generator, wordings: WORDINGS = "seen"
) -> tuple[QuestionAnswer, QuestionAnswer]:
    """Return one claim asked about ("Is it ...?") and denied ("Is it not ...?").

    The claim is true half of the time.
    """
    claim = draw_claim(label.motion, rng)
    said, denied = (_claim(type_id, label, claim, rng, wordings) for type_id in (VERIFY, NEGATION))
    return said, denied


def reworded(
    label: MotionLabel,
    type_id: str,
    count: int,
    rng: np.random.Generator,
    wordings: WORDINGS = "seen",
) -> list[QuestionAnswer]:
    """Return one question of a type in `count` different wordings; a claim stays the same.

    Raises:
        ValueError: If the type has fewer wordings of that share.
    """
    templates = load_templates()
    kind = templates.types[type_id]
    among = kind.among(wordings)
    if count > len(among):
        raise ValueError(f"{type_id} has {len(among)} {wordings} wordings, not {count}")
    claim = draw_claim(label.motion, rng) if kind.kind in CLAIMING else None
    asked = []
    for index in rng.permutation(len(among))[:count]:
        wording = among[int(index)]
        if claim is None:
            content = CONTENTS[kind.kind](templates, kind, wording, label, rng)
        else:
            content = claim_question(templates, kind, wording, label, claim, rng)
        asked.append(written(templates, kind, wording, content, label, rng))
    return asked


def in_every_order(
    label: MotionLabel, rng: np.random.Generator, wordings: WORDINGS = "seen"
) -> list[QuestionAnswer]:
    """Return one multiple choice with its options turned round, so that each is once in front."""
    templates = load_templates()
    kind = templates.types[CHOICE]
    motions = draw_option_set(label.motion, int(rng.integers(2, 5)), rng)
    motions = [motions[i] for i in rng.permutation(len(motions))]
    layout = draw_layout(templates, motions, rng)
    wording = _draw_wording(kind, rng, wordings)
    turned = [motions[at:] + motions[:at] for at in range(len(motions))]
    return [
        written(
            templates, kind, wording, choice_question(wording, label, order, layout), label, rng
        )
        for order in turned
    ]


def draw_claim(motion: Motion, rng: np.random.Generator) -> Motion:
    """Return the true motion or its rival, each half of the time."""
    (rival,) = (m for m in draw_option_set(motion, 2, rng) if m != motion)
    return motion if rng.random() < 0.5 else rival


def _claim(
    type_id: str, label: MotionLabel, claim: Motion, rng: np.random.Generator, wordings: WORDINGS
) -> QuestionAnswer:
    templates = load_templates()
    kind = templates.types[type_id]
    wording = _draw_wording(kind, rng, wordings)
    content = claim_question(templates, kind, wording, label, claim, rng)
    return written(templates, kind, wording, content, label, rng)


def _draw_wording(kind: QuestionType, rng: np.random.Generator, wordings: WORDINGS) -> Wording:
    among = kind.among(wordings)
    return among[int(rng.integers(len(among)))]
