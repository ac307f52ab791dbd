"""Where the words of a question speak against what a model made of it."""

from __future__ import annotations

import re
from collections.abc import Mapping

from geotlm_lm.answering.answer import offered_letters
from geotlm_lm.conversation.beyond_touch import asks_beyond_touch
from geotlm_lm.conversation.claims import claimed, claims_end, claims_motion, offered_options
from geotlm_lm.conversation.existence import passes_for, speaks_of_motion
from geotlm_lm.conversation.half_ways import asked_half, claimed_half
from geotlm_lm.conversation.indirect import claim_within
from geotlm_lm.conversation.kind_choices import offered_kinds
from geotlm_lm.conversation.kinds import asked_kind, asks_direction, asks_whether_moving
from geotlm_lm.conversation.motion_names import claimed_motion, motions_named, nearly_named
from geotlm_lm.conversation.option_meanings import offers_neither, option_sets
from geotlm_lm.conversation.retell import VERDICTS
from geotlm_lm.conversation.whole_claims import whole_claim
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion, motion_class
from geotlm_lm.language.parse_answer import Slots

_NO_WAY = ("class", "contact", "moving", "refusal")
"""Kinds of answers that say nothing of a way, which an open question asks for."""

_OPEN = re.compile(r"\W*(?:(?:in )?which|what) (?:way|direction)\b", re.IGNORECASE)
"""What begins so claims nothing: "which way does the coin approach?"."""

CHECKED = (*VERDICTS, "choice", "class")
"""Kinds whose answers name a motion, or its kind, that the open answer may speak against."""


def asked_openly(slots: Slots | None, question: str) -> str | None:
    """Return as which kind a question is to be answered from the answer to the open one.

    None where the model's own answer counts.

    Args:
        slots: Of the model's own answer; None where that does not parse.
        question: What was asked.
    """
    if passes_over_a_claim(slots, question):
        return "direction" if _OPEN.match(question) else "verify"
    if passes_over_a_choice(slots, question):
        return "choice"
    if slots is not None and slots.kind in _NO_WAY and asks_direction(question):
        return "direction"
    if slots is not None and (slots.kind == "confidence" or denies_nothing(slots, question)):
        return slots.kind
    return None


def read_by_rule(question: str) -> str | None:
    """Return as which kind a question is answered whatever a model makes of its words.

    None where the model is asked: no question of the templates is taken from it.
    """
    kind = asked_kind(question)
    if kind in (None, "negation") and whole_claim(question) is not None:
        return "verify"
    if kind in (None, "evidence") and claimed_half(question) is not None:
        return "verify"
    if kind is None and asked_half(question) is not None:
        return "direction"
    if kind is None and offered_kinds(question) is not None:
        return "class"
    is_choice = option_sets(question) is not None or offers_neither(question)
    return "choice" if kind in (None, "negation") and is_choice else None


def denies_the_open_answer(
    slots: Slots, opened: Slots | None, question: str, frame: FrameSpec
) -> bool:
    """Tell whether an answer names another motion than the one the open question is answered with.

    Of 68 real turns 14 were told to slide when asked whether they do, and 66 told rightly when
    asked openly: one clip must not move in two ways, and the open answer is the surer one.

    Args:
        slots: Of the answer, of a `CHECKED` kind.
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


def shares_of_the_claim(
    slots: Slots, shares: Mapping[str, float], question: str, frame: FrameSpec
) -> dict[str, float]:
    """Return how probable a yes and a no to a claim are, by the shares of the open answer.

    The model's own shares may contradict these: a clip that slides to the right at 0.97 slid at
    0.64. Nothing where the question claims no motion or the shares speak against the verdict.

    Args:
        slots: Of the model's verdict.
        shares: Probability of each motion, by its word.
        question: What was asked.
        frame: The frame it was asked in.
    """
    claims = claimed(question)
    if slots.kind != "verify" or claims is None or not set(shares) <= set(Motion):
        return {}
    share = sum(odds for word, odds in shares.items() if frame.tell(Motion(word)) in claims)
    share = min(share, 1.0)
    return {"yes": share, "no": 1.0 - share} if (share >= 0.5) == slots.verdict else {}


def denies_nothing(slots: Slots, question: str) -> bool:
    """Tell whether a "no" answers a question in which no rule finds a motion to say no to.

    The model then took words it does not know for a claim: the motion is read once more from a
    question it knows, and a verdict given only where the question claims a kind of motion.
    """
    is_no = slots.kind in ("verify", "premise") and slots.verdict is False
    return is_no and not motions_named(question) and not nearly_named(question)


def passes_over_a_claim(slots: Slots | None, question: str) -> bool:
    """Tell whether the model declines to judge a claim of motion, or speaks of another thing.

    It may tell of contact, or that it moves and not how: the claim's words are then new to it. What
    presses on the gel or rests on it touches it, so that such a question may well be about contact.
    No question of the templates about contact or about motion as such passes for a claim.
    """
    if asked_kind(question) is not None:
        return False
    question = claim_within(question)
    is_declined = slots is not None and slots.kind == "refusal"
    if not (claims_motion(question) or (is_declined and _names_one_alone(question))):
        return False
    if slots is None:
        return True
    is_over = claims_end(question)
    of_contact = not is_over and claimed_motion(question) in (Motion.PRESS, Motion.STILL)
    of_motion = slots.kind in ("refusal", "moving", "class", "direction")
    return of_motion or (slots.kind == "contact" and not of_contact)


def _names_one_alone(question: str) -> bool:
    """Tell whether a question is no more than the name of a motion, such as "up?"."""
    is_terse = question.rstrip().endswith("?") and len(question.split()) == 1
    return is_terse and claimed_motion(question) is not None


def answers_what_it_cannot(slots: Slots | None, question: str) -> bool:
    """Tell whether the model does not decline where the words ask for what touch cannot tell.

    They do too where it tells of contact, or of motion as such, and they ask for neither.
    """
    if (slots is None or slots.kind != "refusal") and asks_beyond_touch(question):
        return True
    if slots is None or not (passes_for(slots.kind, question) or _affirms_nothing(slots, question)):
        return False
    return asked_kind(question) is None and not claims_motion(question)


def _affirms_nothing(slots: Slots, question: str) -> bool:
    """Tell whether a "yes" tells of a motion where the words speak of none at all."""
    is_yes = slots.kind == "verify" and slots.verdict is True
    if not is_yes or claimed(question) is not None or nearly_named(question):
        return False
    return not motions_named(question) and not speaks_of_motion(question)


def passes_over_moving(slots: Slots | None, question: str) -> bool:
    """Tell whether the model speaks of another thing where the words ask whether it moves."""
    passes = slots is None or slots.kind in ("refusal", "contact", "verify")
    return passes and asks_whether_moving(question)


def passes_over_a_choice(slots: Slots | None, question: str) -> bool:
    """Tell whether the model gives another answer than one of the motions it may choose among.

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
    return is_verdict and claimed(question) is None and len(motions_named(question)) > 1


def contradicts_itself(slots: Slots, question: str) -> bool:
    """Tell whether a verdict on the motion that `question` claims denies the motion told with it.

    "Yes, it is pressing in." then answers "Is it just resting there?": the model took words it does
    not know for another claim. The rules read the claim of all of 3,600 questions from the
    templates rightly, a quarter of their wordings held out of training.
    """
    claims = claimed(question)
    if slots.verdict is None or slots.kind not in VERDICTS or claims is None:
        return False
    if claimed_motion(question) is None and (slots.kind != "verify" or nearly_named(question)):
        return False
    return slots.verdict != ((slots.direction in claims) != (slots.kind == "negation"))
