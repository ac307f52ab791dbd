"""What the timeline shows: a track's curves and events, or a short clip's motion as one step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm import COMPONENTS, SPAN_DEVIATIONS, Units

if TYPE_CHECKING:
    from .clip_loading import LoadedClip

MOST_POINTS = 1000
"""Of a curve; a longer one is thinned, its ends stay."""

DEGREE = "°"


@dataclass(frozen=True)
class Axis:
    """Along which a recording is shown.

    Args:
        is_in_seconds: Whether its times are known; else it is shown over its frames.
    """

    is_in_seconds: bool

    @property
    def unit(self) -> str:
        """Of its numbers: "s" or "frame"."""
        return "s" if self.is_in_seconds else "frame"

    def of(self, numbers: Any, seconds: Any) -> Any:
        """Return which of both holds along it."""
        return seconds if self.is_in_seconds else numbers


def timeline_of(track: Any, units: Units, axis: Axis, since_s: float = -np.inf) -> dict[str, Any]:
    """Return the curves of a track with the spans that hold nine tenths, and its events.

    Args:
        track: What was tracked, a `Track`.
        units: Of its recording.
        axis: Seconds, or frames where nothing tells them.
        since_s: From when on; the way is that since the track's own begin all the same.
    """
    places = np.flatnonzero(track.times_s >= since_s)
    if len(places) > MOST_POINTS:
        few = np.linspace(0, len(places) - 1, MOST_POINTS).round().astype(int)
        places = places[few]
    path, spread = track.path_from_start[places], track.path_deviations[places] * SPAN_DEVIATIONS
    right, down = units.travelled(path[:, 1], path[:, 2])
    right_spread, down_spread = units.travelled(spread[:, 1], spread[:, 2])
    turn = _curve("turn", path[:, 0], spread[:, 0])
    travel = [_curve("right", right, right_spread), _curve("down", down, down_spread)]
    touch = _curve("contact", track.contact[places])
    return {
        "x": _rounded(axis.of(track.numbers, track.times_s)[places]),
        "panels": [
            {"name": "turn", "unit": DEGREE, "curves": [turn], "told": "turn, clockwise up"},
            {
                "name": "travel",
                "unit": units.name,
                "curves": travel,
                "told": f"travel in {units.name}: right, dashed: down",
            },
            {"name": "contact", "unit": "", "range": [0, 1], "curves": [touch], "told": "contact"},
        ],
        "events": [_event(one, units, axis) for one in track.events if one.end_s >= since_s],
        # The way in shares of the picture, drawn as long as it is.
        "way": _rounded(path[:, 1:3] / _filled(units)),
    }


def now_at(timeline: dict[str, Any], now_s: float, way: NDArray, units: Units) -> None:
    """Lead the curves of a track that goes on up to the way as it stands now, as doubtful as last.

    Args:
        timeline: As `timeline_of` returns it, in seconds; changed in place.
        now_s: When the last frame was taken.
        way: Turn, right, down and inward since the first frame, (4,).
        units: Of the frames.
    """
    turn, travel, contact = (panel["curves"] for panel in timeline["panels"])
    right, down = units.travelled(way[1], way[2])
    for curve, value in zip((*turn, *travel), (way[0], right, down), strict=True):
        curve["mean"].append(round(float(value), 3))
        curve["spread"].append(curve["spread"][-1] if curve["spread"] else 0.0)
    touch = contact[0]["mean"]
    touch.append(touch[-1] if touch else 0.0)
    timeline["x"].append(round(now_s, 3))
    timeline["way"].append(_rounded(way[1:3] / _filled(units)))


def step_of(shown: LoadedClip, units: Units) -> dict[str, Any]:
    """Return what is believed of a short clip: each component's way and amount, from end to end.

    Args:
        shown: The clip.
        units: Of its frames.
    """
    from geotlm_lm import LEAST_SURE  # with the model's libraries

    belief = shown.encoded.belief
    if not shown.seen.has_contact or belief.contact < LEAST_SURE:
        return {"rows": [], "told": "No contact is seen: no motion is claimed."}
    return {"rows": [_row(belief, one, units) for one in COMPONENTS], "told": ""}


def _row(belief: Any, component: Any, units: Units) -> dict[str, Any]:
    from geotlm_lm import LEAST_SURE

    counts = belief.counts(component)
    row = {"name": component.value, "counts": counts >= LEAST_SURE}
    if not belief.readable.get(component, True):
        return row | {"counts": False, "text": "cannot be told from these pictures"}
    if not row["counts"]:
        return row | {"text": f"none, {100 * (1 - counts):.0f} % sure"}
    way = belief.way(component)
    share = belief.share(way, component)
    if share < LEAST_SURE:
        return row | {"text": "yes, but not which way"}
    unit, factor = _unit_of(belief, component, units)
    mean = factor * belief.amount(component)
    spread = factor * SPAN_DEVIATIONS * belief.deviation(component)
    far = _far(mean, mean - spread, mean + spread, unit)
    return row | {"text": f"{way.value} {far}, {100 * counts * share:.0f} % sure"}


def _unit_of(belief: Any, component: Any, units: Units) -> tuple[str, float]:
    """Return the unit of a component, and what belief's own is of it along the way."""
    if component.value != "slide":
        return {"turn": DEGREE, "press": "mm"}[component.value], 1.0
    way = belief.mean.right_px, belief.mean.down_px
    length = float(np.hypot(*way))
    scaled = float(np.hypot(*units.travelled(*way)))
    return units.name, scaled / length if length else units.travel[1][0]


def _event(event: Any, units: Units, axis: Axis) -> dict[str, Any]:
    facts = units.event(event)
    far = ""
    if "unit" in facts:
        unit = DEGREE if facts["unit"] == "deg" else facts["unit"]
        sign = -1 if facts["amount"] < 0 else 1
        low, high = sorted((sign * facts["low"], sign * facts["high"]))
        far = _far(sign * facts["amount"], low, high, unit)
    return {
        "kind": facts["event"],
        "name": " ".join(one for one in (facts["event"], facts["way"]) if one),
        "begin": round(float(axis.of(event.begin, event.begin_s)), 4),
        "end": round(float(axis.of(event.end, event.end_s)), 4),
        "far": far,
        "sure": round(100 * event.probability),
    }


def _far(mean: float, low: float, high: float, unit: str) -> str:
    gap = "" if unit == DEGREE else " "
    middle, least, most = (
        f"{one:.2g}" if abs(one) < 100 else f"{one:.0f}" for one in (mean, max(low, 0.0), high)
    )
    return f"{middle}{gap}{unit} ({least} to {most})"


def _curve(name: str, mean: NDArray, spread: NDArray | None = None) -> dict[str, Any]:
    curve = {"name": name, "mean": _rounded(mean, 3)}
    if spread is not None:
        curve["spread"] = _rounded(spread, 3)
    return curve


def _filled(units: Units) -> NDArray[np.float64]:
    """Return the columns and rows of the 224-pixel square that the picture fills."""
    rows, columns = units.frame_size
    across, down = Units(units.frame_size).travel[1]
    return np.array([columns / across, rows / down])


def _rounded(values: Any, digits: int = 4) -> list:
    return np.asarray(values, float).round(digits).tolist()
