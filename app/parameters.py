"""What tools are told, parameter by parameter: type, bounds and description, stated once."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from geotlm_lm import FrameSpec

from .limits import NAME_CHARACTERS, QUESTION_CHARACTERS, ROWS, TOPIC_CHARACTERS

RECORDING = (
    "A name that the tool `recordings` lists, such as 'example:bottle_cap_clockwise'; or a short "
    "recording itself as a data URI in base64, 'data:;base64,...'; or the path of an upload."
)

Recording = Annotated[str, Field(description=RECORDING, min_length=1)]
Question = Annotated[
    str,
    Field(
        description="In plain English, about motion, contact, times or amounts.",
        min_length=1,
        max_length=QUESTION_CHARACTERS,
    ),
]
FrameNumber = Annotated[int, Field(ge=0, le=10**9)]
Frames = Annotated[
    list[FrameNumber] | None,
    Field(
        description="First and last frame to use, counted from 0; leave it out for all.",
        min_length=2,
        max_length=2,
    ),
]
Topic = Annotated[
    str | None,
    Field(
        description="Of a ROS bag: the topic of the sensor's images, such as "
        "'/gelsight/image_raw'; leave it out where only one has images.",
        min_length=1,
        max_length=TOPIC_CHARACTERS,
    ),
]
Mirrored = Annotated[bool, Field(description="The recorded image is flipped left to right.")]
Turned = Annotated[
    Literal[0, 90, 180, 270],
    Field(description="Degrees by which the recorded image is turned clockwise."),
]
Viewpoint = Annotated[
    Literal["sensor", "object"],
    Field(description="From where directions are told: out of the sensor, or from the object."),
]
Actor = Annotated[
    Literal["object", "sensor"],
    Field(description="Whose motion is told: the object's, or the sensor's."),
]
Thread = Annotated[
    Literal["right", "left"] | None, Field(description="Handedness of a thread, if it has one.")
]
ContactSide = Annotated[
    Literal["head", "shank", "side"] | None,
    Field(description="Which side of a screw or cap touches the gel, if known."),
]
MmPerPx = Annotated[
    float | None,
    Field(
        description="Millimetres of gel that a pixel is wide; travel is told in pixels without.",
        ge=0.001,
        le=2.0,
    ),
]
Rows = Annotated[
    int,
    Field(
        description="Frames of which contact and motion are told, evenly spread; 0 for none.",
        ge=0,
        le=ROWS,
    ),
]
Picture = Annotated[
    Literal["overlay", "raw", "difference", "contact", "timeline"],
    Field(
        description="The four frames that were looked at, with the learned shear drawn in (overlay)"
        ", as recorded, against the idle gel, or with the contact mask; or turn, travel, contact "
        "and events of the whole track over time (timeline)."
    ),
]


def bounded(low: float, high: float, description: str) -> Any:
    """Return the type of a number between two bounds."""
    return Annotated[float, Field(description=description, ge=low, le=high)]


ObjectName = Annotated[
    str,
    Field(description='A shape, for example "key", "coin", "hex_nut".', max_length=NAME_CHARACTERS),
]
DepthMm = bounded(-1.0, 1.5, "Approach beyond first touch, half-way, mm; 0 or less: no contact.")
TwistDeg = bounded(-60.0, 60.0, "Turn in degrees, positive clockwise in the image.")
SlideXMm = bounded(-5.0, 5.0, "Travel to the right, mm.")
SlideYMm = bounded(-5.0, 5.0, "Travel down the image, mm.")
PressMm = bounded(-2.0, 2.0, "Approach into the gel from first to last frame, mm; negative lifts.")
ThicknessMm = bounded(1.0, 6.0, "Of the gel, mm.")
Seed = Annotated[int, Field(description="Of the noise.", ge=0, le=2**31 - 1)]


def frame_of(
    mirrored: bool = False,
    turned: int = 0,
    viewpoint: Any = "sensor",
    actor: Any = "object",
    thread: Any = None,
    contact_side: Any = None,
    mm_per_px: float | None = None,
) -> FrameSpec:
    """Return the frame of reference that a tool's facts stand for."""
    return FrameSpec(
        image_mirrored=mirrored,
        viewpoint=viewpoint,
        actor=actor,
        thread=thread,
        contact_side=contact_side,
        mm_per_px=mm_per_px,
        **FrameSpec.fields_of_turn(turned),
    )


def given_by(frame: FrameSpec) -> dict[str, Any]:
    """Return the parameters that stand for a frame; those that are as usual are left out."""
    quarter = {None: 0, "clockwise": 90, "counterclockwise": 270}[frame.image_quarter_turn]
    usual = FrameSpec()
    told = {
        "mirrored": (frame.image_mirrored, usual.image_mirrored),
        "turned": ((quarter + 180 * frame.image_upside_down) % 360, 0),
        "viewpoint": (frame.viewpoint, usual.viewpoint),
        "actor": (frame.actor, usual.actor),
        "thread": (frame.thread, usual.thread),
        "contact_side": (frame.contact_side, usual.contact_side),
        "mm_per_px": (frame.mm_per_px, usual.mm_per_px),
    }
    return {name: value for name, (value, as_usual) in told.items() if value != as_usual}
