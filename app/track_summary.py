"""A track in few words and numbers, as programs and agents get it: bounded, in the frame asked."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm import Exported, FrameSpec, Motion

from .limits import EVENTS
from .results import TrackResult

WAYS = {Motion.RIGHT: (1, 0), Motion.LEFT: (-1, 0), Motion.DOWN: (0, 1), Motion.UP: (0, -1)}
"""Right and down of each slide."""


def summary_of(track: Any, recording: Any, frame: FrameSpec, rows: int) -> TrackResult:
    """Return what a track comes to.

    Args:
        track: Of the recording, or of a span of it.
        recording: The `Clip` that was tracked.
        frame: In which directions are told.
        rows: How many frames are told at most, evenly spread.
    """
    exported, told_as = Exported(track, frame.mm_per_px), _ToldAs(frame)
    told = exported.to_dict()
    return {
        "recording": recording.name,
        "frame": frame.summary(),
        "first_frame": int(track.numbers[0]),
        "last_frame": int(track.numbers[-1]),
        "times_are_known": recording.is_timed,
        "contacts_s": [[round(one, 4) for one in ends] for ends in track.contacts()],
        "events": [told_as.event(one) for one in told["events"][:EVENTS]],
        "events_left_out": max(len(told["events"]) - EVENTS, 0),
        "totals": told_as.totals(told["totals"]),
        "rows": [told_as.row(one, exported.units.name) for one in _spread(exported, rows)],
        "notes": [*recording.notes, *told["notes"]],
    }


class _ToldAs:
    """Names what was exported in the recorded image as a frame tells it."""

    def __init__(self, frame: FrameSpec) -> None:
        self._frame = frame
        ways = [WAYS[frame.edit.of_way(one)] for one in (Motion.RIGHT, Motion.DOWN)]
        self._slide: NDArray[np.int64] = np.array(ways).T
        self._turn = 1 if frame.edit.of_way(Motion.CLOCKWISE) is Motion.CLOCKWISE else -1

    def event(self, event: dict[str, Any]) -> dict[str, Any]:
        """Return an event with its way as told; amounts are how far it goes that way."""
        way = None if event["way"] is None else self._frame.edit.of_way(Motion(event["way"])).value
        if event.get("amount", 0.0) < 0:
            event |= _negated(event)
        return event | {"way": way}

    def totals(self, totals: dict[str, Any]) -> dict[str, Any]:
        """Return what a track comes to with its net turn and travel as told."""
        net = totals["turn_net"]
        right, down = self._slide @ (totals["slide_right"], totals["slide_down"]) + 0.0
        return totals | {
            "turn_net": net if self._turn > 0 else net | _negated(net),
            "slide_right": float(right),
            "slide_down": float(down),
        }

    def row(self, row: dict[str, Any], unit: str) -> dict[str, float]:
        """Return a frame with its turn and travel as told."""
        names = [f"right_{unit}", f"down_{unit}"]
        told = {"turn_deg": self._turn * row["turn_deg"] + 0.0}
        way = self._slide @ [row[one] for one in names] + 0.0
        told |= dict(zip(names, map(float, way), strict=True))
        names = [f"{one}_deviation" for one in names]
        doubts = np.abs(self._slide) @ [row[one] for one in names]
        return row | told | dict(zip(names, map(float, doubts), strict=True))


def _negated(span: dict[str, Any]) -> dict[str, float]:
    """Return an amount the other way round."""
    return {"amount": -span["amount"], "low": -span["high"], "high": -span["low"]}


def _spread(exported: Exported, most: int) -> list[dict[str, Any]]:
    """Return at most so many frames, the first and the last among them."""
    rows = list(exported.rows()) if most else []
    if len(rows) <= most:
        return rows
    return [rows[place] for place in np.linspace(0, len(rows) - 1, most).round().astype(int)]
