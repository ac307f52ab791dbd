"""Whole recordings: how far it turned in all, what happened when, and beside it two rivals.

Real ones are graded by turns measured by eye, between the frames these name. The tracker sees the
whole file, or no more than those frames and the idle gel.

Simulated streams hold several motions in a row, each with its exact beginning, end and amount: idle
gel, touch, then turns and slides with rests between them or none, release, idle gel.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from geotlm_lm.alignment.dots import without_dots
from geotlm_lm.benchmarks.cases import Half, by_half, recordings_by_half, rows_of_half, titled
from geotlm_lm.benchmarks.harness import Pivot, Row, Run, Section, whole
from geotlm_lm.benchmarks.judging import share_row
from geotlm_lm.benchmarks.rendering import right_with_interval, text
from geotlm_lm.benchmarks.variants import FITS
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.numbers import generator_for, seed_for
from geotlm_lm.core.tolerance import RELATIVE_TOLERANCE
from geotlm_lm.core.twist import Component, Twist
from geotlm_lm.data.touch_table import GoldTurn, Moment, Quality, read_gold_turns
from geotlm_lm.recordings.read import read_clip
from geotlm_lm.track.events import Event, EventKind, Span
from geotlm_lm.track.track import Track

if TYPE_CHECKING:
    from geotlm_lm.simulation.scene import Path, Scene

TRACK = "track"

WITHIN_DEG, WITHIN_S, STREAMS = 5.0, 0.2, 60

NARROW = 0.1
"""Share of a turn within which it is told well; a point of its curve is right within as much."""

WITHIN_MOMENT_S = 0.1
"""Off which a moment may be beside what its label is unsure of: a frame at 10 fps, 2.5 at 25, where
every fifth or sixth frame of many recordings repeats the one before."""

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


Grade = bool | float
"""Whether something is right, or a number of which the median is shown."""

Graded = tuple[str, str, Grade, str]
"""Case, variant, its grade, and the family that is resampled as a whole."""


def _track_rows(run: Run) -> Iterator[Row]:
    for name, half, real in recordings_by_half(run.real):
        turns = rows_of_half(read_gold_turns(real.folder), half)
        graded = [turn for turn in turns if turn.quality is not Quality.POOR]
        few = graded[: run.size(len(graded), 2)]
        yield from graded_rows(_real_grades(run, name, half, few), run.seed)
    yield from graded_rows(_simulated_grades(run, run.size(STREAMS, 4)), run.seed)


def graded_rows(graded: Iterable[Graded], seed: int) -> Iterator[Row]:
    """Yield shares of wrong answers and, as `detail["median"]`, medians, in order of appearance."""
    by_case: dict[tuple[str, str], list[tuple[Grade, str]]] = {}
    for case, variant, grade, family in graded:
        by_case.setdefault((case, variant), []).append((grade, family))
    for (case, variant), own in by_case.items():
        grades, families = zip(*own, strict=True)
        if isinstance(grades[0], bool | np.bool_):
            yield share_row(case, variant, grades, families, seed)
        else:
            median = float(np.median(grades))
            yield Row(case, variant, len(grades), detail={"median": median})


def _real_grades(run: Run, name: str, half: Half, turns: Sequence[GoldTurn]) -> Iterator[Graded]:
    for done, turn in enumerate(turns, start=1):
        clip, family = read_clip(turn.recording.path), turn.object_family
        first, last = turn.first_frame, turn.last_frame
        whole = run.answerer.track(clip).between(first, last)
        idle = np.median(clip.frames[turn.recording.surely_idle], axis=0).astype(np.uint8)
        part = replace(clip.select(range(first, last + 1)), background=idle)
        tracks = {"whole recording": whole, "bracketed": run.answerer.track(part)}
        for title, track in tracks.items():
            for what, grade in track_grades(turn, track):
                yield f"{titled(f'real {name}, {title}', half)}: {what}", TRACK, grade, family
        part = replace(part, background=without_dots(idle))
        for variant, rival in FITS.items():
            for what, grade in turn_grades(turn, rival.fit(part).rotation_deg):
                yield f"{titled(f'real {name}, bracketed', half)}: {what}", variant, grade, family
        run.progress(titled(f"tracks of {name}", half), done, len(turns))


def track_grades(turn: GoldTurn, track: Track) -> Iterator[tuple[str, Grade]]:
    """Yield what is graded of a track from the first labelled frame to the last."""
    net, slack = track.net(Component.TURN), turn.slack_deg
    yield from turn_grades(turn, net.mean)
    yield "span", net.low - slack <= turn.turn_deg <= net.high + slack
    if net.mean:
        yield "half-width of the span, share of its turn", (net.high - net.mean) / abs(net.mean)
    yield from _curve_grades(turn, track)
    ways = (
        ("half the turn", turn.half_turn, net.mean / 2),
        ("30 degrees", turn.past_30_deg, math.copysign(30.0, turn.turn_deg)),
    )
    for what, moment, way in ways:
        if moment is not None:
            passed = passed_s(track, way) if way * turn.turn_deg > 0 else None
            yield from _moment_grades(what, moment, passed, turn, track)


def turn_grades(turn: GoldTurn, turn_deg: float) -> Iterator[tuple[str, Grade]]:
    """Yield what is graded of an amount of degrees, clockwise positive."""
    off, true = abs(turn_deg - turn.turn_deg), abs(turn.turn_deg)
    yield "direction", turn_deg * turn.turn_deg > 0
    for what, share in (("within a fifth", RELATIVE_TOLERANCE), ("within a tenth", NARROW)):
        yield what, off <= max(WITHIN_DEG, share * true) + turn.slack_deg
    yield "error, degrees", off
    yield "ratio to the label", turn_deg / turn.turn_deg


def passed_s(track: Track, way_deg: float) -> float | None:
    """Return when a turn from the first frame on passes a way other than 0; None if it never does.

    In seconds, between frames by the straight line.
    """
    turned = track.path_from_start[:, 0] * math.copysign(1.0, way_deg)
    places = np.flatnonzero(turned >= abs(way_deg))
    if not len(places):
        return None
    step = slice(int(places[0]) - 1, int(places[0]) + 1)
    return float(np.interp(abs(way_deg), turned[step], track.times_s[step]))


def _curve_grades(turn: GoldTurn, track: Track) -> Iterator[tuple[str, Grade]]:
    for point in turn.curve:
        if point.frame == turn.first_frame:
            continue
        curves = track.path_from_start[:, 0], track.path_deviations[:, 0]
        span = Span(*(float(np.interp(point.frame, track.numbers, curve)) for curve in curves))
        off, slack = abs(span.mean - point.turn_deg), point.half_width_deg
        is_near = off <= max(WITHIN_DEG, NARROW * abs(point.turn_deg) + slack)
        yield "curve within a tenth", is_near
        yield "curve, error, degrees", off
        yield "curve's span", span.low - slack <= point.turn_deg <= span.high + slack


def _moment_grades(
    what: str, moment: Moment, passed: float | None, turn: GoldTurn, track: Track
) -> Iterator[tuple[str, Grade]]:
    """Yield grades of a moment; what is never passed is wrong, and no error in seconds."""
    if passed is None:
        yield f"{what} within 0.1 s", False
        return
    off = abs(passed - float(np.interp(moment.frame, track.numbers, track.times_s)))
    is_near = off <= WITHIN_MOMENT_S + moment.half_width / turn.recording.fps
    yield f"{what} within 0.1 s", is_near
    yield f"{what}, error, seconds", off


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


def _cell(row: Row) -> str:
    return text("median:.3f", row) if "median" in row.detail else right_with_interval(row)


TRACKS = Section(
    name="recordings",
    title="Whole recordings",
    about="""\
Real recordings are graded by turns measured by eye on key frames laid over each other, between the
first and the last labelled frame. The tracker sees the *whole recording*, or is given these frames
alone beside the idle gel (*bracketed*), as optical flow and direct alignment are, which are summed
from frame to frame. Graded are the *direction* of the net turn; whether it is *within a fifth* and
*within a tenth* of the label, or 5 degrees; whether the told *span*, nine in ten, holds the label.
What could be measured only fairly is allowed its own half-width besides, what could be measured
poorly is left out. Lines of errors, ratios and half-widths are medians.

Where the course of a turn was measured, its *curve* is graded at some seven frames, within 5
degrees, or a tenth beside the half-width of the label, which its span may be off too; and the
moments at which *half the turn* that is told, and *30 degrees*, are passed, within 0.1 s beside
what the label is unsure of. A moment that never comes is wrong, and has no error in seconds.

Simulated streams hold several motions in a row: an event is *found* if one of its kind and way
overlaps it, its *ends* are right within 0.2 s, the *order* is that of the truth, and a single turn
is *not told back* by a turn the other way.""",
    shares=whole(_track_rows),
    views=by_half(Pivot(_cell, "recordings, what is graded")),
)
