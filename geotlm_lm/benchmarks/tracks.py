"""Whole recordings: how far it turned in all, what happened when, and beside it two rivals.

Simulated streams hold several motions in a row, each with its exact beginning, end and amount: idle
gel, touch, then turns and slides with rests between them or none, release, idle gel.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from geotlm_lm.alignment.dots import without_dots
from geotlm_lm.benchmarks.cases import Half, recordings_by_half, rows_of_half, titled
from geotlm_lm.benchmarks.harness import Pivot, Row, Run, Section, every
from geotlm_lm.benchmarks.judging import Graded, share_rows
from geotlm_lm.benchmarks.rendering import right_with_interval
from geotlm_lm.benchmarks.variants import FITS
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.numbers import generator_for, seed_for
from geotlm_lm.core.tolerance import RELATIVE_TOLERANCE
from geotlm_lm.core.twist import Component, Twist
from geotlm_lm.data.touch_table import (
    FIRST_IDLE,
    SURELY_IDLE,
    TABLE_NAME,
    DirectedRow,
    read_directed,
)
from geotlm_lm.recordings.read import read_clip
from geotlm_lm.track.events import Event, EventKind
from geotlm_lm.track.track import Track

if TYPE_CHECKING:
    from geotlm_lm.simulation.scene import Path, Scene

TRACK = "track"

WITHIN_DEG, WITHIN_S, STREAMS = 5.0, 0.2, 60

KINDS = {Component.TURN: EventKind.TURN, Component.SLIDE: EventKind.SLIDE}

IDLE, PRESSING = 12, 8
"""Frames before and after contact, and frames in which an object is pressed in or lifted."""

CLEAR_MM = 0.3
"""Height above the gel at which nothing touches."""

TURN_DEG, SLIDE_MM, MOVING, RESTING = (15.0, 60.0), (0.8, 2.2), (12, 28), (9, 16)
"""Least and most of a turn, a slide, and of the frames that a motion and a rest take."""

PLANS: tuple[tuple[str, ...], ...] = (
    ("rest", "turn", "rest"),
    ("turn", "rest", "slide", "rest"),
    ("turn", "back", "rest"),
    ("slide", "rest", "turn", "rest", "back"),
    ("rest", "slide", "rest"),
)
"""What happens between touch and release; "back" is a turn the other way."""


@dataclass(frozen=True)
class Planned:
    """A motion of a stream, of the middle of the contact, after frame `begin` and up to `end`.

    It is readable if the picture shows it and it counts.
    """

    component: Component
    begin: int
    end: int
    twist: Twist
    is_readable: bool


@dataclass(frozen=True, eq=False)
class Stream:
    """A recording with its idle gel in its first frames, and its turns and slides in order."""

    clip: Clip
    planned: tuple[Planned, ...]
    object_name: str


def streams(count: int, seed: int) -> Iterator[Stream]:
    """Yield simulated streams of objects that no weight was trained on."""
    from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS
    from geotlm_lm.simulation.randomise import random_scene
    from geotlm_lm.simulation.simulate import simulate

    root = seed_for(seed, "evaluation", "streams")
    for index in range(count):
        rng = generator_for(root, "stream", index)
        name = EVERYDAY_OBJECTS[int(rng.integers(len(EVERYDAY_OBJECTS)))]
        scene = random_scene(rng, object_name=name, motion=Motion.CLOCKWISE)
        path, spans = _path(rng, scene, PLANS[index % len(PLANS)])
        scene = replace(scene, path=path)
        made = simulate([scene], seed=root, first_index=index)[0]
        planned = tuple(_planned(scene, *span) for span in spans)
        yield Stream(replace(made.clip, background=None), planned, name)


def _path(
    rng: np.random.Generator, scene: Scene, plan: tuple[str, ...]
) -> tuple[Path, list[tuple[Component, int, int]]]:
    """Return the poses, and of each motion its component and its first and last pose."""
    from geotlm_lm.simulation.scene import Path

    middle = len(scene.path) // 2
    deep = scene.path.depth_mm[middle]
    # Depth, x, y, turn: where each stretch of the path ends, after so many frames.
    ends = [((-CLEAR_MM, scene.path.x_mm[middle], scene.path.y_mm[middle], 0.0), IDLE)]
    spans: list[tuple[Component, int, int]] = []

    def go(frames: int, depth: float = 0.0, x: float = 0.0, y: float = 0.0, turn: float = 0.0):
        here = ends[-1][0]
        ends.append((tuple(np.add(here, (depth, x, y, turn))), frames))

    go(PRESSING, depth=deep + CLEAR_MM)
    turned = float(rng.uniform(*TURN_DEG) * rng.choice([-1, 1]))
    # Slides lead towards the middle of the view, so that the contact stays in it.
    angle = np.arctan2(-scene.path.y_mm[middle], -scene.path.x_mm[middle]) + rng.normal(0, 0.5)
    for what in plan:
        since = sum(frames for _, frames in ends) - 1
        frames = int(rng.integers(*(RESTING if what == "rest" else MOVING)))
        if what == "slide":
            far = rng.uniform(*SLIDE_MM)
            go(frames, x=far * np.cos(angle), y=far * np.sin(angle))
            spans.append((Component.SLIDE, since, since + frames))
        elif what == "rest":
            go(frames)
        else:
            turned = turned if what == "turn" else -0.7 * turned
            go(frames, turn=np.radians(turned))
            spans.append((Component.TURN, since, since + frames))
    go(PRESSING, depth=-deep - CLEAR_MM)
    go(IDLE)
    poses = [np.tile(ends[0][0], (IDLE, 1))]
    for (begin, _), (end, frames) in zip(ends[:-1], ends[1:], strict=True):
        share = np.arange(1, frames + 1)[:, None] / frames
        poses.append(np.array(begin) + share * np.subtract(end, begin))
    return Path(*(tuple(row.tolist()) for row in np.concatenate(poses).T)), spans


def _planned(scene: Scene, component: Component, begin: int, end: int) -> Planned:
    """Return what is true of one stretch, by itself."""
    from geotlm_lm.simulation.scene import Path
    from geotlm_lm.simulation.simulate import simulate

    rows = (scene.path.depth_mm, scene.path.x_mm, scene.path.y_mm, scene.path.rotation_rad)
    path = Path(*((row[begin], row[end]) for row in rows))
    made = simulate([replace(scene, path=path)], seed=0, with_frames=False)[0]
    truth = made.components[component]
    return Planned(component, begin, end, made.twist, bool(truth.moves) and truth.is_visible)


def _track_rows(run: Run) -> Iterator[Row]:
    for name, half, real in recordings_by_half(run.real):
        directed = rows_of_half(read_directed(real.folder / TABLE_NAME), half)
        rows = [row for row in directed if row.turn_deg]
        graded = _real_grades(run, name, half, rows[: run.size(len(rows), 2)])
        yield from share_rows(graded, run.seed)
    yield from share_rows(_simulated_grades(run, run.size(STREAMS, 4)), run.seed)


def _real_grades(run: Run, name: str, half: Half, rows: Sequence[DirectedRow]) -> Iterator[Graded]:
    for done, row in enumerate(rows, start=1):
        clip = read_clip(row.path)
        tracked = run.answerer.track(clip)
        spans = {"whole recording": None, "bracketed contact": row.touched, "turn": row.turning}
        for span, frames in spans.items():
            case = titled(f"real {name}, {span}", half)
            part = tracked if frames is None else tracked.between(*frames)
            net = part.net(Component.TURN)
            for what, is_right in _turn_grades(row, net.mean):
                yield f"{case}: {what}", TRACK, is_right, row.object_family
            yield f"{case}: span", TRACK, net.holds(row.turn_deg), row.object_family
        # Rivals know no touch: they are given the contact.
        case = titled(f"real {name}, bracketed contact", half)
        for variant, rival in FITS.items():
            first, last = row.touched or (0, len(clip) - 1)
            idle = np.median(clip.frames[FIRST_IDLE : FIRST_IDLE + SURELY_IDLE], axis=0)
            part = clip.select(range(first, min(last + 1, len(clip))))
            part = replace(part, background=without_dots(idle.astype(np.uint8)))
            for what, is_right in _turn_grades(row, rival.fit(part).rotation_deg):
                yield f"{case}: {what}", variant, is_right, row.object_family
        run.progress(titled(f"tracks of {name}", half), done, len(rows))


def _turn_grades(row: DirectedRow, turn_deg: float) -> list[tuple[str, bool]]:
    off, true = abs(turn_deg - row.turn_deg), row.turn_deg
    is_near = off <= max(WITHIN_DEG, RELATIVE_TOLERANCE * abs(true))
    return [("direction", turn_deg * true > 0), ("how far", is_near)]


def _simulated_grades(run: Run, count: int) -> Iterator[Graded]:
    for done, stream in enumerate(streams(count, run.seed), start=1):
        for what, is_right in event_grades(stream, run.answerer.track(stream.clip)):
            yield f"simulated streams: {what}", TRACK, is_right, stream.object_name
        run.progress("simulated streams", done, count)


def event_grades(stream: Stream, track: Track) -> Iterator[tuple[str, bool]]:
    """Yield whether each readable motion of a stream was found, when, and in which order."""
    order, fps = [], stream.clip.fps
    for planned in stream.planned:
        if not planned.is_readable:
            continue
        event = _matching(planned, track.events)
        yield "event found", event is not None
        if event is None:
            yield "both ends", False
            continue
        order.append(event.begin)
        apart = max(abs(event.begin - planned.begin), abs(event.end - planned.end))
        yield "both ends", apart <= WITHIN_S * fps
    yield "order", order == sorted(order)
    turns = [planned for planned in stream.planned if planned.component is Component.TURN]
    if len(turns) == 1 and turns[0].is_readable:
        means = (event.amount.mean for event in track.events if event.kind is EventKind.TURN)
        yield "not told back", not any(mean * turns[0].twist.turn_deg < 0 for mean in means)


def _matching(planned: Planned, events: Sequence[Event]) -> Event | None:
    """Return the event of a motion's kind and way that overlaps it most; None without any."""

    def overlap(event: Event) -> int:
        return min(event.end, planned.end) - max(event.begin, planned.begin)

    def goes_along(event: Event) -> bool:
        own, true = event.twist, planned.twist
        if planned.component is Component.TURN:
            return own.turn_deg * true.turn_deg > 0
        return own.right_px * true.right_px + own.down_px * true.down_px > 0

    kind = KINDS[planned.component]
    likely = [e for e in events if e.kind is kind and overlap(e) > 0 and goes_along(e)]
    return max(likely, key=overlap, default=None)


TRACKS = Section(
    name="recordings",
    title="Whole recordings",
    about="""\
A recording from its first frame to its last, bracketed at its contact, and at its labelled turn:
the *direction* of the net turn; *how far*, within 5 degrees or a fifth of the label; whether the
told *span*, nine in ten, holds it. Optical flow and direct alignment are summed from frame to frame
over the same frames. Simulated streams hold several motions in a row: an event is *found* if one of
its kind and way overlaps it, its *ends* are right within 0.2 s, the *order* is that of the truth,
and a single turn is *not told back* by a turn the other way.""",
    run=_track_rows,
    views={"": (Pivot(right_with_interval, "recordings, what is graded"), every)},
)
