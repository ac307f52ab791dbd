"""What tools take and return, each stated once: types, bounds, descriptions; plain JSON values."""

from __future__ import annotations

from typing import Annotated, Any, Literal, NotRequired

from pydantic import BaseModel, Field
from typing_extensions import TypedDict  # of 3.11's own one no schema can be made

import geotlm_lm as lm

from .guards import NAME_CHARACTERS, QUESTION_CHARACTERS, ROWS, TOPIC_CHARACTERS

RECORDING = (
    "A name that the tool `recordings` lists, such as 'example:bottle_cap_clockwise'; or a short "
    "recording itself as a data URI in base64, 'data:;base64,...'; or the path of an upload."
)


def _about(kind: Any, description: str, **bounds: Any) -> Any:
    """Return the type of a parameter with its description and bounds."""
    return Annotated[kind, Field(description=description, **bounds)]


def bounded(low: float, high: float, description: str) -> Any:
    """Return the type of a number between two bounds."""
    return _about(float, description, ge=low, le=high)


Recording = _about(str, RECORDING, min_length=1)
Details = _about(
    bool, "Also the evidence, the options, the motion, the frame of reference, times and notes."
)
Question = _about(
    str,
    "In plain English, about motion, contact, times or amounts.",
    min_length=1,
    max_length=QUESTION_CHARACTERS,
)
Condition = _about(
    str,
    "What is waited for, in plain English: 'it has turned 30 degrees clockwise', 'it slips by more "
    "than 0.5 mm', 'contact is lost'.",
    min_length=1,
    max_length=QUESTION_CHARACTERS,
)
Sure = bounded(0.5, 0.999, "Probability with which the condition has to hold.")
LastingS = bounded(0.0, 60.0, "Seconds for which it has to.")
MostS = bounded(0.1, 600.0, "Seconds of the recording that are looked at.")
FrameNumber = Annotated[int, Field(ge=0, le=10**9)]
Frames = _about(
    list[FrameNumber] | None,
    "First and last frame to use, counted from 0; leave it out for all.",
    min_length=2,
    max_length=2,
)
Topic = _about(
    str | None,
    "Of a ROS bag: the topic of the sensor's images, such as '/gelsight/image_raw'; leave it out "
    "where only one has images.",
    min_length=1,
    max_length=TOPIC_CHARACTERS,
)
MmPerPx = _about(
    float | None,
    "Millimetres of gel that a pixel is wide; travel is told in pixels without.",
    ge=0.001,
    le=2.0,
)
Rows = _about(
    int, "Frames of which contact and motion are told, evenly spread; 0 for none.", ge=0, le=ROWS
)
Picture = _about(
    Literal["overlay", "shear", "raw", "difference", "contact", "timeline"],
    "Four frames with their times: with arrows of how far each point of the contact has moved "
    "since the first of them (overlay), with the learned shear, as recorded, against the idle gel, "
    "or with the contact mask; or turn, slide, depth, contact and grip of the whole track over "
    "time (timeline).",
)


class Frame(BaseModel):
    """Parameters that tools share: the frame of reference of directions and travel."""

    mirrored: _about(bool, "The recorded image is flipped left to right.") = False
    turned: _about(
        Literal[0, 90, 180, 270], "Degrees by which the recorded image is turned clockwise."
    ) = 0
    viewpoint: _about(
        Literal["sensor", "object"],
        "From where directions are told: out of the sensor, or from the object.",
    ) = "sensor"
    actor: _about(
        Literal["object", "sensor"], "Whose motion is told: the object's, or the sensor's."
    ) = "object"
    thread: _about(Literal["right", "left"] | None, "Handedness of a thread, if it has one.") = None
    contact_side: _about(
        Literal["head", "shank", "side"] | None,
        "Which side of a screw or cap touches the gel, if known.",
    ) = None
    mm_per_px: MmPerPx = None

    @property
    def spec(self) -> lm.FrameSpec:
        """The same as the library takes it."""
        fields = self.model_dump(exclude={"mirrored", "turned"})
        turn = lm.FrameSpec.fields_of_turn(self.turned)
        return lm.FrameSpec(image_mirrored=self.mirrored, **turn, **fields)


class SimulatedTouch(BaseModel):
    """Parameters of a simulated touch; the fields of a `Touch`."""

    object_name: _about(
        str, 'A shape, for example "key", "coin", "hex_nut".', max_length=NAME_CHARACTERS
    ) = "key"
    depth_mm: bounded(
        -1.0, 1.5, "Approach beyond first touch, half-way, mm; 0 or less: no contact."
    ) = 0.6
    twist_deg: bounded(-60.0, 60.0, "Turn in degrees, positive clockwise in the image.") = 0.0
    slide_x_mm: bounded(-5.0, 5.0, "Travel to the right, mm.") = 0.0
    slide_y_mm: bounded(-5.0, 5.0, "Travel down the image, mm.") = 0.0
    press_mm: bounded(
        -2.0, 2.0, "Approach into the gel from first to last frame, mm; negative lifts."
    ) = 0.0
    thickness_mm: bounded(1.0, 6.0, "Of the gel, mm.") = 4.0
    seed: _about(int, "Of the noise.", ge=0, le=2**31 - 1) = 0


AS_RECORDED, KEY_AT_REST = Frame(), SimulatedTouch()


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


CONFIDENCE = (
    "Probability that the answer is right, that the question was read rightly included; calibrated "
    "on recordings that nothing was chosen by. An amount is right within its tolerance: "
    f"{lm.TOLERANCES['deg']:g} degrees, {lm.TOLERANCES['mm']:g} mm, {lm.TOLERANCES['px']:g} px of "
    f"a 224-pixel image, or {lm.RELATIVE_TOLERANCE:.0%} of it where that is more. 0 where nothing "
    "is told."
)
Confidence = Annotated[float, Field(description=CONFIDENCE)]


class Amount(TypedDict):
    """How far or how fast, and the span it lies in nine times in ten, in `unit`.

    Whether `value` itself is right is what the answer's `confidence` says.
    """

    value: float
    unit: str
    low: float
    high: float


class AnswerResult(TypedDict):
    """An answer in words, decided and as an amount, how probably it is right, and how it was read.

    `decided` is null where nothing is told surely; what it rests on comes with `details`.
    """

    text: str
    decided: str | None
    abstained: bool
    confidence: Confidence
    amount: Amount | None
    direction: lm.Motion | None
    query: str
    motion: NotRequired[dict[str, Any] | None]
    told_by: NotRequired[Literal["model", "rule"]]
    frame: NotRequired[dict[str, Any]]
    options: NotRequired[dict[str, float]]
    timing_ms: NotRequired[dict[str, float]]
    kind: NotRequired[str]
    understood: NotRequired[float]
    evidence: NotRequired[Evidence]
    frames_used: NotRequired[list[int]]
    notes: NotRequired[list[str]]


class ComparisonResult(TypedDict):
    """How two clips relate, and the answer about each."""

    text: str
    relation: Literal["same", "opposite", "different", "unknown"]
    decided: str | None
    confidence: Confidence
    abstained: bool
    first: dict[str, Any]
    second: dict[str, Any]


class SimulatedAnswer(TypedDict):
    """A simulated touch: the answers, the truth, and the error of the amounts that were read."""

    answer: str
    how_far: str
    direction: lm.Motion | None
    confidence: Confidence
    true_motion: lm.Motion
    true_ways: list[lm.Motion]
    moves: dict[str, bool | None]
    is_visible: dict[str, bool]
    is_right: bool
    true: dict[str, float]
    read: dict[str, float]
    error: dict[str, float]
    timing_ms: dict[str, float]


class StoredRecording(TypedDict):
    """A recording that can be named; `kind` is its ending, or "images" for a folder of them.

    `frames` and `fps` are what the file declares, null where it declares nothing.
    """

    name: str
    kind: str
    size_bytes: int
    frames: int | None
    fps: float | None


class Listing(TypedDict):
    """The recordings that can be named; `has_more` tells that the folder holds others as well."""

    recordings: list[StoredRecording]
    examples: list[StoredRecording]
    is_folder_served: bool
    has_more: bool


class Measured(TypedDict):
    """An amount and the span it lies in nine times in ten, in `unit`.

    None where the pictures do not tell how far.
    """

    amount: float | None
    low: float | None
    high: float | None
    unit: str


class TrackEvent(TypedDict):
    """What happened from `begin` to `end`, in frame numbers and seconds, and how probable it is.

    `way` is that of a turn or a slide, as the frame tells it; a touch and a rest have no amount,
    and it is none where the pictures do not tell how far.
    """

    event: str
    way: str | None
    begin: int
    end: int
    begin_s: float
    end_s: float
    amount: NotRequired[float | None]
    low: NotRequired[float]
    high: NotRequired[float]
    unit: NotRequired[str]
    probability: float


class Totals(TypedDict):
    """What a track comes to: net is from first to last frame, in all is there and back.

    A net turn is positive clockwise, travel right and down, as the frame tells them. A limit is the
    least that would have been told of a turn, degrees, and of a slide, in its unit.
    """

    frames: int
    seconds: float
    touched_s: float | None  # none where contact is not known
    turn_net: Measured
    turn_limit: float
    turn_in_all: Measured
    turned_back: int
    slide_net: Measured
    slide_limit: float
    slide_right: float | None  # none where the pictures do not tell how far
    slide_down: float | None
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


class Waited(TypedDict):
    """From when on a condition holds: time, frame and evidence only where it does."""

    holds: bool
    read_as: str
    understood: float
    time_s: NotRequired[float]
    frame: NotRequired[int]
    probability: NotRequired[float | None]
    evidence: NotRequired[str]
    relative_to_sensor: NotRequired[bool]
    latency_ms: NotRequired[float]


class PictureResult(TypedDict):
    """What a picture shows, and itself in base64; agents get it as a picture beside this."""

    shows: str
    mime_type: Literal["image/png"]
    width_px: int
    height_px: int
    png_base64: NotRequired[str]
