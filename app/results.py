"""What programs get back, field by field; plain JSON values."""

from __future__ import annotations

from typing import Any, Literal, NotRequired

from typing_extensions import TypedDict  # of 3.11's own one no schema can be made

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


class StoredRecording(TypedDict):
    """A recording that can be named; `kind` is its ending, or "images" for a folder of them."""

    name: str
    kind: str
    size_bytes: int


class Listing(TypedDict):
    """The recordings that can be named; `has_more` tells that the folder holds others as well."""

    recordings: list[StoredRecording]
    examples: list[str]
    is_folder_served: bool
    has_more: bool


class Measured(TypedDict):
    """An amount and the span it lies in nine times in ten, in `unit`."""

    amount: float
    low: float
    high: float
    unit: str


class TrackEvent(TypedDict):
    """What happened from `begin` to `end`, in frame numbers and seconds, and how probable it is.

    `way` is that of a turn or a slide, as the frame tells it; a touch and a rest have no amount.
    """

    event: str
    way: str | None
    begin: int
    end: int
    begin_s: float
    end_s: float
    amount: NotRequired[float]
    low: NotRequired[float]
    high: NotRequired[float]
    unit: NotRequired[str]
    probability: float


class Totals(TypedDict):
    """What a track comes to: net is from first to last frame, in all is there and back.

    A net turn is positive clockwise, travel right and down, as the frame tells them.
    """

    frames: int
    seconds: float
    touched_s: float
    turn_net: Measured
    turn_in_all: Measured
    turned_back: int
    slide_net: Measured
    slide_right: float
    slide_down: float
    slide_in_all: Measured


class TrackResult(TypedDict):
    """What happened in a recording, when, which way and how far.

    `times_are_known` is false where nothing tells the frame rate: seconds are then of 25 a second.
    `rows` are frames evenly spread, each with contact, motion since the first one and deviations.
    """

    recording: str
    frame: str
    first_frame: int
    last_frame: int
    times_are_known: bool
    contacts_s: list[list[float]]
    events: list[TrackEvent]
    events_left_out: int
    totals: Totals
    rows: list[dict[str, float]]
    notes: list[str]


class PictureResult(TypedDict):
    """What a picture shows, and itself in base64; agents get it as a picture beside this."""

    shows: str
    mime_type: Literal["image/png"]
    width_px: int
    height_px: int
    png_base64: NotRequired[str]
