"""What comes out of an answer; runs no model."""

from __future__ import annotations

import re
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

from geotlm_lm.answering.amounts import Amount
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.measured_motion import MeasuredMotion
from geotlm_lm.conversation.motion_answers import VERDICTS
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.geometry import REGIONS
from geotlm_lm.core.labels import Motion, MotionClass
from geotlm_lm.language.parse_answer import Slots
from geotlm_lm.model import contact_centre

_VERDICT_WORDS = dict.fromkeys(("contact", "moving"), ("yes", "no")) | {
    kind: words for kind, (_, _, *words) in VERDICTS.items()
}
"""Deciding words where it is as the question says, denied or not, and where it is not."""

KIND_OF_UNIT = {"deg": MotionClass.ROTATION.value, "px": MotionClass.SLIDE.value}
"""Unit of what is measured -> the deciding word of an answer that says there is such an amount."""


@dataclass(frozen=True)
class Answer:
    """One answer and what it rests on.

    Args:
        text: The sentence.
        direction: The motion it claims, in `frame`: of the component that is asked about, of an
            open question the larger; None when the question asks something else or the model
            abstains.
        confidence: Probability of the least sure thing it says, of an amount that it is right
            within its tolerance, in [0, 1]. 0 when the model abstains.
        abstained: Whether the model declines to say.
        frame: The frame of reference every direction is told in.
        options: Probability of each answer that was possible, by its deciding word. Several motions
            may hold at once: theirs need not sum to 1.
        evidence: Contact share, the view the grid covers (pixels of a 224-pixel image), and per
            region of it the learned shear change (x right, y down, unitless) and contact mass.
        timing_ms: Milliseconds of each stage that ran; a stage that is missing did not run.
        kind: What sort of question was understood; "frame" for a fact about the recording; None
            when the model's words did not parse or the question is not English.
        frames_used: Numbers of the four frames in the recording.
        notes: What was guessed or chosen on the way, one sentence each.
        decided: The word of `options` that this answer is, such as "yes" or "clockwise": what a
            program reads. Of amounts it is one such as "13 deg", how far altogether where a speed
            was asked for. None when nothing was decided.
        told_by: Whose sentence it is: the language model's own, or a rule's that follows from what
            the model read or stands for what it could not say.
        amount: How far or how fast, with the span it lies in nine times in ten; None when the
            question asks something else or there is no such amount.
        motion: Every component at once, in the camera image, whatever was asked: how far it goes,
            with spans, whether it counts, and whether the picture tells; None where no motion was
            asked about.
    """

    text: str
    direction: Motion | None
    confidence: float
    abstained: bool
    frame: FrameSpec
    options: dict[str, float]
    evidence: dict[str, Any]
    timing_ms: dict[str, float]
    kind: str | None
    frames_used: tuple[int, ...]
    notes: tuple[str, ...] = field(default=())
    decided: str | None = None
    told_by: Literal["model", "rule"] = "rule"
    amount: Amount | None = None
    motion: MeasuredMotion | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values."""
        return {
            "text": self.text,
            "direction": None if self.direction is None else self.direction.value,
            "decided": self.decided,
            "amount": None if self.amount is None else self.amount.to_dict(),
            "motion": None if self.motion is None else self.motion.to_dict(),
            "confidence": round(self.confidence, 4),
            "abstained": self.abstained,
            "told_by": self.told_by,
            "frame": self.frame.to_dict(),
            "options": {name: round(value, 4) for name, value in self.options.items()},
            "timing_ms": {name: round(value, 2) for name, value in self.timing_ms.items()},
            "kind": self.kind,
            "evidence": self.evidence,
            "frames_used": list(self.frames_used),
            "notes": list(self.notes),
        }


def deciding_word(slots: Slots) -> str:
    """Return the word that distinguishes an answer among those of its kind."""
    if slots.kind in _VERDICT_WORDS:
        is_so = slots.verdict != (slots.kind == "negation")  # there the denial is judged
        return _VERDICT_WORDS[slots.kind][not is_so]
    if slots.kind == "choice":
        return f"{slots.letter}) {slots.direction.value}"
    if slots.kind == "class":
        return slots.motion_class.value
    if slots.unit is not None:
        return KIND_OF_UNIT[slots.unit]
    return slots.direction.value if slots.direction else slots.kind


def evidence(encoded: Encoded) -> dict[str, Any]:
    """Return the geometry an answer rests on, as plain values."""
    geometry = encoded.perception.geometry
    descriptor = geometry.descriptor[0].view(2, len(REGIONS)).tolist()
    mass = geometry.region_mass[0].tolist()
    regions = {
        name: {
            "shear_change_x": round(descriptor[0][column], 4),
            "shear_change_y": round(descriptor[1][column], 4),
            "contact_mass": round(mass[column], 4),
        }
        for column, name in enumerate(REGIONS)
    }
    view = encoded.view and {name: round(px, 1) for name, px in asdict(encoded.view).items()}
    centre = None
    if encoded.view and not encoded.is_untouched:
        size = encoded.clip.frames.shape[1:3]
        centre = [round(px, 1) for px in contact_centre(geometry, encoded.view, size)]
    return {
        "contact_share": round(encoded.contact_share, 4),
        "contact_centre_px": centre,
        "view": view,
        "regions": regions,
    }


def offered_letters(question: str) -> set[str]:
    """Return the letters a question lists: A) or (A) or A. or A:, in either case."""
    return set(re.findall(r"(?<![A-Z])([A-F])[).:]", question.upper()))
