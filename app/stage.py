"""The stage: what the browser plays of a recording, draws over it, and shows below it over time.

Gathers plain values; `stage.js` draws them. Pictures travel inside the values, so that none lies on
the disk.
"""

from __future__ import annotations

import base64
import secrets
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm import (
    FRAME_COUNT,
    Clip,
    Seen,
    Units,
    arrow_ends,
    camera_size,
    draw_depth,
    drawing_of,
)

from .error_display import gradio
from .timeline import Axis, step_of, timeline_of

if TYPE_CHECKING:
    from geotlm_lm import FrameSpec

    from .clip_loading import LoadedClip

MOST_FRAMES = 300
"""Of a recording that are sent; of a longer one every second, third, ..."""

BUDGET_BYTES = 2_100_000
"""Of all pictures together; in base64, as they travel, it is a third more."""

QUALITIES = ((448, 88), (448, 75), (320, 75), (320, 60), (224, 60), (224, 40), (160, 40))
"""Longer side (pixels) and JPEG quality, the best first; the first that fits is used."""

SAMPLED = 6
"""Frames that are tried to see how many bytes a quality takes."""

SHORT_HZ, ASSUMED_HZ = 10.0, 25.0
"""Rate that a clip of four frames is played at, and a recording that does not tell its own."""

_HERE = Path(__file__).parent
_SCRIPTS = ("stage_draw.js", "stage_timeline.js", "stage_live.js", "stage.js", "stage_input.js")


OPEN_ONE = "Open an example below, or drop a recording there: it plays here."


def build(value: dict[str, Any] | None = None, invites: str = OPEN_ONE) -> Any:
    """Return the component.

    Args:
        value: What it shows first, as `stage_of`, `opening` or `LiveStream.stage` returns it; None
            for nothing.
        invites: What stands where the picture will be.
    """
    # The template is static: what stands in it would be run as a program.
    return gradio().HTML(
        value or {},
        html_template=(_HERE / "stage.html").read_text("utf-8").replace("INVITES", invites),
        css_template="",
        js_on_load="\n".join((_HERE / name).read_text("utf-8") for name in _SCRIPTS),
        apply_default_css=False,
        elem_classes=["stage-block"],
    )


def stage_of(
    shown: LoadedClip, name: str, frame: FrameSpec | None = None, fields: Sequence[dict] = ()
) -> dict[str, Any]:
    """Return what the stage shows of a clip that was perceived, as plain JSON values.

    Args:
        shown: The clip.
        name: As it is called on the page.
        frame: What is known of its frame of reference: the size of a pixel.
        fields: Arrows to draw beside the learned ones, as of `field_of`.
    """
    encoded = shown.encoded
    mm_per_px = None if frame is None else frame.mm_per_px
    clip = encoded.clip if encoded.track is None else encoded.recording
    if encoded.track is not None:
        first, last = encoded.track.numbers[0], encoded.track.numbers[-1]
        numbers = enumerate(clip.frame_numbers)
        clip = clip.select([k for k, number in numbers if first <= number <= last])
    told, axis = _frames_of(clip, name)
    units = Units(clip.frames.shape[1:3], mm_per_px)
    if encoded.track is None:
        told["step"] = step_of(shown, units)
    else:
        told["timeline"] = timeline_of(drawing_of(encoded.track, units), axis)
    looked_at = encoded.clip.frame_numbers
    when = "" if encoded.track is None else f" in frames {looked_at[0]} to {looked_at[-1]}"
    told["overlays"] = _overlays(shown.seen, when)
    told["overlays"]["fields"] += fields
    return told


def opening(clip: Clip, name: str) -> dict[str, Any]:
    """Return what the stage shows of a recording before the model has looked at it."""
    return _frames_of(clip, name)[0] | {"pending": True}


def field_of(seen: Seen, key: str, label: str, colour: str) -> dict[str, Any]:
    """Return arrows over the picture, with the length of the one in the legend.

    Args:
        seen: Whose field is drawn.
        key: Name that the page knows them by.
        label: What the legend says they are.
        colour: Of CSS.
    """
    scale, view = seen.scale, seen.view
    ends = arrow_ends(seen.shear_change, seen.mask, view, scale) if seen.has_contact else []
    known = np.array([[[scale.shown, 0.0]]], np.float32)
    ((tail, tip),) = arrow_ends(known, np.ones((1, 1), np.float32), view, scale)
    return {
        "key": key,
        "label": label,
        "colour": colour,
        "ends": _rounded(ends),
        "legend": {
            "length": float(tip[0] - tail[0]),
            "text": f"{scale.shown:g} {scale.name}",
        },
    }


def _frames_of(clip: Clip, name: str) -> tuple[dict[str, Any], Axis]:
    places = np.linspace(0, len(clip) - 1, min(len(clip), MOST_FRAMES)).round().astype(int)
    kept = clip.select(places.tolist())
    rows, columns = camera_size(*clip.frames.shape[1:3])
    axis = Axis(kept.is_timed and len(clip) > FRAME_COUNT)
    numbers = np.array(kept.frame_numbers)
    seconds = np.array([kept.second_of(int(one), ASSUMED_HZ) for one in numbers])
    is_short = len(clip) <= FRAME_COUNT
    span = float(seconds[-1] - seconds[0])
    rate = SHORT_HZ if is_short or span <= 0 else (len(kept) - 1) / span
    idle = [] if clip.background is None else [clip.background]
    pictures, side = _encoded([*kept.frames, *idle])
    told = {
        "key": secrets.token_hex(4),
        "name": name,
        "about": _about(clip, span),
        "aspect": columns / rows,
        "frames": pictures[: len(kept)],
        "idle": pictures[-1] if idle else None,
        "side": side,
        "numbers": numbers.tolist(),
        "x": _rounded(axis.of(numbers, seconds)),
        "unit": axis.unit,
        "rate": round(rate, 3),
        "loops": is_short,
    }
    return told, axis


def _about(clip: Clip, span_s: float) -> str:
    if len(clip) <= FRAME_COUNT or not clip.is_timed:
        return f"{len(clip)} frames"
    return f"{span_s:.1f} s, {len(clip)} frames"


def _encoded(images: list[NDArray[np.uint8]]) -> tuple[list[str], int]:
    """Return pictures as data addresses, as good as the budget allows, and their longer side."""
    sample = [images[k] for k in np.linspace(0, len(images) - 1, SAMPLED).round().astype(int)]
    for side, quality in QUALITIES:
        size = sum(len(_jpeg(one, side, quality)) for one in sample) / len(sample)
        if size * len(images) <= BUDGET_BYTES:
            break
    return [jpeg_address(one, side, quality) for one in images], side


def _jpeg(image: NDArray[np.uint8], side: int, quality: int) -> bytes:
    scale = side / max(image.shape[:2])
    if scale < 1:
        size = (round(image.shape[1] * scale), round(image.shape[0] * scale))
        image = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    options = [cv2.IMWRITE_JPEG_QUALITY, quality]
    return cv2.imencode(".jpg", cv2.cvtColor(image, cv2.COLOR_RGB2BGR), options)[1].tobytes()


def jpeg_address(image: NDArray[np.uint8], side: int, quality: int) -> str:
    """Return a picture as a data address, made smaller where its longer side is beyond `side`."""
    return _address(_jpeg(image, side, quality), "jpeg")


def _address(content: bytes, kind: str) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(content).decode()}"


def _overlays(seen: Seen, when: str) -> dict[str, Any]:
    corners = seen.view.in_picture(np.array([[0.0, 0.0], [1.0, 1.0]]))
    overlays: dict[str, Any] = {
        "contact": {
            "mask": _rounded(seen.mask, 2),
            "corners": _rounded(corners),
            "told": f"red: where it touches{when}",
        },
        "fields": [field_of(seen, "belief", "what the model reads", "#ffdc00")],
    }
    if seen.depth_mm is not None:
        deepest = float(seen.depth_mm.max())
        overlays["depth"] = [
            _address(_png(draw_depth(one, one.shape, deepest)), "png") for one in seen.depth_mm
        ]
        overlays["deepest_mm"] = round(deepest, 2)
    return overlays


def _png(image: NDArray[np.uint8]) -> bytes:
    return cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))[1].tobytes()


def _rounded(values: Any, digits: int = 4) -> list:
    return np.asarray(values, float).round(digits).tolist()
