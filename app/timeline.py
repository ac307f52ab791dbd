"""What the timeline shows: a track's curves and events, or a short clip's motion as one step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm import COMPONENTS, SPAN_DEVIATIONS, Drawing, Units

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


def timeline_of(drawing: Drawing, axis: Axis, since_s: float = -np.inf) -> dict[str, Any]:
    """Return the curves of a track with the spans that hold nine tenths, and its events.

    Args:
        drawing: Of the track.
        axis: Seconds, or frames where their times are not known.
        since_s: From when on; the way is that since the track's own begin all the same.
    """
    places = np.flatnonzero(drawing.times_s >= since_s)
    if len(places) > MOST_POINTS:
        places = places[np.linspace(0, len(places) - 1, MOST_POINTS).round().astype(int)]
    unit = drawing.units.name
    panels = [
        {"name": "turn", "unit": DEGREE, "told": "turn, clockwise up"},
        {"name": "travel", "unit": unit, "told": f"travel in {unit}: right, dashed: down"},
        {"name": "contact", "unit": "", "range": [0, 1], "told": "contact"},
    ]
    for panel in panels:
        curves = (curve for curve in drawing.curves if curve.panel == panel["name"])
        panel["curves"] = [_curve(curve, places) for curve in curves]
    return {
        "x": _rounded(axis.of(drawing.numbers, drawing.times_s)[places]),
        "panels": panels,
        "events": [_event(band, axis) for band in drawing.bands if band.event.end_s >= since_s],
        # The way in shares of the picture, drawn as long as it is.
        "way": _rounded(drawing.arrows[places]),
    }


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


def _event(band: Any, axis: Axis) -> dict[str, Any]:
    event, unit = band.event, DEGREE if band.unit == "deg" else band.unit
    return {
        "kind": event.kind.value,
        "name": band.name,
        "begin": round(float(axis.of(event.begin, event.begin_s)), 4),
        "end": round(float(axis.of(event.end, event.end_s)), 4),
        "far": _far(band.amount, band.low, band.high, unit) if unit else "",
        "sure": round(100 * event.probability),
    }


def _far(mean: float, low: float, high: float, unit: str) -> str:
    gap = "" if unit == DEGREE else " "
    middle, least, most = (
        f"{one:.2g}" if abs(one) < 100 else f"{one:.0f}" for one in (mean, max(low, 0.0), high)
    )
    return f"{middle}{gap}{unit} ({least} to {most})"


def _curve(curve: Any, places: NDArray) -> dict[str, Any]:
    plain = {"name": curve.name, "mean": _rounded(curve.mean[places], 3)}
    return plain if curve.spread is None else plain | {"spread": _rounded(curve.spread[places], 3)}


def _rounded(values: Any, digits: int = 4) -> list:
    return np.asarray(values, float).round(digits).tolist()
