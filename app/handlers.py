"""What the page's buttons do, as plain functions; knows nothing of the page's toolkit."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm import (
    FrameSpec,
    GeoTLMError,
    Motion,
    Seen,
    picture,
    read_clip,
    second_opinions,
    views_of,
)

if TYPE_CHECKING:
    from geotlm_lm import Answerer

Image = NDArray[np.uint8]

SUGGESTED_QUESTIONS = {
    "direction": "Which way is the object turning?",
    "yes or no": "Is it sliding to the left?",
    "choice": "A) clockwise B) counterclockwise C) still. Which one?",
    "kind of motion": "Is this a rotation, a slide, a press or nothing?",
    "contact": "Is anything touching the gel?",
    "moving at all": "Is it moving at all?",
    "not for touch": "What colour is it?",
}
"""One question of each type that the model was trained on."""

EXAMPLE_QUESTIONS = tuple(SUGGESTED_QUESTIONS.values())

DIRECTION_QUESTION = "Which way is it moving?"
AMOUNT_QUESTION = "How far did it go?"
"""Asked of both clips of a comparison, and of what was just simulated."""

NAMES_MOTION = ("direction", "viewpoint", "actor")
"""Kinds of question whose answer names the motion of the clip as its frame tells it."""

EXAMPLE_CLIPS = sorted(str(path) for path in (Path(__file__).parent / "examples").glob("*.npz"))


@dataclass(frozen=True, eq=False)
class Shown:
    """A clip that was read and perceived, ready for questions and pictures.

    `session` is the conversation about it, which remembers its turns and its frame of reference.
    """

    encoded: Any
    seen: Seen
    opinions: dict[str, Any]
    frames: list[tuple[Image, str]]
    notes: str
    session: Any

    @property
    def views(self) -> tuple[str, ...]:
        """The pictures that can be drawn of it."""
        return views_of(self.seen)


@dataclass(frozen=True)
class Reply:
    """One answer in the parts the page shows; `motion` is what it says in the camera image."""

    sentence: str
    motion: Motion | None
    probabilities: dict[str, float]
    details: dict[str, Any]
    band: str
    regions: list[list[Any]]
    verdicts: list[list[Any]]
    timing: str


def show_clip(
    answerer: Answerer,
    path: str | list[str] | None,
    first: float | None = None,
    last: float | None = None,
) -> Shown:
    """Read the recording at `path`, choose its frames, and perceive it once.

    Args:
        answerer: The model.
        path: Of the recording, or of several images of it; None when nothing was given yet.
        first: First frame to use; None to have the frames chosen.
        last: Last frame to use.

    Raises:
        GeoTLMError: If there is no recording, or it cannot be used, in one sentence.
    """
    if not path:
        raise GeoTLMError("No recording was given; upload a clip first.")
    if (first is None) != (last is None):
        raise GeoTLMError("Only one end of the span was given; give both frame numbers or none.")
    span = None if first is None else (int(first), int(last))
    return perceive(answerer, _read(path), span=span)


def perceive(
    answerer: Answerer,
    recording: Any,
    *,
    span: tuple[int, int] | None = None,
    depth_mm: NDArray[np.float32] | None = None,
) -> Shown:
    """Perceive a recording once, and draw and judge it by other means beside.

    Args:
        answerer: The model.
        recording: A `Clip` of two frames or more.
        span: First and last frame to use; None to have them chosen.
        depth_mm: True indentation of each frame, where it was simulated.
    """
    encoded = answerer.encode(recording, span=span)
    clip = encoded.clip
    geometry = encoded.perception.geometry
    field, mask = (np.asarray(x[0], np.float32) for x in (geometry.shear_change, geometry.mask))
    captions = [f"frame {number}" for number in clip.frame_numbers]
    return Shown(
        encoded=encoded,
        seen=Seen(clip.frames, clip.background, field, mask, encoded.view, depth_mm),
        opinions=second_opinions(answerer, encoded).to_dict(),
        frames=list(zip(clip.frames, captions, strict=True)),
        notes="\n".join(f"- {note}" for note in clip.notes),
        session=answerer.session(encoded),
    )


def draw(shown: Shown | None, view: str, number: float) -> Image | None:
    """Return one of the four frames, counted from 1, in the view asked for."""
    if shown is None:
        return None
    name = view if view in shown.views else "raw"
    index = min(max(int(number), 1), len(shown.seen.frames)) - 1
    return picture(shown.seen, name, index)


def ask(answerer: Answerer, shown: Shown | None, question: str) -> Reply:
    """Answer `question` about the clip that is shown, by itself, in the camera's frame.

    Raises:
        GeoTLMError: If there is no clip or no question, in one sentence.
    """
    shown = _open(shown)
    return _reply(answerer, shown, answerer.ask(shown.encoded, question))


def converse(
    answerer: Answerer, shown: Shown | None, question: str, facts: Mapping[str, Any]
) -> Iterator[str | Reply]:
    """Answer the next question of the conversation about the clip that is shown.

    Yields:
        The answer's words piece by piece, as they are generated, and last the reply.

    Args:
        answerer: The model.
        shown: The clip.
        question: What is asked, or a fact about the recording.
        facts: Fields of the `FrameSpec` that hold from now on.

    Raises:
        GeoTLMError: If there is no clip or no question, in one sentence.
    """
    shown = _open(shown)
    shown.session.frame = replace(shown.session.frame, **facts)
    for told in shown.session.stream(question):
        yield told if isinstance(told, str) else _reply(answerer, shown, told)


def _open(shown: Shown | None) -> Shown:
    if shown is None:
        raise GeoTLMError("No recording is open; upload a clip first.")
    return shown


def _reply(answerer: Answerer, shown: Shown, answer: Any) -> Reply:
    is_sure_of_something = not answer.abstained and answer.options
    told = f"  ({100 * answer.confidence:.0f} % sure)" if is_sure_of_something else ""
    told += "" if answer.lean is None else f" {answer.lean.text}"
    details = answer.to_dict()
    timing = details.get("timing_ms", {}) | shown.opinions["timing_ms"]
    return Reply(
        sentence=answer.text + told,
        motion=_in_the_image(answer),
        probabilities=dict(answer.options),
        details=details | {"second_opinions": shown.opinions},
        band=_band(answerer, details),
        regions=region_rows(details.get("evidence", {})),
        verdicts=_verdicts(answer.text, details, shown.opinions),
        timing=" · ".join(f"{name} {value:.1f} ms" for name, value in timing.items()),
    )


def _in_the_image(answer: Any) -> Motion | None:
    """Return the motion an answer names, as the camera image shows it."""
    if answer.direction is None or answer.kind not in NAMES_MOTION:
        return None
    return answer.frame.in_the_image(answer.direction)


def compare(answerer: Answerer, first: Shown | None, second: Shown | None) -> dict[str, Any]:
    """Answer about both clips and compare their directions.

    Returns:
        Both answers under "first" and "second", "relation", and "text", the sentence.

    Raises:
        GeoTLMError: If a clip is missing.
    """
    if first is None or second is None:
        raise GeoTLMError("A comparison needs two recordings; upload both.")
    return answerer.compare(first.encoded, second.encoded).to_dict()


def told_in(frame: FrameSpec, direction: Any) -> str:
    """Return the last direction as another frame of reference names it.

    Args:
        frame: The frame the reader wants.
        direction: The motion in the camera image; None when none was told.
    """
    if direction is None:
        return f"Frame: {frame.sentence()}."
    return f"In this frame ({frame.sentence()}) that is **{frame.tell(direction).value}**."


def region_rows(evidence: dict[str, Any]) -> list[list[Any]]:
    """Return name, shear change (x right, y down) and contact mass of each region."""
    return [
        [
            name.replace("_", " "),
            values["shear_change_x"],
            values["shear_change_y"],
            values["contact_mass"],
        ]
        for name, values in evidence.get("regions", {}).items()
    ]


def _verdicts(text: str, details: dict[str, Any], opinions: dict[str, Any]) -> list[list[Any]]:
    probe, flow = opinions["probe"], opinions["optical_flow"]
    said = details.get("direction") or "-"
    moved = (
        f"{flow['rotation_deg']:+.1f} degrees, {flow['slide_x_px']:+.1f} px right, "
        f"{flow['slide_y_px']:+.1f} px down"
    )
    return [
        ["language model", said, text],
        ["linear probe", probe["motion"], f"{100 * probe['probability']:.0f} % (not calibrated)"],
        ["optical flow", flow["motion"], moved],
    ]


def _band(answerer: Answerer, details: dict[str, Any]) -> str:
    """Return from where on an answer is told, and where this one stands."""
    from geotlm_lm import LEAST_SURE

    threshold = answerer.bundle.calibration.contact_threshold
    share = details.get("evidence", {}).get("contact_share", 0.0)
    side = "withheld" if details.get("abstained") else "told"
    return (
        f"Contact share {share:.3f}; below {threshold:.3f} no direction is claimed, and no motion, "
        f"verdict or choice that is less than {LEAST_SURE:.0%} sure, nor that nothing touches a "
        f"gel that has changed: this answer is **{side}**."
    )


def _read(path: str | list[str]) -> Any:
    """Return the recording in one file, or in several images."""
    paths = [path] if isinstance(path, str) else list(path)
    if len(paths) == 1:
        return _read_one(paths[0], hidden=f"{Path(paths[0]).parent}/")
    with tempfile.TemporaryDirectory() as folder:
        for one in paths:
            shutil.copy(one, Path(folder) / Path(one).name)
        return _read_one(folder, hidden=f"{folder}/")


def _read_one(path: str, *, hidden: str) -> Any:
    try:
        return read_clip(path)
    except GeoTLMError as error:
        # Uploads lie in a temporary folder whose name means nothing to the person who uploaded.
        raise type(error)(str(error).replace(hidden, "")) from error
