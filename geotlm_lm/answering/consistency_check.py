"""Detect replies of the model that contradict the words of the question, or each other.

A model trained on a closed set of wordings takes unknown ones for other questions; rules on the
words notice that, and the question is then answered from the open question's answer.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from geotlm_lm.answering.answer import offered_letters
from geotlm_lm.conversation.compound_claims import compound_claim
from geotlm_lm.conversation.existence_questions import is_unasked_existence, speaks_of_motion
from geotlm_lm.conversation.half_directions import asked_half, claimed_half
from geotlm_lm.conversation.indirect_questions import embedded_claim
from geotlm_lm.conversation.kind_choices import offered_kinds
from geotlm_lm.conversation.kinds import asked_kind, asks_direction, asks_whether_moving
from geotlm_lm.conversation.motion_answers import VERDICTS
from geotlm_lm.conversation.motion_claims import (
    claimed_motions,
    claims_end,
    claims_motion,
    offered_options,
)
from geotlm_lm.conversation.motion_names import claimed_motion, motions_named, nearly_named
from geotlm_lm.conversation.non_tactile_questions import asks_beyond_touch
from geotlm_lm.conversation.option_meanings import offers_neither, option_sets
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion, motion_class
from geotlm_lm.language.parse_answer import Slots

_NO_WAY = ("class", "contact", "moving", "refusal")
"""Kinds of answers that say nothing of a way, which an open question asks for."""

_OPEN = re.compile(r"\W*(?:(?:in )?which|what) (?:way|direction)\b", re.IGNORECASE)
"""What begins so claims nothing: "which way does the coin approach?"."""

CHECKED_KINDS = (*VERDICTS, "choice", "class")
"""Kinds whose answers name a motion, or its kind, that the open answer may speak against."""


def kind_from_open_answer(slots: Slots | None, question: str) -> str | None:
    """Return the kind in which a question is answered from the open answer, else None.

    None where the model's own answer counts.

    Args:
        slots: Of the model's own answer; None where that does not parse.
        question: What was asked.
    """
    if ignores_motion_claim(slots, question):
        return "direction" if _OPEN.match(question) else "verify"
    if ignores_offered_choice(slots, question):
        return "choice"
    if slots is not None and slots.kind in _NO_WAY and asks_direction(question):
        return "direction"
    if slots is not None and (
        slots.kind == "confidence" or denies_unclaimed_motion(slots, question)
    ):
        return slots.kind
    return None


def kind_by_rule(question: str) -> str | None:
    """Return the kind that the words alone decide, whatever the model makes of them.

    None where the model is asked: no question of the templates is taken from it.
    """
    kind = asked_kind(question)
    if kind in (None, "negation") and compound_claim(question) is not None:
        return "verify"
    if kind in (None, "evidence") and claimed_half(question) is not None:
        return "verify"
    if kind is None and asked_half(question) is not None:
        return "direction"
    if kind is None and offered_kinds(question) is not None:
        return "class"
    is_choice = option_sets(question) is not None or offers_neither(question)
    return "choice" if kind in (None, "negation") and is_choice else None


def contradicts_open_answer(
    slots: Slots, opened: Slots | None, question: str, frame: FrameSpec
) -> bool:
    """Tell whether an answer names another motion than the open answer.

    Of 68 real turns 14 were told to slide when asked whether they do, and 66 told rightly when
    asked openly: one clip must not move in two ways, and the open answer is the surer one.

    Args:
        slots: Of the answer, of a `CHECKED_KINDS` kind.
        opened: Of the answer to the open question; None where that does not parse.
        question: What was asked. Who offers a choice that the open answer is not among is told the
            likeliest of what is offered.
        frame: The frame it was asked in.
    """
    if opened is None or opened.direction is None:
        return False
    if slots.kind == "class":
        return slots.motion_class != motion_class(opened.direction)
    if slots.kind == "choice" and frame.tell(opened.direction) not in (
        offered_options(question).values()
    ):
        return False
    return slots.direction != opened.direction


def claim_probabilities(
    slots: Slots, shares: Mapping[str, float], question: str, frame: FrameSpec
) -> dict[str, float]:
    """Return the probabilities of yes and no to a claim, from those of the open answer.

    The model's own shares may contradict these: a clip that slides to the right at 0.97 slid at
    0.64. Nothing where the question claims no motion or the shares speak against the verdict.

    Args:
        slots: Of the model's verdict.
        shares: Probability of each motion, by its word.
        question: What was asked.
        frame: The frame it was asked in.
    """
    claims = claimed_motions(question)
    if slots.kind != "verify" or claims is None or not set(shares) <= set(Motion):
        return {}
    share = sum(odds for word, odds in shares.items() if frame.tell(Motion(word)) in claims)
    share = min(share, 1.0)
    return {"yes": share, "no": 1.0 - share} if (share >= 0.5) == slots.verdict else {}


def denies_unclaimed_motion(slots: Slots, question: str) -> bool:
    """Tell whether a "no" answers a question in which no rule finds a motion.

    The model then took words it does not know for a claim: the motion is read once more from a
    question it knows, and a verdict given only where the question claims a kind of motion.
    """
    is_no = slots.kind in ("verify", "premise") and slots.verdict is False
    return is_no and not motions_named(question) and not nearly_named(question)


def ignores_motion_claim(slots: Slots | None, question: str) -> bool:
    """Tell whether the model declines a claim of motion, or answers another question.

    It may tell of contact, or that it moves and not how: the claim's words are then new to it. What
    presses on the gel or rests on it touches it, so that such a question may well be about contact.
    No question of the templates about contact or about motion as such passes for a claim.
    """
    if asked_kind(question) is not None:
        return False
    question = embedded_claim(question)
    is_declined = slots is not None and slots.kind == "refusal"
    if not (claims_motion(question) or (is_declined and _is_bare_motion_name(question))):
        return False
    if slots is None:
        return True
    is_over = claims_end(question)
    of_contact = not is_over and claimed_motion(question) in (Motion.PRESS, Motion.STILL)
    of_motion = slots.kind in ("refusal", "moving", "class", "direction")
    return of_motion or (slots.kind == "contact" and not of_contact)


def _is_bare_motion_name(question: str) -> bool:
    """Tell whether a question is no more than the name of a motion, such as "up?"."""
    is_terse = question.rstrip().endswith("?") and len(question.split()) == 1
    return is_terse and claimed_motion(question) is not None


def answers_unanswerable(slots: Slots | None, question: str) -> bool:
    """Tell whether the model answers a question that touch cannot answer.

    They do too where it tells of contact, or of motion as such, and they ask for neither.
    """
    if (slots is None or slots.kind != "refusal") and asks_beyond_touch(question):
        return True
    if slots is None or not (
        is_unasked_existence(slots.kind, question) or _affirms_unclaimed_motion(slots, question)
    ):
        return False
    return asked_kind(question) is None and not claims_motion(question)


def _affirms_unclaimed_motion(slots: Slots, question: str) -> bool:
    """Tell whether a "yes" tells of a motion where the words speak of none at all."""
    is_yes = slots.kind == "verify" and slots.verdict is True
    if not is_yes or claimed_motions(question) is not None or nearly_named(question):
        return False
    return not motions_named(question) and not speaks_of_motion(question)


def ignores_moving_question(slots: Slots | None, question: str) -> bool:
    """Tell whether the model answers another question than whether it moves."""
    passes = slots is None or slots.kind in ("refusal", "contact", "verify")
    return passes and asks_whether_moving(question)


def ignores_offered_choice(slots: Slots | None, question: str) -> bool:
    """Tell whether the model answers with none of the motions offered to it.

    It has read letters before their options alone; "cw/ccw?" offers two without any.
    """
    if asked_kind(question) is not None:
        return False
    offered = offered_options(question)
    if len(offered) > 1:
        if (
            slots is None
            or slots.kind != "choice"
            or not offered.keys() <= offered_letters(question)
        ):
            return True
        return offered.get(slots.letter, slots.direction) != slots.direction
    is_verdict = slots is not None and slots.kind in VERDICTS
    return is_verdict and claimed_motions(question) is None and len(motions_named(question)) > 1


def contradicts_itself(slots: Slots, question: str) -> bool:
    """Tell whether a verdict on the claimed motion contradicts the motion named with it.

    "Yes, it is pressing in." then answers "Is it just resting there?": the model took words it does
    not know for another claim. The rules read the claim of all of 3,600 questions from the
    templates rightly, a quarter of their wordings held out of training.
    """
    claims = claimed_motions(question)
    if slots.verdict is None or slots.kind not in VERDICTS or claims is None:
        return False
    if claimed_motion(question) is None and (slots.kind != "verify" or nearly_named(question)):
        return False
    return slots.verdict != ((slots.direction in claims) != (slots.kind == "negation"))
