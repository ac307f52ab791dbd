"""What the page's buttons do, as plain functions; knows nothing of the page's toolkit."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm import Answerer, GeoTLMError, read_clip

Image = NDArray[np.uint8]

EXAMPLE_QUESTIONS = (
    "Which way is the object turning?",
    "Is it sliding to the left?",
    "Is anything touching the gel?",
    "Is it moving at all?",
)

ARROW_COLOUR = (255, 220, 0)
LONGEST_ARROW_PATCHES = 1.2
"""Length of the longest arrow; the shear change is unitless, only its pattern means something."""

FAINTEST_ARROW = 0.05
"""Arrows below this share of the longest are left out."""


@dataclass(frozen=True, eq=False)
class Shown:
    """A clip that was read and perceived, ready for questions."""

    encoded: Any
    frames: list[tuple[Image, str]]
    arrows: Image
    notes: str


@dataclass(frozen=True)
class Reply:
    """One answer in the parts the page shows."""

    sentence: str
    probabilities: dict[str, float]
    details: dict[str, Any]


def show_clip(
    answerer: Answerer, path: str | None, first: float | None, last: float | None
) -> Shown:
    """Read the recording at `path`, choose its frames, and perceive it once.

    Args:
        answerer: The model.
        path: Of the recording; None when nothing was given yet.
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
    try:
        recording = read_clip(path)
    except GeoTLMError as error:
        # Uploads lie in a temporary folder whose name means nothing to the person who uploaded.
        raise type(error)(str(error).replace(f"{Path(path).parent}/", "")) from error
    encoded = answerer.encode(recording, span=span)
    clip = encoded.clip
    captions = [f"frame {number}" for number in clip.frame_numbers]
    return Shown(
        encoded=encoded,
        frames=list(zip(clip.frames, captions, strict=True)),
        arrows=draw_arrows(_seen(encoded), *_field(encoded)),
        notes="\n".join(f"- {note}" for note in clip.notes),
    )


def ask(answerer: Answerer, shown: Shown | None, question: str) -> Reply:
    """Answer `question` about the clip that is shown.

    Raises:
        GeoTLMError: If there is no clip or no question, in one sentence.
    """
    if shown is None:
        raise GeoTLMError("No recording is open; upload a clip first.")
    answer = answerer.ask(shown.encoded, question)
    told = (
        ""
        if answer.abstained or not answer.options
        else f"  ({100 * answer.confidence:.0f} % sure)"
    )
    return Reply(answer.text + told, dict(answer.options), answer.to_dict())


def draw_arrows(frame: Image, field: NDArray[np.float32], mask: NDArray[np.float32]) -> Image:
    """Draw the shear change over a frame, each arrow weighted by the contact mask.

    Args:
        frame: uint8, shape (rows, columns, 3).
        field: Shear change (x right, y down), shape (gh, gw, 2), unitless.
        mask: Contact mask, shape (gh, gw), in [0, 1].

    Returns:
        uint8, shape (2 rows, 2 columns, 3).
    """
    image = cv2.resize(frame, None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC)
    weighted = field * mask[..., None]
    lengths = np.linalg.norm(weighted, axis=-1)
    longest = float(lengths.max())
    if longest == 0:
        return image
    cell = np.array([image.shape[1] / field.shape[1], image.shape[0] / field.shape[0]])
    for row, column in np.argwhere(lengths > FAINTEST_ARROW * longest):
        tail = (np.array([column, row]) + 0.5) * cell
        tip = tail + weighted[row, column] / longest * LONGEST_ARROW_PATCHES * cell
        ends = [tuple(int(v) for v in np.rint(end)) for end in (tail, tip)]
        cv2.arrowedLine(image, *ends, ARROW_COLOUR, 2, cv2.LINE_AA, tipLength=0.3)
    return image


def _seen(encoded: Any) -> Image:
    """Return the part of the last frame that the model's grid covers."""
    return encoded.view.cut(cv2.resize(encoded.clip.frames[-1], (IMAGE_SIDE, IMAGE_SIDE)))


IMAGE_SIDE = 224
"""Pixels per side of the square image that views are told in."""


def _field(encoded: Any) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    geometry = encoded.perception.geometry
    return tuple(np.asarray(part[0], np.float32) for part in (geometry.shear_change, geometry.mask))
