"""Decide whether an answer is given or withheld.

Withheld for want of contact or of certainty: below `LEAST_SURE` an answer is more likely wrong
than right.
"""

from __future__ import annotations

from dataclasses import replace

from geotlm_lm.answering.answer import Answer, Encoded, evidence
from geotlm_lm.answering.model_query import NEVER_ABSTAINED_KINDS, is_uncertain
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.conversation.motion_answers import RuleAnswer
from geotlm_lm.conversation.wording import confidence_level
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion, MotionClass
from geotlm_lm.language.parse_answer import Slots

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
    bundle: Bundle, encoded: Encoded, told: RuleAnswer, slots: Slots, timing_ms: dict[str, float]
) -> Answer:
    """Return the answer, or an abstention where contact or certainty is too small."""
    text, direction, abstained = told.text, told.direction, told.is_refusal
    sure, notes = told.options.get(told.decided, 0.0), ()
    if bundle.calibration.withholds(slots.direction, encoded.contact_share):
        text = too_little_contact("name a direction", encoded.contact_share)
        direction, abstained = None, True
    elif lacks_reference(encoded, slots):
        text, direction, abstained = NOTHING_CHANGES, None, True
    elif contradicts_gel_change(encoded, slots):
        text, direction, abstained = UNRECOGNISED, None, True
    elif not abstained and slots.kind not in NEVER_ABSTAINED_KINDS:
        notes = _likeliest_other(told)
        if is_uncertain(slots.kind, told.decided, told.options):
            text, direction, abstained = tentative_text(text, sure), None, True
    answer = neutral_answer(encoded, text, slots.kind, told.frame, timing_ms)
    return replace(
        answer,
        direction=direction,
        confidence=0.0 if abstained else sure,
        abstained=abstained,
        options=told.options,
        decided=None if abstained else told.decided,
        notes=(*answer.notes, *notes),
    )


def shows_contact(bundle: Bundle, encoded: Encoded) -> bool:
    """Tell whether a clip shows enough contact for anything to be said, or drawn, of it."""
    is_enough = encoded.contact_share >= bundle.calibration.contact_threshold
    return is_enough and not encoded.is_untouched


def contradicts_gel_change(encoded: Encoded, slots: Slots) -> bool:
    """Tell whether an answer says "nothing touches" although the gel changed."""
    is_denied = slots.kind == "contact" and slots.verdict is False
    is_named = slots.direction is Motion.NONE or slots.motion_class is MotionClass.NONE
    return encoded.is_changed and (is_denied or is_named)


def tentative_text(text: str, sure: float) -> str:
    """Return a sentence, phrased as a guess where its probability is too small."""
    return f"I cannot tell for sure, {sure:.0%}: {text}"


def lacks_reference(encoded: Encoded, slots: Slots) -> bool:
    """Tell whether an answer judges contact without a reference image of the idle gel.

    Whether anything moves may be told all the same: nothing does.
    """
    if not encoded.is_static or slots.kind == "moving":
        return False
    at_rest = slots.direction in (Motion.STILL, Motion.NONE)
    return at_rest or slots.kind == "contact" or slots.motion_class in _AT_REST


_AT_REST = (MotionClass.STILL, MotionClass.NONE)


def too_little_contact(what: str, share: float) -> str:
    """Return why `what` cannot be answered, by the share of the view in contact."""
    return f"I cannot {what}: I see next to no contact (mask {share:.3f})."


def _likeliest_other(told: RuleAnswer) -> tuple[str, ...]:
    """Return a note on what else it may be, where the answer is not nearly certain."""
    sure = told.options.get(told.decided, 0.0)
    rest = {word: share for word, share in told.options.items() if word != told.decided}
    word = max(rest, key=rest.get, default=None)
    if word is None or confidence_level(sure) == "high" or rest[word] < NOTEWORTHY:
        return ()
    begins = LIKELIER if rest[word] > sure else NEXT_LIKELIEST
    return (f"{begins}, at {rest[word]:.0%}: {word}.",)
