"""What the timeline shows: a track's curves and events, or a short clip's motion as one step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm import Units
from geotlm_lm.core.twist import COMPONENTS, Component
from geotlm_lm.track.amounts import SPAN_DEVIATIONS, Span
from geotlm_lm.track.events import EventKind
from geotlm_lm.track.export import event_name

if TYPE_CHECKING:
    from geotlm_lm.motion.belief import Belief
    from geotlm_lm.track.track import Track

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


def timeline_of(track: Track, units: Units, axis: Axis) -> dict[str, Any]:
    """Return the curves of a track with the spans that hold nine tenths, and its events.

    Args:
        track: What was tracked.
        units: Of its recording.
        axis: Seconds, or frames where nothing tells them.
    """
    places = np.arange(len(track))
    if len(track) > MOST_POINTS:
        places = np.linspace(0, len(track) - 1, MOST_POINTS).round().astype(int)
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
        "events": [_event(one, units, axis) for one in track.events],
        # The way in shares of the picture, drawn as long as it is.
        "way": _rounded(path[:, 1:3] / _filled(units)),
    }


def step_of(shown: LoadedClip, units: Units) -> dict[str, Any]:
    """Return what is believed of a short clip: each component's way and amount, from end to end.

    Args:
        shown: The clip.
        units: Of its frames.
    """
    from geotlm_lm import LEAST_SURE  # with the model's libraries

    belief: Belief = shown.encoded.belief
    if not shown.seen.has_contact or belief.contact < LEAST_SURE:
        return {"rows": [], "told": "No contact is seen: no motion is claimed."}
    return {"rows": [_row(belief, one, units) for one in COMPONENTS], "told": ""}


def _row(belief: Belief, component: Component, units: Units) -> dict[str, Any]:
    from geotlm_lm import LEAST_SURE

    counts = belief.counts(component)
    row = {"name": component.value, "counts": counts >= LEAST_SURE}
    if not belief.readable.get(component, True):
        return row | {"counts": False, "text": "cannot be told from these pictures"}
    if not row["counts"]:
        return row | {"text": f"none, {100 * (1 - counts):.0f} % sure"}
    share = belief.share(belief.way(component), component)
    if share < LEAST_SURE:
        return row | {"text": "yes, but not which way"}
    span = Span(belief.amount(component), belief.deviation(component))
    unit = {Component.TURN: DEGREE, Component.SLIDE: units.name, Component.PRESS: "mm"}[component]
    if component is Component.SLIDE:
        span = units.slide(span, (belief.mean.right_px, belief.mean.down_px))
    gap = "" if unit == DEGREE else " "
    low, high = max(span.low, 0.0), span.high
    way = belief.way(component).value
    return row | {
        "text": f"{way} {span.mean:.2g}{gap}{unit} ({low:.2g} to {high:.2g})"
        f", {100 * counts * share:.0f} % sure"
    }


def _event(event: Any, units: Units, axis: Axis) -> dict[str, Any]:
    found = units.amount(event)
    far = ""
    if found is not None:
        span, unit = found
        unit = DEGREE if unit == "deg" else f" {unit}"
        low, high = sorted((abs(span.low), abs(span.high)))
        low = 0.0 if span.low * span.high < 0 else low
        far = f"{abs(span.mean):.2g}{unit} ({low:.2g} to {high:.2g})"
    return {
        "kind": event.kind.value,
        "name": event_name(event),
        "begin": round(float(axis.of(event.begin, event.begin_s)), 4),
        "end": round(float(axis.of(event.end, event.end_s)), 4),
        "far": far,
        "sure": round(100 * event.probability),
        "is_instant": event.kind is EventKind.TOUCH,
    }


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
