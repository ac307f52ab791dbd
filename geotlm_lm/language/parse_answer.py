"""The closed set of answers and their machine slots; parses strictly, knows no question."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, Literal, get_args

from geotlm_lm.core.errors import IncompatibleBundle
from geotlm_lm.core.files import write_text_atomically
from geotlm_lm.core.labels import Motion, MotionClass

Kind = Literal[
    "direction",
    "verify",
    "choice",
    "negation",
    "class",
    "contact",
    "magnitude",
    "rate",
    "comparison",
    "evidence",
    "viewpoint",
    "actor",
    "thread",
    "mirrored",
    "reversed",
    "moving",
    "refusal",
    "premise",
    "confidence",
    "undo",
    "order",
]
KINDS: tuple[str, ...] = get_args(Kind)

Unit = Literal["deg", "px"]
"""Of what is measured: degrees of turning, pixels of sliding."""


@dataclass(frozen=True)
class Slots:
    """What an answer claims, apart from its words; a field is None where the kind has no such slot.

    Args:
        kind: What sort of question it answers.
        direction: The motion it claims, named in the camera image.
        verdict: Its yes or no.
        letter: The option it picks.
        motion_class: The kind of motion it claims.
        unit: Of the amount it says there is, which is measured apart from it.
    """

    kind: Kind
    direction: Motion | None = None
    verdict: bool | None = None
    letter: str | None = None
    motion_class: MotionClass | None = None
    unit: Unit | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return the filled slots as plain JSON values."""
        return {
            name: str(value) if isinstance(value, Motion | MotionClass) else value
            for name, value in asdict(self).items()
            if value is not None
        }

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Slots:
        """Read slots back from `to_dict`.

        Raises:
            ValueError: If a name or a value is none of the known ones.
        """
        unknown = set(values) - {name.name for name in fields(cls)}
        if unknown or values.get("kind") not in KINDS:
            raise ValueError(f"unknown slots {sorted(unknown)} or kind {values.get('kind')!r}")
        converted = dict(values)
        if "direction" in values:
            converted["direction"] = Motion(values["direction"])
        if "motion_class" in values:
            converted["motion_class"] = MotionClass(values["motion_class"])
        if values.get("unit", "deg") not in get_args(Unit):
            raise ValueError(f"unknown unit {values['unit']!r}")
        return cls(**converted)


class AnswerGrammar:
    """One sentence for every filling of the slots, and back; anything else does not parse.

    Args:
        answers: Sentence -> slots.

    Raises:
        ValueError: If two sentences carry the same slots.
    """

    def __init__(self, answers: Mapping[str, Slots]) -> None:
        self._slots = dict(answers)
        self._sentences = {slots: sentence for sentence, slots in answers.items()}
        if len(self._sentences) != len(self._slots):
            twice = [s for s, slots in answers.items() if self._sentences[slots] != s]
            raise ValueError(f"answers {twice} repeat the slots of another sentence")

    def __len__(self) -> int:
        return len(self._slots)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, AnswerGrammar) and self._slots == other._slots

    __hash__ = None

    def parse(self, text: str) -> Slots | None:
        """Return what `text` claims, or None unless it is, to the letter, one of the answers."""
        return self._slots.get(text.strip())

    def sentence(self, slots: Slots) -> str:
        """Return the one sentence for `slots`.

        Raises:
            KeyError: If no answer carries these slots.
        """
        return self._sentences[slots]

    @property
    def kinds(self) -> frozenset[str]:
        """What sorts of question a model of this grammar was trained to answer."""
        return frozenset(slots.kind for slots in self._slots.values())

    def save(self, path: str | Path) -> None:
        """Write the answers as JSON, atomically."""
        rows = [{"text": text, **slots.to_dict()} for text, slots in self._slots.items()]
        write_text_atomically(Path(path), json.dumps(rows, indent=0, ensure_ascii=False) + "\n")

    @classmethod
    def load(cls, path: str | Path) -> AnswerGrammar:
        """Read the answers back from `save`.

        Raises:
            IncompatibleBundle: If the file is missing or holds something else.
        """
        try:
            rows = json.loads(Path(path).read_text(encoding="utf-8"))
            return cls({row.pop("text"): Slots.from_dict(row) for row in rows})
        except (OSError, ValueError, KeyError, AttributeError, TypeError) as error:
            raise IncompatibleBundle(
                f"{path}: found no readable list of answers ({error}), expected the file written "
                f"beside the model; save or download the model again."
            ) from error
