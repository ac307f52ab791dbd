"""Whole recordings: how far it turned in all, what happened when, and beside it two rivals."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from geotlm_lm.benchmarks.cases.streams import Planned, Stream, streams
from geotlm_lm.benchmarks.halves import Half, recordings_by_half, rows_of_half, titled
from geotlm_lm.benchmarks.rendering import right_with_interval
from geotlm_lm.benchmarks.rows import Pivot, Row, Run, Section, every
from geotlm_lm.benchmarks.statistics import Tally
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.tolerance import RELATIVE_TOLERANCE
from geotlm_lm.core.twist import Component
from geotlm_lm.data.touch_table import (
    FIRST_IDLE,
    SURELY_IDLE,
    TABLE_NAME,
    DirectedRow,
    read_directed,
)
from geotlm_lm.probe.rigid_alignment import RigidAlignment
from geotlm_lm.probe.rigid_flow import RigidFlow
from geotlm_lm.recordings.read import read_clip
from geotlm_lm.track.events import Event, EventKind
from geotlm_lm.track.track import Track

ABOUT = """\
A recording from its first frame to its last, bracketed at its contact, and at its labelled turn:
the *direction* of the net turn; *how far*, within 5 degrees or a fifth of the label; whether the
told *span*, nine in ten, holds it. Optical flow and direct alignment are summed from frame to frame
over the same frames. Simulated streams hold several motions in a row: an event is *found* if one of
its kind and way overlaps it, its *ends* are right within 0.2 s, the *order* is that of the truth,
and a single turn is *not told back* by a turn the other way."""

TRACK, FLOW, ALIGNMENT = "track", "optical flow", "direct alignment"

WITHIN_DEG, WITHIN_S, STREAMS = 5.0, 0.2, 60

KINDS = {Component.TURN: EventKind.TURN, Component.SLIDE: EventKind.SLIDE}


Graded = tuple[str, bool]
"""What is graded of an answer, such as "direction", and whether it is right."""


def track_rows(run: Run) -> Iterator[Row]:
    """Yield the rows of real recordings, each half apart, and of simulated streams."""
    track = run.answerer.track
    for name, half, real in recordings_by_half(run.real):
        directed = rows_of_half(read_directed(real.folder / TABLE_NAME), half)
        rows = [row for row in directed if row.turn_deg]
        yield from _real(run, name, half, rows[: run.size(len(rows), 2)], track)
    yield from _simulated(run, run.size(STREAMS, 4), track)


def _real(
    run: Run, name: str, half: Half, rows: Sequence[DirectedRow], track: Callable[[Clip], Track]
) -> Iterator[Row]:
    tally = Tally()

    def grade(row: DirectedRow, span: str, variant: str, graded: Sequence[Graded]) -> None:
        for what, is_right in graded:
            case = f"{titled(f'real {name}, {span}', half)}: {what}"
            tally.add(case, variant, is_right, row.object_family)

    for done, row in enumerate(rows, start=1):
        clip = read_clip(row.path)
        tracked = track(clip)
        spans = {"whole recording": None, "bracketed contact": row.touched, "turn": row.turning}
        for span, frames in spans.items():
            part = tracked if frames is None else tracked.between(*frames)
            net = part.net(Component.TURN)
            in_span = ("span", net.holds(row.turn_deg))
            grade(row, span, TRACK, [*turn_grades(row, net.mean), in_span])
        # Rivals know no touch: they are given the contact.
        for variant, rival in ((FLOW, RigidFlow()), (ALIGNMENT, RigidAlignment())):
            first, last = row.touched or (0, len(clip) - 1)
            idle = np.median(clip.frames[FIRST_IDLE : FIRST_IDLE + SURELY_IDLE], axis=0)
            part = clip.select(range(first, min(last + 1, len(clip))))
            part = replace(part, background=idle.astype(np.uint8))
            told = turn_grades(row, rival.fit(part).rotation_deg)
            grade(row, "bracketed contact", variant, told)
        run.progress(titled(f"tracks of {name}", half), done, len(rows))
    yield from tally.rows(run.seed)


def turn_grades(row: DirectedRow, told_deg: float) -> list[Graded]:
    """Return whether the direction and the size of a recording's turn are right."""
    off, true = abs(told_deg - row.turn_deg), row.turn_deg
    is_near = off <= max(WITHIN_DEG, RELATIVE_TOLERANCE * abs(true))
    return [("direction", told_deg * true > 0), ("how far", is_near)]


def _simulated(run: Run, count: int, track: Callable[[Clip], Track]) -> Iterator[Row]:
    tally = Tally()
    for done, stream in enumerate(streams(count, run.seed), start=1):
        for what, is_right in event_grades(stream, track(stream.clip)):
            tally.add(f"simulated streams: {what}", TRACK, is_right, stream.object_name)
        run.progress("simulated streams", done, count)
    yield from tally.rows(run.seed)


def event_grades(stream: Stream, track: Track) -> Iterator[Graded]:
    """Yield whether each readable motion of a stream was found, when, and in which order."""
    order, fps = [], stream.clip.fps
    for planned in stream.planned:
        if not planned.is_readable:
            continue
        event = matching(planned, track.events)
        yield "event found", event is not None
        if event is None:
            yield "both ends", False
            continue
        order.append(event.begin)
        apart = max(abs(event.begin - planned.begin), abs(event.end - planned.end))
        yield "both ends", apart <= WITHIN_S * fps
    yield "order", order == sorted(order)
    turns = [one for one in stream.planned if one.component is Component.TURN]
    if len(turns) == 1 and turns[0].is_readable:
        told = (one.amount.mean for one in track.events if one.kind is EventKind.TURN)
        back = any(mean * turns[0].twist.turn_deg < 0 for mean in told)
        yield "not told back", not back


def matching(planned: Planned, events: Sequence[Event]) -> Event | None:
    """Return the event of a motion's kind and way that overlaps it most; None without any."""

    def overlap(event: Event) -> int:
        return min(event.end, planned.end) - max(event.begin, planned.begin)

    def goes_along(event: Event) -> bool:
        told, true = event.twist, planned.twist
        if planned.component is Component.TURN:
            return told.turn_deg * true.turn_deg > 0
        return told.right_px * true.right_px + told.down_px * true.down_px > 0

    kind = KINDS[planned.component]
    likely = [one for one in events if one.kind is kind and overlap(one) > 0 and goes_along(one)]
    return max(likely, key=overlap, default=None)


TRACKS = Section(
    name="recordings",
    title="Whole recordings",
    about=ABOUT,
    run=track_rows,
    views={"": (Pivot(right_with_interval, "recordings, what is graded"), every)},
)
