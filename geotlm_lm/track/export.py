"""A track as files and plain values: a table of its frames, its events, what it comes to."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from geotlm_lm.core.errors import require_package
from geotlm_lm.core.files import replacing
from geotlm_lm.core.geometry import travel_scale
from geotlm_lm.core.twist import Component
from geotlm_lm.track.events import Event, Span
from geotlm_lm.track.track import Track

UNITS = {Component.TURN: "deg", Component.PRESS: "mm"}
"""Of a slide it is that of `Units`."""

_PACKAGES = {
    ".parquet": ("pyarrow", "track"),
    ".png": ("matplotlib", "track"),
    ".svg": ("matplotlib", "track"),
    ".pdf": ("matplotlib", "track"),
    ".rrd": ("rerun", "rerun"),
}
"""What writes a file, by its ending, and the extra that installs it."""


SERVE = Path("serve")
"""In place of a Rerun file's name: what would be written is shown in a browser."""


def require_packages(path: Path) -> None:
    """Refuse a file whose package is not installed, before any work is done for it.

    Raises:
        MissingDependency: If it is not there.
    """
    ending = ".rrd" if path == SERVE else path.suffix
    package, extra = _PACKAGES.get(ending, (None, ""))
    if package is not None:
        require_package(package, f"{path}: a {ending} file is written with {package}", extra)


@dataclass(frozen=True)
class Units:
    """The units of a recording, and what its events come to in them."""

    frame_size: tuple[int, int]  # rows and columns of the recording's frames
    # width on the gel of a pixel of these frames, mm; None keeps travel in pixels
    mm_per_px: float | None = None

    @property
    def name(self) -> str:
        """The unit of travel: "px" of the recording's frames, or "mm"."""
        return self.travel[0]

    @property
    def travel(self) -> tuple[str, tuple[float, float]]:
        """Unit of travel, and what a pixel of the 224-pixel square is of it, across and down."""
        if min(self.frame_size) < 1:
            return "px", (1.0, 1.0)
        return travel_scale(*self.frame_size, self.mm_per_px)

    def travelled(self, right_px: Any, down_px: Any) -> tuple[Any, Any]:
        """Return travel in pixels of the 224-pixel square in this unit, right and down."""
        across, down = self.travel[1]
        return right_px * across, down_px * down

    def amount(self, event: Event) -> tuple[Span, str] | None:
        """Return how far an event goes, signed, and the unit.

        None of a touch or a rest, and where the pictures do not tell how far.
        """
        if event.component is None or not event.is_readable:
            return None
        if event.begin == event.end and not event.amount.mean:
            return None
        if event.component is not Component.SLIDE:
            return event.amount, UNITS[event.component]
        way = event.twist.right_px, event.twist.down_px
        return self.slide(event.amount, way), self.name

    def slide(self, amount: Span, way: tuple[float, float]) -> Span:
        """Return the length of a travel that goes `way`, pixels of the square, in this unit."""
        far = float(np.hypot(*way))
        scaled = float(np.hypot(*self.travelled(*way)))
        factor = scaled / far if far > 0 else self.travel[1][0]
        return Span(amount.mean * factor, amount.deviation * factor)

    def event(self, event: Event) -> dict[str, Any]:
        """Return an event as plain JSON values; the span of its amount holds nine tenths."""
        facts: dict[str, Any] = {
            "event": event.kind.value,
            "way": _way(event),
            "begin": event.begin,
            "end": event.end,
            "begin_s": round(event.begin_s, 4),
            "end_s": round(event.end_s, 4),
        }
        amount = self.amount(event)
        if amount is not None:
            facts |= _plain(amount[0]) | {"unit": amount[1]}
        if not event.is_readable:
            facts |= {"amount": None}
        return facts | {"probability": round(event.probability, 4)}


@dataclass(frozen=True, eq=False)
class Exported:
    """A track in the units of its recording; `mm_per_px` as of `Units`."""

    track: Track
    mm_per_px: float | None = None

    @property
    def units(self) -> Units:
        """The units of its amounts."""
        return Units(self.track.frame_size, self.mm_per_px)

    def rows(self) -> Iterator[dict[str, Any]]:
        """Yield a row of plain values for each frame, as of `Track.to_rows`, travel in its unit."""
        unit, (across, down) = self.units.travel
        factors = {"right_px": across, "down_px": down}
        for row in self.track.to_rows():
            yield {
                name.replace("_px", f"_{unit}"): round(value * factor, 4) if factor else value
                for name, value in row.items()
                for factor in [factors.get(name.removesuffix("_deviation"))]
            }

    def totals(self) -> dict[str, Any]:
        """Return what the whole track comes to, as plain JSON values.

        What is net is from the first frame to the last; in all, the sum of what events go there and
        back; None where the pictures do not tell how far. How long it is touched is None where
        contact is not known. A limit is what it would have had to go at the least to be an event;
        None where nothing touches.
        """
        track, net, units = self.track, self.track.net_twist, self.units
        touched_s = round(sum(last - first for first, last in track.contacts()), 4)
        right, down = units.travelled(net.right_px, net.down_px)
        slide = units.slide(track.net(Component.SLIDE), (net.right_px, net.down_px))
        slides = [units.slide(event.amount, (event.twist.right_px, event.twist.down_px))
                  for event in track.of(Component.SLIDE)]  # fmt: skip
        path = Span(sum(slide.mean for slide in slides), sum(slide.deviation for slide in slides))
        turns = track.net(Component.TURN), track.path(Component.TURN)
        if not track.is_readable(Component.TURN):
            turns = None, None
        if not track.is_readable(Component.SLIDE):
            slide = path = right = down = None
        limits = {component: round(float(far), 3) for component, far in self.limits().items()}
        return {
            "frames": len(track),
            "seconds": round(track.seconds, 4),
            "touched_s": touched_s if track.is_contact_known else None,
            "turn_net": _plain(turns[0]) | {"unit": "deg"},
            "turn_limit": limits.get(Component.TURN),
            "turn_in_all": _plain(turns[1]) | {"unit": "deg"},
            "turned_back": track.turned_back(),
            "slide_net": _plain(slide) | {"unit": units.name},
            "slide_limit": limits.get(Component.SLIDE),
            "slide_right": None if right is None else round(float(right), 3),
            "slide_down": None if down is None else round(float(down), 3),
            "slide_in_all": _plain(path) | {"unit": units.name},
        }

    def limits(self) -> dict[Component, float]:
        """Return how far a turn (degrees), a slide and a press (mm) have to go to be an event.

        Empty where nothing touches.
        """
        limits, radius = self.track.limits, self.track.middle_radius_px
        if not limits or not radius:
            return {}
        turn = float(np.degrees(limits[Component.TURN] / radius))
        slide = limits[Component.SLIDE] * max(self.units.travel[1])
        return {**limits, Component.TURN: turn, Component.SLIDE: slide}

    def to_dict(self) -> dict[str, Any]:
        """Return events, totals and notes as plain JSON values."""
        return {
            "events": [self.units.event(event) for event in self.track.events],
            "totals": self.totals(),
            "notes": list(self.track.notes),
        }

    def save(self, path: Path, made_by: dict[str, Any]) -> None:
        """Write the table of frames; of .json also events, totals, notes and what made it.

        The ending, .csv, .parquet or .json, says how; a .parquet file keeps what made it as well.

        Raises:
            MissingDependency: If the package that writes it is not installed.
            Unwritten: If the file cannot be written.
        """
        content = self.content(path.suffix, made_by)
        with replacing(path) as stream:
            stream.write(content)

    def content(self, ending: str, made_by: dict[str, Any]) -> bytes:
        """Return what `save` writes to a file of this ending."""
        require_packages(Path(f"table{ending}"))
        writers = {".csv": self._csv, ".parquet": self._parquet, ".json": self._json}
        return writers[ending](made_by)

    def _csv(self, _: dict[str, Any]) -> bytes:
        rows, text = list(self.rows()), io.StringIO(newline="")
        writer = csv.DictWriter(text, rows[0] if rows else ["frame"])
        writer.writeheader()
        writer.writerows(rows)
        return text.getvalue().encode()

    def _json(self, made_by: dict[str, Any]) -> bytes:
        whole = self.to_dict() | {"rows": list(self.rows()), "made_by": made_by}
        return (json.dumps(whole, indent=1) + "\n").encode()

    def _parquet(self, made_by: dict[str, Any]) -> bytes:
        import pyarrow
        import pyarrow.parquet

        table = pyarrow.Table.from_pylist(list(self.rows()))
        about = json.dumps(self.to_dict() | {"made_by": made_by})
        table = table.replace_schema_metadata({"geotlm_lm": about})
        stream = io.BytesIO()
        pyarrow.parquet.write_table(table, stream)
        return stream.getvalue()


def event_name(event: Event) -> str:
    """Return what tables call an event: its kind and, where it has one, its way."""
    way = _way(event)
    return event.kind.value if way is None else f"{event.kind.value} {way}"


def _way(event: Event) -> str | None:
    """Return which way a turn or a slide goes in the camera image; None of what has none."""
    if event.component in (Component.TURN, Component.SLIDE):
        return event.twist.way(event.component).value
    return None


def _plain(span: Span | None) -> dict[str, float | None]:
    if span is None:
        return dict.fromkeys(("amount", "low", "high"))
    numbers = {"amount": span.mean, "low": span.low, "high": span.high}
    return {name: round(float(value), 3) for name, value in numbers.items()}
