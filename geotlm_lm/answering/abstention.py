"""Decide whether an answer is given or withheld.

Withheld for want of contact or of certainty: below `LEAST_SURE` an answer is more likely wrong
than right.
"""

from __future__ import annotations

from dataclasses import replace

from geotlm_lm.answering.answer import Answer, evidence
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.measured_motion import MeasuredMotion
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.felt import AT_REST
from geotlm_lm.conversation.rule_answers import RuleAnswer
from geotlm_lm.conversation.wording import confidence_level
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion, MotionClass

UNRECOGNISED = (
    "I cannot tell: the gel has changed by more than noise, but I recognise no touch in it; press "
    "harder, or record the idle gel again."
)
"""Said in place of a claim that nothing touches."""

NOTHING_CHANGES = (
    "Nothing moves in these frames; whether anything touches the gel I cannot tell without an idle "
    "frame: begin a recording before the touch, or give one as its background."
)
"""Said in place of "it is still" and "nothing touches" where the idle gel is a guess. Of 111 idle
starts of real recordings without their idle frame 96 were told as a still touch, 79 of them at 0.9
or more, and 106 as touching."""

LEAST_SURE = 0.5
"""Probability below which an answer is withheld: it would more likely be wrong than right."""

NEVER_ABSTAINED_KINDS = frozenset({"evidence", "confidence", "refusal"})
"""Kinds whose answers are told whatever their probability: who asks for the confidence is told
it."""

NEXT_LIKELIEST = "Next likeliest"
LIKELIER = "Likelier by the probabilities"
"""How a note on another answer begins; words are written freely and need not be the likeliest."""

NOTEWORTHY = 0.05
"""An answer whose confidence is not called high is told with the likeliest other one, if that one
is at least this probable."""


def neutral_answer(
    encoded: Encoded,
    text: str,
    kind: str | None,
    frame: FrameSpec,
    timing_ms: dict[str, float] | None = None,
) -> Answer:
    """Return an answer that claims nothing."""
    timing = encoded.timing_ms | (timing_ms or {})
    timing["total"] = sum(timing.values())
    return Answer(
        text=text,
        direction=None,
        confidence=0.0,
        abstained=True,
        frame=frame,
        options={},
        evidence=evidence(encoded),
        timing_ms=timing,
        kind=kind,
        frames_used=encoded.clip.frame_numbers,
        notes=encoded.clip.notes,
    )


def answer_or_abstain(
    bundle: Bundle, encoded: Encoded, told: RuleAnswer, kind: str, timing_ms: dict[str, float]
) -> Answer:
    """Return the answer, or an abstention where contact or certainty is too small."""
    text, direction, abstained = told.text, told.direction, told.is_refusal
    notes = ()
    if bundle.calibration.withholds(direction, encoded.contact_share):
        text = too_little_contact("name a direction", encoded.contact_share)
        direction, abstained = None, True
    elif lacks_reference(encoded, told, kind):
        text, direction, abstained = NOTHING_CHANGES, None, True
    elif contradicts_gel_change(encoded, told, kind):
        text, direction, abstained = UNRECOGNISED, None, True
    elif not abstained and kind not in NEVER_ABSTAINED_KINDS:
        notes = _likeliest_other(told)
        if told.confidence < LEAST_SURE:
            text, direction, abstained = tentative_text(text, told.confidence), None, True
    answer = neutral_answer(encoded, text, kind, told.frame, timing_ms)
    return replace(
        answer,
        direction=direction,
        confidence=0.0 if abstained else told.confidence,
        abstained=abstained,
        options=told.options,
        decided=None if abstained else told.decided,
        notes=(*answer.notes, *notes),
        motion=MeasuredMotion.of(encoded, told.frame),
    )


def shows_contact(bundle: Bundle, encoded: Encoded) -> bool:
    """Tell whether a clip shows enough contact for anything to be said, or drawn, of it."""
    is_enough = encoded.contact_share >= bundle.calibration.contact_threshold
    return is_enough and not encoded.is_untouched


def contradicts_gel_change(encoded: Encoded, told: RuleAnswer, kind: str) -> bool:
    """Tell whether an answer says "nothing touches" although the gel changed."""
    is_denied = kind == "contact" and told.decided == "no"
    is_named = told.direction is Motion.NONE or told.motion_class is MotionClass.NONE
    return encoded.is_changed and (is_denied or is_named)


def tentative_text(text: str, sure: float) -> str:
    """Return a sentence, phrased as a guess where its probability is too small."""
    return f"I cannot tell for sure, {sure:.0%}: {text}"


def lacks_reference(encoded: Encoded, told: RuleAnswer, kind: str) -> bool:
    """Tell whether an answer judges contact without a reference image of the idle gel.

    Whether anything moves may be told all the same: nothing does.
    """
    if not encoded.is_static or kind == "moving":
        return False
    at_rest = told.motion_class in (MotionClass.STILL, MotionClass.NONE)
    return kind == "contact" or told.direction in AT_REST or at_rest


def too_little_contact(what: str, share: float) -> str:
    """Return why `what` cannot be answered, by the share of the view in contact."""
    return f"I cannot {what}: I see next to no contact (mask {share:.3f})."


def _likeliest_other(told: RuleAnswer) -> tuple[str, ...]:
    """Return a note on what else it may be, where the answer is not nearly certain."""
    sure, is_of_motions = told.confidence, set(told.options) <= set(Motion)
    rest = {
        word: share
        for word, share in told.options.items()
        if word != told.decided and not (is_of_motions and share >= LEAST_SURE)
    }
    word = max(rest, key=rest.get, default=None)
    if word is None or confidence_level(sure) == "high" or rest[word] < NOTEWORTHY:
        return ()
    begins = LIKELIER if rest[word] > sure else NEXT_LIKELIEST
    return (f"{begins}, at {rest[word]:.0%}: {word}.",)
