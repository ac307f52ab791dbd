"""What programs get back, field by field; plain JSON values."""

from __future__ import annotations

from typing import Any, Literal, TypedDict

from geotlm_lm import Motion


class Evidence(TypedDict):
    """The geometry an answer rests on; x runs right, y down, shear changes are unitless.

    The contact's middle is in pixels of the recording, `view` in those of a 224-pixel image.
    """

    contact_share: float
    contact_centre_px: list[float] | None
    view: dict[str, float] | None
    regions: dict[str, dict[str, float]]


class EvidenceFields(Evidence):
    """The evidence, the fields it was pooled from (a number a patch of the view), and others' view.

    `shear_change` is 14 x 14 x 2, `contact_mask` 14 x 14, rows first.
    """

    shear_change: list[list[list[float]]]
    contact_mask: list[list[float]]
    frames_used: list[int]
    second_opinions: dict[str, Any]


class Amount(TypedDict):
    """How far or how fast, and the span it lies in nine times in ten, in `unit`."""

    value: float
    unit: str
    low: float
    high: float


class AnswerResult(TypedDict):
    """An answer, its probability, the frame it is told in, and what it rests on."""

    text: str
    direction: Motion | None
    decided: str | None
    amount: Amount | None
    motion: dict[str, Any] | None
    confidence: float
    abstained: bool
    told_by: Literal["model", "rule"]
    frame: dict[str, Any]
    options: dict[str, float]
    timing_ms: dict[str, float]
    kind: str
    query: str
    understood: float
    evidence: Evidence
    frames_used: list[int]
    notes: list[str]
    second_opinions: dict[str, Any]


class ComparisonResult(TypedDict):
    """How two clips relate, and the answer about each."""

    text: str
    relation: Literal["same", "opposite", "different", "unknown"]
    decided: str | None
    confidence: float
    abstained: bool
    first: dict[str, Any]
    second: dict[str, Any]


class SimulatedAnswer(TypedDict):
    """A simulated touch: the answers, the truth, and the error of the amounts that were read."""

    answer: str
    how_far: str
    direction: Motion | None
    confidence: float
    true_motion: Motion
    true_ways: list[Motion]
    counts: dict[str, bool | None]
    is_visible: dict[str, bool]
    is_right: bool
    true: dict[str, float]
    read: dict[str, float]
    error: dict[str, float]
    timing_ms: dict[str, float]
