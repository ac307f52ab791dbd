"""Understand what kind of question is asked, by its words and by what the model makes of them.

A model trained on a closed set of wordings takes unknown ones for other questions; rules on the
words notice that.
"""

from __future__ import annotations

import re

from geotlm_lm.answering.answer import offered_letters
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.model_query import ModelReply, query_likeliest
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.compound_claims import compound_claim
from geotlm_lm.conversation.existence_questions import is_unasked_existence, speaks_of_motion
from geotlm_lm.conversation.half_directions import asked_half, claimed_half
from geotlm_lm.conversation.indirect_questions import embedded_claim
from geotlm_lm.conversation.kind_choices import offered_kinds
from geotlm_lm.conversation.kinds import (
    LATER_KINDS,
    asked_kind,
    asks_direction,
    asks_whether_moving,
    is_ruled_out,
)
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
from geotlm_lm.core.labels import Motion
from geotlm_lm.language.parse_answer import Slots

_NO_WAY = ("class", "contact", "moving", "refusal")
"""Kinds of answers that say nothing of a way, which an open question asks for."""

_OPEN = re.compile(r"\W*(?:(?:in )?which|what) (?:way|direction)\b", re.IGNORECASE)
"""What begins so claims nothing: "which way does the coin approach?"."""

_SEVERAL = ("comparison", "order")
"""Kinds whose words, common ones, overrule no kind that the model tells."""


def understood_kind(
    bundle: Bundle, encoded: Encoded, question: str, heard: ModelReply
) -> str | None:
    """Return what kind of question it is, by its words and by what the model makes of them.

    None where neither tells.

    Args:
        bundle: The model.
        encoded: The clip it was asked about.
        question: What was asked.
        heard: The model's reply.
    """
    slots, told = heard.slots, asked_kind(question)
    if told is not None and told not in bundle.grammar.kinds:
        return told
    if is_ruled_out(question, slots and slots.kind):
        if told is not None and told not in _SEVERAL:
            return told
        kinds = bundle.grammar.kinds - LATER_KINDS
        if not offered_letters(question):
            kinds -= {"choice"}
        slots = query_likeliest(bundle, encoded, question, kinds).slots
    if _ignores_moving_question(slots, question):
        return "moving"
    if _answers_unanswerable(slots, question) and "refusal" in bundle.grammar.kinds:
        return "refusal"
    return _kind_from_words(slots, question) or (slots and slots.kind)


def kind_told(bundle: Bundle, encoded: Encoded, question: str) -> str | None:
    """Return the kind that a question's words tell, whatever the model writes; None if they do not.

    Args:
        bundle: The model.
        encoded: The clip it is asked about.
        question: What was asked.
    """
    kind = "direction" if asks_direction(question) else asked_kind(question)
    if kind in (None, *_SEVERAL):
        return None
    return understood_kind(bundle, encoded, question, ModelReply(Slots(kind), ""))


def _kind_from_words(slots: Slots | None, question: str) -> str | None:
    """Return the kind that the words tell against the model's; None where its own counts."""
    if _ignores_motion_claim(slots, question):
        return "direction" if _OPEN.match(question) else "verify"
    if _ignores_offered_choice(slots, question):
        return "choice"
    if slots is not None and slots.kind in _NO_WAY and asks_direction(question):
        return "direction"
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


def _ignores_motion_claim(slots: Slots | None, question: str) -> bool:
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


def _answers_unanswerable(slots: Slots | None, question: str) -> bool:
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


def _ignores_moving_question(slots: Slots | None, question: str) -> bool:
    """Tell whether the model answers another question than whether it moves."""
    passes = slots is None or slots.kind in ("refusal", "contact", "verify")
    return passes and asks_whether_moving(question)


def _ignores_offered_choice(slots: Slots | None, question: str) -> bool:
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
