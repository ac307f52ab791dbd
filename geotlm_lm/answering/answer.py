"""Data classes of what goes in and comes out of an answer; runs no model."""

from __future__ import annotations

import re
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import torch
from torch import Tensor

from geotlm_lm.answering.amounts import Amount
from geotlm_lm.backbone.contrast_equalisation import equalised_motions
from geotlm_lm.backbone.stem import StemMeasurement, measure_clip
from geotlm_lm.backbone.view import View
from geotlm_lm.conversation.motion_answers import VERDICTS
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.geometry import FRAME_COUNT, REGIONS
from geotlm_lm.core.labels import Motion, MotionClass
from geotlm_lm.language.parse_answer import Slots
from geotlm_lm.model import Perception, contact_centre
from geotlm_lm.recordings.choose import choose_frames
from geotlm_lm.recordings.idle import estimate_background

MIN_TIMED_FRAMES = 3
"""Different frames a speed needs."""

_VERDICT_WORDS = dict.fromkeys(("contact", "moving"), ("yes", "no")) | {
    kind: words for kind, (_, _, *words) in VERDICTS.items()
}
"""Deciding words where it is as the question says, denied or not, and where it is not."""

KIND_OF_UNIT = {"deg": MotionClass.ROTATION.value, "px": MotionClass.SLIDE.value}
"""Unit of what is measured -> the deciding word of an answer that says there is such an amount."""

CUT_OFF_DOUBT = 1.5
"""Of an imprint of which a part is out of the image. Of 66 simulated clips of training objects,
moved to the border until they were cut off, 0.79 were told right at a mean probability of 0.90;
1.5 times the temperature makes that 0.78."""

FAINT_DOUBT = 1.5
"""Of what hardly changes the gel. Of 110 simulated clips faded so far to a tenth or a twentieth of
their contrast 71 are told, 0.77 of them right at a mean probability of 0.76; without the doubt 86,
0.79 of them right at 0.86."""


@dataclass(frozen=True, eq=False)
class Encoded:
    """A clip the model has perceived; every question about it starts here.

    Args:
        clip: The four frames that were used, with the background they were compared with.
        perception: Tokens and geometry, batch of one.
        timing_ms: Milliseconds of each stage that ran.
        is_untouched: Whether every frame differs from the background by less than any touch does;
            what is perceived is then the background itself.
        is_changed: Whether some frame differs from the idle gel by more than noise, codecs and
            lamps make it: that nothing touches may then not be claimed. Not known, and False, where
            the background is a guess.
        is_faint: Whether some frame differs by more than noise, but no more than codecs and lamps
            may make it; likewise.
        is_cut_off: Whether the border of the image cuts through the imprint; likewise.
        is_static: Whether the background is a guess and no frame differs from the first by more
            than an untouched gel may: a touch held still and no touch then look alike.
        is_part: Whether the frames used were chosen inside a longer recording, or inside the span
            that was asked for: how far it went in the whole is then not known.
        given_equalised_motions: How its contrast-equalised images are taken to have moved,
            (1, *EQUALISED_SHAPE); None where that is measured, once, when first asked for.
    """

    clip: Clip
    perception: Perception
    timing_ms: dict[str, float]
    is_untouched: bool = False
    is_changed: bool = False
    is_faint: bool = False
    is_cut_off: bool = False
    is_static: bool = False
    is_part: bool = False
    given_equalised_motions: Tensor | None = None

    @property
    def view(self) -> View | None:
        """The square of the image that the geometry's grid covers; None where it is no square."""
        return self.perception.views[0]

    @cached_property
    def stem_inputs(self) -> Tensor:
        """What the stem makes of the clip, whichever backbone perceived it."""
        inputs = self.perception.inputs
        return torch.from_numpy(self._stem_measurement.inputs[None]) if inputs is None else inputs

    @cached_property
    def equalised_motions(self) -> Tensor:
        """How the contrast-equalised images move; measured only where an amount is asked for."""
        if self.given_equalised_motions is not None:
            return self.given_equalised_motions
        traces = self.perception.alignment_images
        return torch.from_numpy(
            equalised_motions(traces[0] if traces else self._stem_measurement.alignment_images)[
                None
            ]
        )

    @cached_property
    def _stem_measurement(self) -> StemMeasurement:
        return measure_clip(self.clip)

    @property
    def doubt(self) -> float:
        """What multiplies the temperature of every probability."""
        return max(CUT_OFF_DOUBT if self.is_cut_off else 1.0, FAINT_DOUBT if self.is_faint else 1.0)

    @property
    def contact_share(self) -> float:
        """Mean of the contact mask over the view, in [0, 1]."""
        return float(self.perception.geometry.region_mass[0, REGIONS.index("global")])

    @property
    def seconds(self) -> float | None:
        """Time from the first to the last frame used; None without a frame rate.

        Two frames alone give none either: they may be any two of a longer motion.
        """
        numbers = self.clip.frame_numbers
        if self.clip.fps is None or len(set(numbers)) < MIN_TIMED_FRAMES:
            return None
        return (max(numbers) - min(numbers)) / self.clip.fps


@dataclass(frozen=True)
class Lean:
    """The most likely direction, given that the presumed kind of motion occurs.

    Args:
        direction: The likeliest motion of that kind, in the answer's frame.
        share: Its share of the probability that all motions of that kind have, the geometric mean
            of the language model's and the linear probe's.
        text: The sentence, also among the answer's notes.
    """

    direction: Motion
    share: float
    text: str

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values."""
        return {
            "direction": self.direction.value,
            "share": round(self.share, 4),
            "text": self.text,
        }


@dataclass(frozen=True)
class Answer:
    """One answer and what it rests on.

    Args:
        text: The sentence.
        direction: The motion it claims, in `frame`; None when the question asks something else or
            the model abstains.
        confidence: Probability of the answer among those of its kind, of an amount that it is right
            within its tolerance, in [0, 1]; the temperature was fitted on open questions about
            direction. 0 when the model abstains.
        abstained: Whether the model declines to say.
        frame: The frame of reference every direction is told in.
        options: Probability of each answer that was possible, by its deciding word.
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
        lean: Which way it turns, or slides, if it does: told where an open question takes that for
            granted and the answer names another motion; None where nothing leans.
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
    lean: Lean | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values."""
        return {
            "text": self.text,
            "direction": None if self.direction is None else self.direction.value,
            "decided": self.decided,
            "amount": None if self.amount is None else self.amount.to_dict(),
            "lean": None if self.lean is None else self.lean.to_dict(),
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


def four_frames_with_background(clip: Clip) -> Clip:
    """Return the four frames that show the motion, beside the idle gel, known or estimated.

    Args:
        clip: A recording of two frames or more.
    """
    return with_background(choose_frames(clip, FRAME_COUNT))


def with_background(clip: Clip) -> Clip:
    """Return a clip of a few frames beside its idle gel, estimated where it is not known."""
    if clip.background is None:
        clip = replace(clip, background=estimate_background(clip.frames)).with_note(
            "Background: estimated from the frames; give an idle frame for a surer answer."
        )
    return clip


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
