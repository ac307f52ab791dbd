"""The stage: what the browser plays of a recording, draws over it, and shows below it over time.

Gathers plain values, which `stage.js` and `timeline.js` draw. Pictures travel inside the values, so
that none lies on the disk.
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
    COMPONENTS,
    FRAME_COUNT,
    SPAN_DEVIATIONS,
    Clip,
    Drawing,
    Seen,
    Units,
    arrow_ends,
    camera_size,
    draw_depth,
    drawing_of,
)

from .toolkit import html

if TYPE_CHECKING:
    from geotlm_lm import FrameSpec

    from .clips import LoadedClip

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

MOST_POINTS = 1000
"""Of a curve; a longer one is thinned, its ends stay."""

DEGREE = "°"

OPEN_ONE = "Open an example below, or drop a recording there: it plays here."


def build(value: dict[str, Any] | None = None, invites: str = OPEN_ONE) -> Any:
    """Return the component, which shows a value of `stage_of`, `opening` or `LiveStream.stage`.

    What invites stands where the picture will be.
    """
    names = ("stage.html", "draw.js", "timeline.js", "stage.js")
    template, *scripts = (Path(__file__).with_name(name).read_text("utf-8") for name in names)
    # The template is static: what stands in it would be run as a program.
    template = template.replace("INVITES", invites)
    return html(value or {}, template, "stage-block", "\n".join(scripts))


def stage_of(
    shown: LoadedClip, name: str, frame: FrameSpec | None = None, fields: Sequence[dict] = ()
) -> dict[str, Any]:
    """Return what the stage shows of a clip that was perceived, as plain JSON values.

    Of the frame of reference it needs the size of a pixel; `fields` of `field_of` are drawn beside
    the learned one.
    """
    encoded = shown.encoded
    mm_per_px = None if frame is None else frame.mm_per_px
    clip = encoded.clip if encoded.track is None else encoded.recording
    if encoded.track is not None:
        first, last = encoded.track.numbers[0], encoded.track.numbers[-1]
        numbers = enumerate(clip.frame_numbers)
        clip = clip.select([k for k, number in numbers if first <= number <= last])
    values = opening(clip, name) | {"pending": False}
    units = Units(clip.frames.shape[1:3], mm_per_px)
    if encoded.track is None:
        values["step"] = step_of(shown, units)
    else:
        values["timeline"] = timeline_of(drawing_of(encoded.track, units), values["unit"])
    looked_at = encoded.clip.frame_numbers
    when = "" if encoded.track is None else f" in frames {looked_at[0]} to {looked_at[-1]}"
    values["overlays"] = _overlays(shown.seen, when)
    values["overlays"]["fields"] += fields
    return values


def field_of(seen: Seen, key: str, label: str, colour: str) -> dict[str, Any]:
    """Return arrows over the picture, with the length of the one in the legend."""
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


def opening(clip: Clip, name: str) -> dict[str, Any]:
    """Return what the stage shows of a recording before the model has looked at it."""
    places = np.linspace(0, len(clip) - 1, min(len(clip), MOST_FRAMES)).round().astype(int)
    kept = clip.select(places.tolist())
    rows, columns = camera_size(*clip.frames.shape[1:3])
    numbers = np.array(kept.frame_numbers)
    seconds = np.array([kept.second_of(int(number), ASSUMED_HZ) for number in numbers])
    is_short = len(clip) <= FRAME_COUNT
    unit = "s" if kept.is_timed and not is_short else "frame"
    span_s = float(seconds[-1] - seconds[0])
    rate = SHORT_HZ if is_short or span_s <= 0 else (len(kept) - 1) / span_s
    idle = [] if clip.background is None else [clip.background]
    pictures, side = _encoded([*kept.frames, *idle])
    is_timed = clip.is_timed and not is_short
    return {
        "key": secrets.token_hex(4),
        "name": name,
        "about": f"{span_s:.1f} s, {len(clip)} frames" if is_timed else f"{len(clip)} frames",
        "aspect": columns / rows,
        "frames": pictures[: len(kept)],
        "idle": pictures[-1] if idle else None,
        "side": side,
        "numbers": numbers.tolist(),
        "x": _rounded(seconds if unit == "s" else numbers),
        "unit": unit,
        "rate": round(rate, 3),
        "loops": is_short,
        "pending": True,
    }


def _encoded(images: list[NDArray[np.uint8]]) -> tuple[list[str], int]:
    """Return pictures as data addresses, as good as the budget allows, and their longer side."""
    sample = [images[k] for k in np.linspace(0, len(images) - 1, SAMPLED).round().astype(int)]
    for side, quality in QUALITIES:
        size = sum(len(_jpeg(image, side, quality)) for image in sample) / len(sample)
        if size * len(images) <= BUDGET_BYTES:
            break
    return [jpeg_address(image, side, quality) for image in images], side


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
        drawn = (draw_depth(depth, depth.shape, deepest) for depth in seen.depth_mm)
        overlays["depth"] = [_png_address(image) for image in drawn]
        overlays["deepest_mm"] = round(deepest, 2)
    return overlays


def _png_address(image: NDArray[np.uint8]) -> str:
    png = cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))[1].tobytes()
    return _address(png, "png")


def timeline_of(drawing: Drawing, unit: str, since_s: float = -np.inf) -> dict[str, Any]:
    """Return the curves of a track with the spans that hold nine tenths, and its events.

    The axis is in "s", or "frame" where the times are not known. The way is that since the track's
    own begin, whatever `since_s`.
    """
    places = np.flatnonzero(drawing.times_s >= since_s)
    if len(places) > MOST_POINTS:
        places = places[np.linspace(0, len(places) - 1, MOST_POINTS).round().astype(int)]
    travel = drawing.units.name
    panels = [
        {"name": "turn", "unit": DEGREE, "told": "turn, clockwise up"},
        {"name": "travel", "unit": travel, "told": f"travel in {travel}: right, dashed: down"},
        {"name": "contact", "unit": "", "range": [0, 1], "told": "contact"},
    ]
    for panel in panels:
        curves = (curve for curve in drawing.curves if curve.panel == panel["name"])
        panel["curves"] = [_curve(curve, places) for curve in curves]
    return {
        "x": _rounded((drawing.times_s if unit == "s" else drawing.numbers)[places]),
        "panels": panels,
        "events": [_event(band, unit) for band in drawing.bands if band.event.end_s >= since_s],
        # The way in shares of the picture, drawn as long as it is.
        "way": _rounded(drawing.arrows[places]),
    }


def step_of(shown: LoadedClip, units: Units) -> dict[str, Any]:
    """Return what is believed of a short clip: each component's way and amount, from end to end."""
    from geotlm_lm import LEAST_SURE  # with the model's libraries

    belief = shown.encoded.belief
    if not shown.seen.has_contact or belief.contact < LEAST_SURE:
        return {"rows": [], "told": "No contact is seen: no motion is claimed."}
    return {"rows": [_row(belief, part, units) for part in COMPONENTS], "told": ""}


def _row(belief: Any, component: Any, units: Units) -> dict[str, Any]:
    from geotlm_lm import LEAST_SURE

    moves = belief.moves(component)
    row = {"name": component.value, "moves": moves >= LEAST_SURE}
    unit, factor = _unit_of(belief, component, units)
    if not belief.readable.get(component, True):
        return row | {"moves": False, "text": "cannot be told from these pictures"}
    if not row["moves"]:
        unseen = _unseen(belief, component, unit, factor)
        return row | {"text": f"{unseen}{100 * (1 - moves):.0f} % sure"}
    way = belief.way(component)
    share = belief.share(way, component)
    if share < LEAST_SURE:
        return row | {"text": "yes, but not which way"}
    mean = factor * belief.amount(component)
    spread = factor * SPAN_DEVIATIONS * belief.deviation(component)
    far = _far(mean, mean - spread, mean + spread, unit)
    return row | {"text": f"{way.value} {far}, {100 * moves * share:.0f} % sure"}


def _unseen(belief: Any, component: Any, unit: str, factor: float) -> str:
    """Return that a component is not seen to move, and up to which amount that is so."""
    if component not in belief.limits:
        return "none, "
    limit = factor * belief.at_limit.amount(component)
    return f"none beyond {limit:.2g}{'' if unit == DEGREE else ' '}{unit}, "


def _unit_of(belief: Any, component: Any, units: Units) -> tuple[str, float]:
    """Return the unit of a component, and what belief's own is of it along the way."""
    if component.value != "slide":
        return {"turn": DEGREE, "press": "mm"}[component.value], 1.0
    way = belief.mean.right_px, belief.mean.down_px
    length = float(np.hypot(*way))
    scaled = float(np.hypot(*units.travelled(*way)))
    return units.name, scaled / length if length else units.travel[1][0]


def _event(band: Any, axis_unit: str) -> dict[str, Any]:
    event, unit = band.event, DEGREE if band.unit == "deg" else band.unit
    is_timed = axis_unit == "s"
    return {
        "kind": event.kind.value,
        "name": band.name,
        "begin": round(float(event.begin_s if is_timed else event.begin), 4),
        "end": round(float(event.end_s if is_timed else event.end), 4),
        "far": _far(band.amount, band.low, band.high, unit) if unit else "",
        "sure": round(100 * event.probability),
    }


def _far(mean: float, low: float, high: float, unit: str) -> str:
    gap = "" if unit == DEGREE else " "
    middle, least, most = (
        f"{value:.2g}" if abs(value) < 100 else f"{value:.0f}"
        for value in (mean, max(low, 0.0), high)
    )
    return f"{middle}{gap}{unit} ({least} to {most})"


def _curve(curve: Any, places: NDArray) -> dict[str, Any]:
    plain = {"name": curve.name, "mean": _rounded(curve.mean[places], 3)}
    return plain if curve.spread is None else plain | {"spread": _rounded(curve.spread[places], 3)}


def _rounded(values: Any, digits: int = 4) -> list:
    return np.asarray(values, float).round(digits).tolist()
