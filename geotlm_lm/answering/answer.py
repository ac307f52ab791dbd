"""What comes out of a question; runs no model."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

from geotlm_lm.core.edit import Edit
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENTS, Component
from geotlm_lm.motion.belief import Belief
from geotlm_lm.query.phrases import amount_phrase
from geotlm_lm.query.program import Program
from geotlm_lm.query.values import Measure, Recording, Value, measure


@dataclass(frozen=True)
class MeasuredMotion:
    """The motion from the first frame used to the last, in the frame that the answer is told in.

    Args:
        measures: Of each component how far it goes: degrees, pixels of the recording's frames or mm
            where their size is known, and mm of a press.
        right: Part of the slide to the right, in its unit.
        down: Part of it down the image.
        moves: Probability that each component moves.
        ways: The likeliest way of each, given that it moves.
        limits: How far each has to go to be seen, in the unit of its measure; None where that
            is not known.
        readable: Whether the picture tells how far each goes.
        contact: Probability that something touches.
    """

    measures: dict[Component, Measure]
    right: float
    down: float
    moves: dict[Component, float]
    ways: dict[Component, Motion]
    limits: dict[Component, float | None]
    readable: dict[Component, bool]
    contact: float

    @classmethod
    def of(cls, belief: Belief, recording: Recording, frame: FrameSpec) -> MeasuredMotion:
        """Return what is believed of a clip; `frame` tells the size of a pixel, if anybody does."""
        measures = {part: measure(part.value, belief, frame, recording) for part in COMPONENTS}
        return cls(
            measures,
            right=measure("right", belief, frame, recording).mean,
            down=measure("down", belief, frame, recording).mean,
            moves={part: belief.moves(part) for part in COMPONENTS},
            ways={part: belief.way(part) for part in COMPONENTS},
            limits={
                part: round(measure(part.value, belief.at_limit, frame, recording).mean, 4)
                if part in belief.limits
                else None
                for part in COMPONENTS
            },
            readable={part: belief.readable[part] for part in COMPONENTS},
            contact=belief.contact,
        )

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values: of each component size, span, limit and whether it moves.

        The spans are of the size, without sign.
        """
        row: dict[str, Any] = {}
        for part in COMPONENTS:
            measured = self.measures[part]
            low, high = measured.span
            row[part.value] = {
                "unit": measured.unit,
                "mean": round(measured.mean, 4),
                "low": low,
                "high": high,
                "limit": self.limits[part],
                "moves": round(self.moves[part], 4),
                "way": self.ways[part].value,
                "readable": self.readable[part],
            }
        row["slide"] |= {"right": round(self.right, 4), "down": round(self.down, 4)}
        return row | {"contact": round(self.contact, 4)}

    def sentence(self) -> str:
        """Return what was measured, and how far off it may be."""
        parts = []
        for part in COMPONENTS:
            way = self.ways[part].value
            doing = {"press": "growth", "release": "shrinking"}.get(way, f"{part.value} {way}")
            what = f"a {doing} of the contact" if part is Component.PRESS else f"a {doing}"
            doubt = "" if self.readable[part] else ", which the picture hardly tells"
            amount = amount_phrase(self.measures[part], with_span=True)
            parts.append(f"{what} of about {amount}{doubt}")
        return f"Measured from the first frame to the last: {'; '.join(parts)}."


@dataclass(frozen=True)
class Answer:
    """One answer and what it rests on.

    Args:
        text: The sentence, in the form that was asked for.
        direction: The motion it claims, as `frame` and the question's point of view name it: of the
            component that is asked about, of an open question the larger; None when the question
            asks something else or the model abstains.
        confidence: Probability of the least sure thing that it says and that is no guess, of an
            amount that it is right within its tolerance, times that of the question being
            understood, in [0, 1]. 0 when the model abstains.
        abstained: Whether the model declines to say.
        frame: The frame of reference every direction is told in.
        options: Probability of each answer that was possible, by its deciding word. Several motions
            may hold at once: theirs need not sum to 1.
        evidence: Contact share, the view the grid covers (pixels of a 224-pixel image), and per
            region of it the learned shear change (x right, y down, unitless) and contact mass.
        timing_ms: Milliseconds of each stage that ran; a stage that is missing did not run.
        kind: The type of what was asked first: "bool", "number", "time", "event", "way", "label",
            "record" or "talk"; "fact" where nothing was.
        frames_used: Numbers of the four frames in the recording.
        notes: What was guessed or chosen on the way, one sentence each; what is withheld as well.
        decided: The word that this answer is, such as "yes", "clockwise" or "13 deg": what a
            program reads. None when nothing was decided.
        amount: How far or how fast, with the span it lies in nine times in ten; None when the
            question asks something else or there is no such amount.
        motion: Every component at once, whatever was asked, in the frame that `direction` is in.
        query: How the question was understood, in the words of `query.program`.
        understood: Probability that it was, in [0, 1].
        resumed: The program itself, for what is asked next.
        values: What everything that was asked comes to, in its order.
        point_of_view: That was named last, in words; None where none was.
        question: As it was typed.
        written: The program as the model wrote it, numbers and copied words as slots.
        withheld: The sentence, with its reason, where a form that programs read leaves something
            out.
        is_own: What tells whether the language model says the same word for word.
    """

    text: str
    direction: Motion | None
    confidence: float
    abstained: bool
    frame: FrameSpec
    options: dict[str, float]
    evidence: dict[str, Any]
    timing_ms: dict[str, float]
    kind: str
    frames_used: tuple[int, ...]
    notes: tuple[str, ...] = ()
    decided: str | None = None
    amount: Measure | None = None
    motion: MeasuredMotion | None = None
    query: str = ""
    understood: float = 1.0
    resumed: Program = field(default_factory=Program)
    point_of_view: str | None = None
    values: tuple[Value, ...] = ()
    question: str = ""
    written: str = ""
    withheld: tuple[str, ...] = ()
    is_own: Callable[[], bool] = field(default=bool, repr=False, compare=False)

    @cached_property
    def told_by(self) -> Literal["model", "rule"]:
        """Whose sentence it is, worked out when first asked for.

        "model" where the language model says the same word for word, its numbers copied from the
        value; else "rule".
        """
        return "model" if self.is_own() else "rule"

    @property
    def places(self) -> list[int]:
        """Which of two clips each part is about: 0 the first, 1 the second, or if none is named."""
        parts = ({each.word for each in answer} for answer in self.resumed.answers)
        return [int(words.isdisjoint(("of-first", "of-previous"))) for words in parts] or [1]

    def naming(self, first: str, second: str) -> Answer:
        """Return the answer that names which of two recordings it is about; a form stays as it is.

        So does talk.
        """
        if self.kind in ("talk", "fact") or self.resumed.form != "sentence":
            return self
        both = f"{first}, the first", f"{second}, the second"
        names = "; ".join(both[place] for place in dict.fromkeys(self.places))
        text = self.text.removesuffix(".")
        return replace(self, text=f"{text} ({names}){'.' * (text != self.text)}")

    @property
    def edit(self) -> Edit:
        """The point of view that `direction` is told from: the frame's and the question's."""
        return self.values[0].edit if self.values else self.frame.edit

    @property
    def in_the_image(self) -> Motion | None:
        """The motion it claims as the recorded image shows it; None where it claims none."""
        return None if self.direction is None else self.edit.inverse().of_way(self.direction)

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
            "query": self.query,
            "understood": round(self.understood, 4),
            "evidence": self.evidence,
            "frames_used": list(self.frames_used),
            "notes": list(self.notes),
        }


@dataclass(frozen=True)
class Comparison:
    """How two clips relate.

    Args:
        text: The sentence.
        relation: Of their larger motions: "same", "opposite" or "different"; "unknown" where one is
            withheld.
        confidence: As of an answer.
        abstained: Whether the model declines to say.
        first: Which way the first clip goes.
        second: Which way the second one goes.
        decided: The word a program reads: "yes" or "no" where that is asked, "first", "second" or
            "neither" where it is asked which, else the relation; None when nothing was decided.
        kind: As of an answer.
        frame: Likewise.
        resumed: Likewise.
    """

    text: str
    relation: str
    confidence: float
    abstained: bool
    first: Answer
    second: Answer
    decided: str | None
    kind: str
    frame: FrameSpec
    resumed: Program

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values."""
        return {
            "text": self.text,
            "relation": self.relation,
            "decided": self.decided,
            "confidence": round(self.confidence, 4),
            "abstained": self.abstained,
            "first": self.first.to_dict(),
            "second": self.second.to_dict(),
        }


@dataclass(frozen=True)
class Why:
    """The reasons for an answer.

    Args:
        steps: One sentence each, from the contact to the conclusion.
        source: Whose words they are.
    """

    steps: tuple[str, ...]
    source: str


def answer_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of an answer; under `$defs`, of a batch's row."""
    return json.loads(Path(__file__).with_name("answer.schema.json").read_text(encoding="utf-8"))
