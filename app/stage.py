"""The stage: what the browser plays of a recording, draws over it, and shows below it over time.

Gathers plain values, which `stage.js` and `timeline.js` draw. Pictures are fetched by address, the
frames of a recording in one pack: a value of the page is copied several times on its way, and
frames in it held the browser up for seconds.
"""

from __future__ import annotations

import base64
import hashlib
import secrets
import struct
import time
from collections import OrderedDict
from collections.abc import Sequence
from pathlib import Path
from threading import Lock
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from starlette.responses import Response

import geotlm_lm as lm

from .clips import Image, LoadedClip
from .guards import MIB
from .toolkit import html

MOST_FRAMES = 300
"""Of a recording that are sent; of a longer one every second, third, ..."""

SHORT_HZ, ASSUMED_HZ = 10.0, 25.0
"""Rate that a clip of four frames is played at, and a recording that does not tell its own."""

GROWS_EVERY_S = 1.0
"""After which the timeline of a recording that is being tracked is drawn anew."""

MOST_POINTS = 1000
"""Of a curve; a longer one is thinned, its ends stay."""

DEGREE = "°"

LANES = {
    "contact": ("touch", "press", "release"),
    "turn": ("turn",),
    "slide": ("slide",),
    "rest": ("stick",),
}
"""Rows of the timeline, and the kinds of events in each."""

OF_MOTION = "Which way is it moving?"

FINE, LEAST_SHARE = 8, 0.004
"""Outlines are drawn on a mask that is so many times finer, around what fills so much of it."""

OPEN_ONE = "Open one of the examples, or drop your own recording here."

COMPARE = '<button type="button" data-event="expand">Compare</button>'

CLOSE = '<button type="button" data-event="collapse" aria-label="Close the second">✕</button>'

ROUTE = "frames"
"""Where packs are served, below the page's address."""

BUDGET_BYTES = 2_800_000
"""Of all pictures of a recording together."""

QUALITIES = ((448, 88), (448, 75), (320, 75), (320, 60), (224, 60), (224, 40), (160, 40))
"""Longer side (pixels) and JPEG quality, the best first; the first that fits is used."""

SAMPLED = 6
"""Frames that are tried to see how many bytes a quality takes."""

KEPT_BYTES = 128 * MIB
"""Of all packs; the browser has fetched what is let go of, or asks for it once more and is told."""


def build(invites: str = OPEN_ONE, actions: str = "", name: str = "stage-block") -> Any:
    """Return the component, which shows a value of `stage_of`, `opening` or `LiveStream.stage`.

    What invites stands where the picture will be, actions beside the title.
    """
    names = ("stage.html", "draw.js", "timeline.js", "stage.js")
    template, *scripts = (Path(__file__).with_name(name).read_text("utf-8") for name in names)
    # The template is static: what stands in it would be run as a program.
    template = template.replace("INVITES", invites).replace("ACTIONS", actions)
    return html({}, template, name, "\n".join(scripts))


def stage_of(
    shown: LoadedClip, name: str, mm_per_px: float | None = None, truth: lm.Seen | None = None
) -> dict[str, Any]:
    """Return what the stage shows of a clip that was perceived, as plain JSON values.

    Lengths are in mm where the size of a pixel is given. The true motion is drawn beside the one
    that is read.
    """
    encoded, seen = shown.encoded, shown.seen
    clip = encoded.clip if encoded.track is None else encoded.recording
    if encoded.track is not None:
        first, last = encoded.track.numbers[0], encoded.track.numbers[-1]
        numbers = enumerate(clip.frame_numbers)
        clip = clip.select([k for k, number in numbers if first <= number <= last])
    depth = []
    if seen.depth_mm is not None:
        deepest = float(seen.depth_mm.max())
        depth = [lm.draw_depth(image, image.shape, deepest) for image in seen.depth_mm]
    values = opening(clip, name, depth) | {"pending": False, "notes": [*shown.source.notes]}
    units = lm.Units(clip.frames.shape[1:3], mm_per_px)
    if depth:
        values["deepest_mm"] = round(deepest, 2)
    if encoded.track is not None:
        values["timeline"] = timeline_of(encoded.track, units, values["unit"])
        values["outlines"] = _outlines(_sent(clip), encoded.track)
        return values
    moved = motion_of(shown, lm.FrameSpec(mm_per_px=mm_per_px))
    values["step"] = step_of(moved, shown)
    has_contact = bool(values["step"]["rows"])
    changes = [lm.change_map(image, seen.idle) for image in seen.frames] if has_contact else []
    values["outlines"] = [outline(change) for change in changes]
    values["motion"] = _told_motion(moved, shown) if has_contact else None
    if truth is not None:
        ends = lm.arrow_ends(truth.shear_change, truth.mask, truth.view, lm.TRUE_DISPLACEMENT)
        values["truth"] = _rounded(ends if truth.has_contact else [])
    values["shear"] = _rounded(
        lm.arrow_ends(seen.shear_change, seen.mask, seen.view, seen.scale) if has_contact else []
    )
    return values


def stages_of(shown: LoadedClip) -> dict[str, Any]:
    """Return what the stage shows of a recording, and a second one of what it is compared with.

    Both are then drawn on the same scale of time and of amounts.
    """
    mm_per_px = shown.session.frame.mm_per_px
    first = stage_of(shown, shown.source.name, mm_per_px)
    if shown.second is None:
        return {"stage": first}
    second = stage_of(shown.second, shown.second.source.name, mm_per_px)
    first["about"] = f"first · {first['about']}"
    second["about"] = f"second, “it” in a question · {second['about']}"
    for values in (first, second):
        values["scale"] = _scale_of(first, second)
    return {"stage": first, "stage_second": second}


def _scale_of(*stages: dict[str, Any]) -> dict[str, list[float]]:
    """Return the lowest and highest value of what is drawn, by the names of rows, and of time."""
    ends: dict[str, list[float]] = {}
    for values in stages:
        for lane in values.get("timeline", {"lanes": []})["lanes"]:
            for curve in lane["curves"]:
                mean, spread = (np.asarray(curve.get(key, 0.0)) for key in ("mean", "spread"))
                mean = -mean if curve["name"] == "down" else mean  # what goes up is drawn upwards
                drawn = ends.setdefault(
                    lane["name"], [-(lane["limit"] or 0.0), lane["limit"] or 0.0]
                )
                drawn += [(mean - spread).min(), (mean + spread).max()]
        for row in values.get("step", {"rows": []})["rows"]:
            ends.setdefault(row["name"], []).append(row.get("high", 0.0))
    if len({values["unit"] for values in stages}) == 1:
        ends["x"] = [end for values in stages for end in (values["x"][0], values["x"][-1])]
    return {name: [float(min(each)), float(max(each))] for name, each in ends.items()}


def opening(clip: lm.Clip, name: str, depth: Sequence[NDArray[np.uint8]] = ()) -> dict[str, Any]:
    """Return what the stage shows of a recording before the model has looked at it."""
    kept = _sent(clip)
    rows, columns = lm.camera_size(*clip.frames.shape[1:3])
    numbers = np.array(kept.frame_numbers)
    seconds = np.array([kept.second_of(int(number), ASSUMED_HZ) for number in numbers])
    is_short = len(clip) <= lm.FRAME_COUNT
    unit = "s" if kept.is_timed and not is_short else "frame"
    span_s = float(seconds[-1] - seconds[0])
    rate = SHORT_HZ if is_short or span_s <= 0 else (len(kept) - 1) / span_s
    idle = [] if clip.background is None else [clip.background]
    is_timed = clip.is_timed and not is_short
    return {
        "pack": PACKS.address([*kept.frames, *idle, *depth]),
        "name": name,
        "about": f"{span_s:.1f} s, {len(clip)} frames" if is_timed else f"{len(clip)} frames",
        "aspect": columns / rows,
        "count": len(kept),
        "has_idle": bool(idle),
        "numbers": numbers.tolist(),
        "x": _rounded(seconds if unit == "s" else numbers),
        "unit": unit,
        "rate": round(rate, 3),
        "loops": is_short,
        "pending": True,
    }


def _sent(clip: lm.Clip) -> lm.Clip:
    places = np.linspace(0, len(clip) - 1, min(len(clip), MOST_FRAMES)).round().astype(int)
    return clip.select(places.tolist())


def outline(mask: NDArray[np.floating]) -> list[list[list[float]]]:
    """Return polygons around where a mask of the picture is above one half, in shares of it."""
    fine = cv2.resize(np.float32(mask), None, fx=FINE, fy=FINE, interpolation=cv2.INTER_CUBIC)
    fine = cv2.GaussianBlur(fine, (0, 0), FINE / 3)
    inside = np.pad((fine > 0.5).astype(np.uint8), 1)  # closed at the picture's border
    rings, _ = cv2.findContours(inside, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    size = np.array(fine.shape[::-1])
    polygons = []
    for ring in rings:
        if cv2.contourArea(ring) >= LEAST_SHARE * fine.size:
            points = (cv2.approxPolyDP(ring, 0.6, True)[:, 0] - 0.5) / size
            polygons.append(_rounded(np.clip(points, 0, 1), 3))
    return polygons


def _outlines(clip: lm.Clip, track: Any) -> list[list]:
    """Return where each frame of a recording differs from the idle gel while it is touched."""
    if clip.background is None:
        return [[]]
    touched = np.interp(clip.frame_numbers, track.numbers, track.is_touched) >= 0.5
    return [
        outline(lm.change_map(frame, clip.background)) if is_touched else []
        for frame, is_touched in zip(clip.frames, touched, strict=True)
    ]


def motion_of(shown: LoadedClip, frame: lm.FrameSpec) -> tuple[Any, ...]:
    """Return how a clip moves as its words tell it, the largest motion first: asked aside."""
    session = shown.session.answerer.session(shown.encoded, frame=frame)
    return getattr(session.ask(OF_MOTION).values[0], "movements", ())


def step_of(moved: Sequence[Any], shown: LoadedClip) -> dict[str, Any]:
    """Return each component of a short clip's motion, from end to end, and its detection limit."""
    belief = shown.encoded.belief
    if not shown.seen.has_contact or belief.contact < lm.LEAST_SURE:
        return {"rows": [], "text": "No contact is seen: no motion is claimed."}
    movements = {movement.component: movement for movement in moved}
    rows = {part: _row(belief, part, movements.get(part)) for part in lm.COMPONENTS}
    text = rows[moved[0].component]["text"] if moved else "does not move"
    return {"rows": list(rows.values()), "text": text}


def _row(belief: Any, component: Any, movement: Any) -> dict[str, Any]:
    row = {"name": component.value, "moves": movement is not None}
    if movement is None:
        limit = "" if component not in belief.limits else _limit(belief, component)
        is_readable = belief.readable.get(component, True)
        return row | {"text": f"none{limit}" if is_readable else "not visible in these pictures"}
    way, sure = lm.way_phrase(movement), round(100 * movement.chance)
    if movement.amount is None:
        return row | {"text": way, "sure": sure}
    measured = movement.amount
    unit = DEGREE if measured.unit == "deg" else f" {measured.unit}"
    low, high = measured.span
    span = {"mean": measured.mean, "low": low, "high": high}
    far = f"{measured.value:g}{unit}"
    text = f"{far} {way}" if component.value == "slide" else f"{way} {far}"
    text = f"{text}, {low:g} to {high:g}{unit}"
    return row | {"text": text, "sure": sure} | {name: float(span[name]) for name in span}


def _limit(belief: Any, component: Any) -> str:
    unit = {"turn": DEGREE, "slide": " px", "press": " mm"}[component.value]
    return f" beyond {lm.figure_of(belief.at_limit.amount(component))}{unit}"


def _told_motion(moved: Sequence[Any], shown: LoadedClip) -> dict[str, Any] | None:
    """Return the turn (degrees) and the travel (shares of the picture) that are told, if any."""
    kinds = {movement.component.value for movement in moved}
    if not kinds & {"turn", "slide"}:
        return None
    mean = shown.encoded.belief.mean
    slide = np.float32([[[mean.right_px, mean.down_px]]]) * ("slide" in kinds)
    one_cell = np.ones((1, 1), np.float32)
    ((begin, end),) = lm.arrow_ends(slide, one_cell, shown.seen.view, lm.TRUE_DISPLACEMENT)
    return {"turn": float(mean.turn_deg) * ("turn" in kinds), "travel": _rounded(end - begin)}


def timeline_of(
    track: Any,
    units: lm.Units,
    axis: str,
    since_s: float = -np.inf,
    *,
    now: tuple[float, Any] | None = None,
    has_idle: bool = True,
) -> dict[str, Any]:
    """Return a row for each kind of event, with its curves and the spans that hold nine tenths.

    Args:
        track: Of the recording.
        units: Of its amounts.
        axis: Its unit, "s", or "frame" where the times are not known.
        since_s: From when on it is drawn; the way is that since the track's own begin.
        now: Time and way of a frame that is not settled yet, as of `Drawing.up_to`.
        has_idle: Whether anything is known: the untouched gel was seen.
    """
    drawing = lm.drawing_of(track, units)
    drawing = drawing if now is None else drawing.up_to(*now)
    limits = lm.Exported(track, units.mm_per_px).limits() if len(track) else {}
    limits = {component.value: round(float(far), 3) for component, far in limits.items()}
    unknown = () if track.is_contact_known else ("contact", "rest")  # which need an idle frame
    unknown = unknown if has_idle else tuple(LANES)
    places = np.flatnonzero(drawing.times_s >= since_s)
    if len(places) > MOST_POINTS:
        places = places[np.linspace(0, len(places) - 1, MOST_POINTS).round().astype(int)]
    bands = [band for band in drawing.bands if band.event.end_s >= since_s]
    curves = {"contact": "contact", "turn": "turn", "slide": "travel"}
    of_unit = {"contact": "", "turn": DEGREE, "slide": drawing.units.name, "rest": ""}
    lanes = [
        {
            "name": lane,
            "unit": of_unit[lane],
            "is_known": lane not in unknown,
            "limit": limits.get(lane),
            "events": [_event(band, axis) for band in bands if band.event.kind in kinds],
            "curves": [
                _curve(curve, places)
                for curve in drawing.curves
                if curve.panel == curves.get(lane) and lane not in unknown
            ],
        }
        for lane, kinds in LANES.items()
    ]
    return {
        "x": _rounded((drawing.times_s if axis == "s" else drawing.numbers)[places]),
        "lanes": lanes,
        # The way in shares of the picture, drawn as long as it is.
        "way": _rounded(drawing.arrows[places]),
    }


class GrowingTimeline:
    """The timeline of a recording that is still being tracked, drawn anew now and then.

    Args:
        unit: Of its axis.
        shape: Rows and columns of its frames.
    """

    def __init__(self, unit: str, shape: tuple[int, int]) -> None:
        self._unit, self._units = unit, lm.Units(shape, None)
        self._drawn_s = time.monotonic()
        self.values: dict[str, Any] = {}
        """Of the stage; empty at first."""

    def follow(self, tracker: Any) -> None:
        """Look at the tracker between two frames."""
        now_s = time.monotonic()
        if now_s - self._drawn_s < GROWS_EVERY_S:
            return
        track = tracker.so_far
        if len(track):
            self.values = {"timeline": timeline_of(track, self._units, self._unit)}
        self._drawn_s = time.monotonic()


def _event(band: Any, axis_unit: str) -> dict[str, Any]:
    event, unit = band.event, DEGREE if band.unit == "deg" else band.unit
    is_timed = axis_unit == "s"
    begin, end = (event.begin_s, event.end_s) if is_timed else (event.begin, event.end)
    far = _figure(band.amount, unit) if unit else ""
    text = {"turn": f"{band.way} {far}", "slide": f"{far} {band.way}", "stick": "rest"}
    return {
        "kind": event.kind.value,
        "text": text.get(event.kind.value, f"{event.kind.value} {far}").strip(),
        "begin": round(float(begin), 4),
        "end": round(float(end), 4),
        "size": round(abs(float(event.amount.mean)), 3),
        "span": _span(band, unit),
        "sure": round(100 * event.probability),
    }


def _span(band: Any, unit: str) -> str:
    if not band.event.is_readable:
        return "the pictures do not tell how far"
    return f"{_figure(band.low)} to {_figure(band.high, unit)}" if unit else ""


def _figure(value: float, unit: str = "") -> str:
    return f"{lm.figure_of(value)}{'' if unit in ('', DEGREE) else ' '}{unit}"


def _curve(curve: Any, places: NDArray) -> dict[str, Any]:
    plain = {"name": curve.name, "mean": _rounded(curve.mean[places], 3)}
    return plain if curve.spread is None else plain | {"spread": _rounded(curve.spread[places], 3)}


def _rounded(values: Any, digits: int = 4) -> list:
    return np.asarray(values, float).round(digits).tolist()


class Packs:
    """Packs by their keys; those that were asked for longest ago go first.

    A key is made of what the frames are: the same recording is encoded once.
    """

    def __init__(self) -> None:
        self._kept: OrderedDict[str, bytes] = OrderedDict()
        self._secret, self._lock = secrets.token_bytes(16), Lock()

    def address(self, images: list[Image]) -> str:
        """Return where the pictures can be fetched, each as good as the budget allows."""
        digest = hashlib.blake2b(key=self._secret, digest_size=16)
        for image in images:
            digest.update(repr(image.shape).encode())
            digest.update(np.ascontiguousarray(image))
        key = digest.hexdigest()
        if self.content(key) is None:
            pack = _packed(images)
            with self._lock:
                self._kept[key] = pack
                while sum(map(len, self._kept.values())) > KEPT_BYTES and len(self._kept) > 1:
                    self._kept.popitem(last=False)
        return f"{ROUTE}/{key}"

    def content(self, key: str) -> bytes | None:
        """Return a pack: how many pictures, the length of each, the files; None without it."""
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
            return self._kept.get(key)


PACKS = Packs()
"""Of this process."""


async def serve_pack(request: Any) -> Any:
    """Answer a request for a pack; nobody can guess a key."""
    content = PACKS.content(request.path_params["key"])
    if content is None:
        return Response("These pictures are gone; open the recording again.", 404)
    headers = {"cache-control": "private, max-age=3600, immutable"}
    return Response(content, media_type="application/octet-stream", headers=headers)


def _packed(images: list[Image]) -> bytes:
    places = np.linspace(0, len(images) - 1, SAMPLED).round().astype(int)
    for side, quality in QUALITIES:
        size = sum(len(jpeg(images[place], side, quality)) for place in places) / len(places)
        if size * len(images) <= BUDGET_BYTES:
            break
    files = [jpeg(image, side, quality) for image in images]
    return b"".join([struct.pack(f"<{len(files) + 1}I", len(files), *map(len, files)), *files])


def jpeg(image: Image, side: int, quality: int) -> bytes:
    """Return a picture as a file, made smaller where its longer side is beyond `side`."""
    scale = side / max(image.shape[:2])
    if scale < 1:
        size = (round(image.shape[1] * scale), round(image.shape[0] * scale))
        image = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    options = [cv2.IMWRITE_JPEG_QUALITY, quality]
    return cv2.imencode(".jpg", cv2.cvtColor(image, cv2.COLOR_RGB2BGR), options)[1].tobytes()


def jpeg_address(image: Image, side: int, quality: int) -> str:
    """Return a picture as a data address."""
    return f"data:image/jpeg;base64,{base64.b64encode(jpeg(image, side, quality)).decode()}"
