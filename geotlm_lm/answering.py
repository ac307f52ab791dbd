"""Load once, encode a clip once, ask many questions: the seam for people and programs.

Words come from the language model's generation; probabilities from scoring the closed set of
answers; the evidence is the geometry the fused token was made of.
"""

from __future__ import annotations

import re
import time
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from geotlm_lm.backbone.stem import View
from geotlm_lm.checkpoint import Bundle, load_bundle
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.geometry import FRAME_COUNT, REGIONS
from geotlm_lm.core.labels import Motion
from geotlm_lm.language.parse_answer import Slots
from geotlm_lm.model import Perception
from geotlm_lm.recordings.choose import choose_frames
from geotlm_lm.recordings.idle import estimate_background

MAX_QUESTION_CHARACTERS = 500

NOT_UNDERSTOOD = "I found no words for that; ask how the touched object moves."
"""Said in place of words that are none of the answers: half-right words must not look like one."""


@dataclass(frozen=True, eq=False)
class Encoded:
    """A clip the model has perceived; every question about it starts here.

    Args:
        clip: The four frames that were used, with the background they were compared with.
        perception: Tokens and geometry, batch of one.
        timing_ms: Milliseconds of each stage that ran.
    """

    clip: Clip
    perception: Perception
    timing_ms: dict[str, float]

    @property
    def view(self) -> View | None:
        """The square of the image that the geometry's grid covers; None where it is no square."""
        return self.perception.views[0]

    @property
    def contact_share(self) -> float:
        """Mean of the contact mask over the view, in [0, 1]."""
        return float(self.perception.geometry.region_mass[0, REGIONS.index("global")])


@dataclass(frozen=True)
class Answer:
    """One answer and what it rests on.

    Args:
        text: The sentence.
        direction: The motion it claims, in `frame`; None when the question asks something else or
            the model abstains.
        confidence: Probability of the answer among those of its kind, in [0, 1]; the temperature
            was fitted on open questions about direction. 0 when the model abstains.
        abstained: Whether the model declines to say.
        frame: The frame of reference every direction is told in.
        options: Probability of each answer that was possible, by its deciding word.
        evidence: Contact share, the view the grid covers (pixels of a 224-pixel image), and per
            region of it the learned shear change (x right, y down, unitless) and contact mass.
        timing_ms: Milliseconds of each stage that ran; a stage that is missing did not run.
        kind: What sort of question was understood; None when the model's words did not parse.
        frames_used: Numbers of the four frames in the recording.
        notes: What was guessed or chosen on the way, one sentence each.
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

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values."""
        return {
            "text": self.text,
            "direction": None if self.direction is None else self.direction.value,
            "confidence": round(self.confidence, 4),
            "abstained": self.abstained,
            "frame": self.frame.to_dict(),
            "options": {name: round(value, 4) for name, value in self.options.items()},
            "timing_ms": {name: round(value, 2) for name, value in self.timing_ms.items()},
            "kind": self.kind,
            "evidence": self.evidence,
            "frames_used": list(self.frames_used),
            "notes": list(self.notes),
        }


class Answerer:
    """Answers questions about clips.

    Args:
        bundle: The model.
    """

    def __init__(self, bundle: Bundle) -> None:
        self.bundle = bundle

    @classmethod
    def load(cls, folder: str | Path | None = None) -> Answerer:
        """Load a bundle from `folder`, or the one that ships with the package.

        Raises:
            IncompatibleBundle: If there is no bundle of this format.
        """
        return cls(load_bundle(None if folder is None else Path(folder)))

    def encode(self, clip: Clip, *, span: tuple[int, int] | None = None) -> Encoded:
        """Choose four frames of `clip`, find or guess its background, and perceive it once.

        Args:
            clip: A recording of two frames or more.
            span: First and last frame to use, both included; None chooses them.

        Raises:
            UnreadableClip: If there is only one frame.
            UsageError: If the span is not inside the clip.
        """
        started = time.perf_counter()
        clip = four_frames_with_background(clip, span)
        chosen = time.perf_counter()
        perception = self.bundle.model.perceive([clip])
        done = time.perf_counter()
        timing = {"choose": 1e3 * (chosen - started), "encode": 1e3 * (done - chosen)}
        return Encoded(clip, perception, timing)

    def ask(self, encoded: Encoded, question: str) -> Answer:
        """Answer `question` about an encoded clip.

        Raises:
            UsageError: If the question is empty or longer than 500 characters.
        """
        question = check_question(question)
        started = time.perf_counter()
        text = self.bundle.speaker.generate(encoded.perception.fused_token, [question])[0]
        generated = time.perf_counter()
        slots = self.bundle.grammar.parse(text)
        options = self.score(encoded, question, slots.kind if slots else "direction")
        scored = time.perf_counter()
        timing = encoded.timing_ms | {
            "generate": 1e3 * (generated - started),
            "score": 1e3 * (scored - generated),
        }
        timing["total"] = sum(timing.values())
        direction = slots.direction if slots else None
        abstained = slots is None or slots.kind == "refusal"
        text = NOT_UNDERSTOOD if slots is None else text
        if self.bundle.calibration.withholds(direction, encoded.contact_share):
            text, direction, abstained = _too_little_contact(encoded.contact_share), None, True
        return Answer(
            text=text,
            direction=direction,
            confidence=0.0 if abstained else options.get(deciding_word(slots), 0.0),
            abstained=abstained,
            frame=FrameSpec(),
            options=options,
            evidence=evidence(encoded),
            timing_ms=timing,
            kind=slots.kind if slots else None,
            frames_used=encoded.clip.frame_numbers,
            notes=encoded.clip.notes,
        )

    def score(self, encoded: Encoded, question: str, kind: str = "direction") -> dict[str, float]:
        """Return the calibrated probability of every answer of `kind`, by its deciding word."""
        grammar = self.bundle.grammar
        sentences = grammar.options_for(kind)
        if kind == "choice" and (offered := _offered_letters(question)):
            sentences = [s for s in sentences if grammar.parse(s).letter in offered]
        log_likelihoods = self.bundle.speaker.score(
            encoded.perception.fused_token[0], question, sentences
        )
        probabilities = self.bundle.calibration.probabilities(log_likelihoods)
        options: dict[str, float] = {}
        for sentence, probability in zip(sentences, probabilities, strict=True):
            word = deciding_word(grammar.parse(sentence))
            options[word] = options.get(word, 0.0) + float(probability)
        return options


def four_frames_with_background(clip: Clip, span: tuple[int, int] | None = None) -> Clip:
    """Return the four frames that show the motion, beside the idle gel, known or estimated.

    Args:
        clip: A recording of two frames or more.
        span: First and last frame to use; None chooses them.
    """
    clip = choose_frames(clip, FRAME_COUNT, span=span)
    if clip.background is None:
        clip = replace(clip, background=estimate_background(clip.frames)).with_note(
            "Background: estimated from the frames; give an idle frame for a surer answer."
        )
    return clip


def check_question(question: str) -> str:
    """Return the question without surrounding blanks.

    Raises:
        UsageError: If nothing is left, it is too long, or it is no valid Unicode.
    """
    if any("\ud800" <= character <= "\udfff" for character in question):
        raise UsageError("the question holds bytes that are no text; type it as UTF-8.")
    question = " ".join(question.split())
    if not question:
        raise UsageError("the question is empty; ask for example 'Which way does it turn?'.")
    if len(question) > MAX_QUESTION_CHARACTERS:
        raise UsageError(
            f"the question has {len(question)} characters, expected at most "
            f"{MAX_QUESTION_CHARACTERS}; ask one short question at a time."
        )
    return question


def deciding_word(slots: Slots) -> str:
    """Return the word that tells an answer from the others of its kind."""
    if slots.kind in ("verify", "contact", "moving"):
        return "yes" if slots.verdict else "no"
    if slots.kind == "choice":
        return f"{slots.letter}) {slots.direction.value}"
    if slots.kind == "class":
        return slots.motion_class.value
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
    return {"contact_share": round(encoded.contact_share, 4), "view": view, "regions": regions}


def _offered_letters(question: str) -> set[str]:
    """Return the letters a question lists: A) or (A) or A. or A:, in either case."""
    return set(re.findall(r"(?<![A-Z])([A-D])[).:]", question.upper()))


def _too_little_contact(share: float) -> str:
    return f"I cannot name a direction: I see next to no contact (mask {share:.3f})."
