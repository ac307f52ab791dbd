"""Conditions in words: a gripper stopped by what its sensor sees, and recordings watched."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.answering import Answerer
from geotlm_lm.answering.monitor import Monitor
from geotlm_lm.benchmarks.cases import HALVES, recordings_by_half, rows_of_half, titled
from geotlm_lm.benchmarks.harness import Listing, Row, Run, Section, whole
from geotlm_lm.benchmarks.imprints import NOISE_GREY, SOURCES, Imprint, as_image
from geotlm_lm.core.clip import Frames
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.data.touch_table import GoldTurn, Quality, read_gold_turns
from geotlm_lm.recordings.read import read_clip
from geotlm_lm.simulation.gripper import Gripper, Task

SEEDS = 200
"""Grippers of each task, those of seeds 0 to 199: fixed before any of this was tuned."""

QUICK_SEEDS = 4
RATES_HZ, RATE_SEEDS = (12.5, 50.0), 40
"""Other frame rates, and how many of the grippers are tried at each."""

LONGEST_S = 9.0
"""Time after which a controller gives up."""

GOAL_DEG, SLIP_MM, NEAR_MM, CAUGHT_S = 3.0, 0.3, 0.1, 0.2
"""How far from the wanted angle is right; which slip is to be caught, how near to it both to stop
and to go on is right, and within which time."""

SURE = 0.5
"""Probability at which the gripper stops, or a moment is named: where it likely has come, early as
often as late."""

SLOWLY_DEG, SLOW = 10.0, 10.0
"""Turn that is left from which on it turns slowly, and how fast then, degrees a second."""

PULL_S = 4.0
"""For how long an object is pulled."""

WITHIN_S, LEAST_DEG = 0.3, 30.0
"""Off which a named moment may be beside what its label is unsure of, and the other turn waited
for."""

HELD_S, IDLE_S, SETTLED_S, RATE_HZ = 20.0, 1.0, 0.6, 25.0
"""How long an imprint is held, how long the gel is untouched before, when counting begins after the
touch, and the frame rate."""

WORDS = "conditions in words"
OTHERS: dict[str, Callable[[Gripper], float]] = {
    "counts the commanded angle": lambda gripper: gripper.commanded_deg,
    "knows the true angle": lambda gripper: gripper.turned_deg,
}
"""Controllers: by a condition, and by an angle that is known otherwise."""


@dataclass(frozen=True)
class Ended:
    """How a run of the loop ended."""

    gripper: Gripper
    stopped_s: float | None  # when the controller stopped; None where it did not
    due_s: float | None = None  # when it should have; None where never
    latency_ms: tuple[float, ...] = ()


def _watched(
    gripper: Gripper,
    monitors: Sequence[Monitor],
    rate: Callable[[], float],
    is_over: Callable[[], bool],
) -> Ended:
    """Move a gripper on, frame by frame, until the first monitor's condition holds.

    All see one track, and count from when the object is held.
    """
    first, *others = monitors
    latency = []
    while not is_over():
        was_ready = gripper.is_ready
        seen = gripper.step(rate())
        verdict = first.push(seen.frame, seen.time_s, seen.own_motion)
        for other in others:
            other.judged(seen.time_s, verdict.number, seen.own_motion)
        if gripper.is_ready and not was_ready:
            for monitor in monitors:
                monitor.begin()
        latency.append(verdict.latency_ms)
        if verdict.holds:
            return Ended(gripper, gripper.time_s, latency_ms=tuple(latency))
    return Ended(gripper, None, latency_ms=tuple(latency))


def turn_by_words(answerer: Answerer, gripper: Gripper) -> Ended:
    """Tighten until the sensor shows the cap turned far enough; slowly near the end."""
    goal, rate = gripper.setting.goal, gripper.setting.rate
    options = {"fps": gripper.fps, "sure": SURE, "since": "begin"}
    done = answerer.monitor(None, f"it has turned {goal:g} degrees clockwise", **options)
    words = f"it has turned {goal - SLOWLY_DEG:g} degrees clockwise"
    near = Monitor(done.tracker, answerer.condition(words), **options)
    return _watched(
        gripper,
        (done, near),
        lambda: min(rate, SLOW) if near.holds else rate,
        lambda: gripper.time_s >= LONGEST_S,
    )


def turn_by(gripper: Gripper, angle: Callable[[Gripper], float]) -> Ended:
    """Tighten until an angle that is known otherwise has come to the goal."""
    while gripper.time_s < LONGEST_S:
        gripper.step(gripper.setting.rate)
        if angle(gripper) >= gripper.setting.goal:
            return Ended(gripper, gripper.time_s)
    return Ended(gripper, None)


def pull_by_words(answerer: Answerer, gripper: Gripper) -> Ended:
    """Pull until the object slips too far."""
    frame = FrameSpec(mm_per_px=gripper.mm_per_px[0])  # the width of a pixel, as a user gives it
    condition = f"it slips by more than {SLIP_MM:g} mm"
    options = {"whose": "contact", "fps": gripper.fps, "sure": SURE, "since": "begin"}
    monitor = answerer.monitor(None, condition, frame=frame, **options)
    due = _slips_s(gripper.again())
    end_s = PULL_S if due is None else min(PULL_S, due + 1)
    rate = gripper.setting.rate
    ended = _watched(gripper, (monitor,), lambda: rate, lambda: gripper.time_s >= end_s)
    return replace(ended, due_s=due)


def _slips_s(gripper: Gripper) -> float | None:
    """Return when an object that is pulled on slips beyond what is allowed, if it clearly does."""
    due = None
    while gripper.time_s < PULL_S:
        gripper.step(gripper.setting.rate)
        if due is None and gripper.slid_mm > SLIP_MM:
            due = gripper.time_s
    return due if gripper.slid_mm >= SLIP_MM + NEAR_MM else None


def loosen_by_words(answerer: Answerer, gripper: Gripper) -> Ended:
    """Loosen until contact is lost."""
    monitor = answerer.monitor(None, "contact is lost", fps=gripper.fps, sure=SURE, since="begin")

    def is_over() -> bool:
        lost_s = gripper.lost_s
        return gripper.time_s >= LONGEST_S or (lost_s is not None and gripper.time_s > lost_s + 1)

    ended = _watched(gripper, (monitor,), lambda: -gripper.setting.rate, is_over)
    return replace(ended, due_s=gripper.lost_s)


def _loop_rows(run: Run) -> Iterator[Row]:
    seeds = run.size(SEEDS, QUICK_SEEDS)
    turned = list(_ended(run, "tighten", turn_by_words, seeds))
    yield _turn_row("all", WORDS, turned)
    for variant, angle in OTHERS.items():
        yield _turn_row("all", variant, [turn_by(each.gripper.again(), angle) for each in turned])
    for name, part in (("friction", "friction"), ("load", "load"), ("speed", "rate")):
        middle = float(np.median([getattr(each.gripper.setting, part) for each in turned]))
        sides: dict[str, list[Ended]] = {"low": [], "high": []}
        for each in turned:
            sides["high" if getattr(each.gripper.setting, part) > middle else "low"].append(each)
        for side, chosen in sides.items():
            yield _turn_row(f"{side} {name}", WORDS, chosen)
    for fps in run.size(RATES_HZ, ()):
        at_rate = list(_ended(run, "tighten", turn_by_words, RATE_SEEDS, fps))
        yield _turn_row(f"{fps:g} frames a second", WORDS, at_rate)
    yield from pull_rows(list(_ended(run, "pull", pull_by_words, seeds)))
    yield _loosen_row(list(_ended(run, "loosen", loosen_by_words, seeds)))


def _ended(
    run: Run,
    task: Task,
    controller: Callable[[Answerer, Gripper], Ended],
    seeds: int,
    fps: float = 25.0,
) -> Iterator[Ended]:
    for seed in range(seeds):
        run.progress(f"loop, {task} at {fps:g} Hz", seed, seeds)
        yield controller(run.answerer, Gripper(task, seed, fps))


def _turn_row(case: str, variant: str, ended: list[Ended]) -> Row:
    errors = np.array([each.gripper.turned_deg - each.gripper.setting.goal for each in ended])
    off = np.abs(errors)
    return _row(f"turned to the goal, {case}", variant, off <= GOAL_DEG, off, "deg", ended)


def pull_rows(ended: list[Ended]) -> Iterator[Row]:
    """Yield how many slips were caught in time, and how many pulls were not stopped without one."""
    slid = np.array([each.gripper.slid_mm for each in ended])
    lags = _lags_s(ended)
    due = np.array([each.due_s is not None for each in ended])
    # One that is stopped near to it, before it has slipped so far, is stopped rightly.
    is_caught = (lags <= CAUGHT_S + 1e-9) & (slid >= SLIP_MM - NEAR_MM)
    off = lags[due & np.isfinite(lags)]
    runs = [each for each in ended if each.due_s is not None]
    yield _row("slip beyond 0.3 mm caught within 0.2 s", WORDS, is_caught[due], off, "s", runs)
    is_early = (slid < SLIP_MM - NEAR_MM) & [each.stopped_s is not None for each in ended]
    yield _row("no stop at a slip below 0.2 mm", WORDS, ~is_early, slid[is_early], "mm", ended)


def _loosen_row(ended: list[Ended]) -> Row:
    lags = _lags_s(ended)
    is_right = np.abs(lags) <= CAUGHT_S + 1e-9
    off = lags[np.isfinite(lags)]
    return _row("lost contact known within 0.2 s", WORDS, is_right, off, "s", ended)


def _lags_s(ended: list[Ended]) -> NDArray[np.float64]:
    """Return by how much each stopped late; infinite where it should have and did not."""
    return np.array([np.inf if None in (each.stopped_s, each.due_s)
                     else each.stopped_s - each.due_s for each in ended])  # fmt: skip


def _row(
    case: str,
    variant: str,
    is_right: NDArray[np.bool_],
    off: NDArray[np.float64],
    unit: str,
    ended: list[Ended],
) -> Row:
    """Return what became of some runs: the share that is right, and how far off they are."""
    detail = {"unit": unit}
    if len(off):
        detail |= {"median": round(float(np.median(off)), 3), "worst": round(float(off.max()), 2)}
    latency = [each for run in ended for each in run.latency_ms]
    if latency:
        detail |= dict(zip(("ms_p50", "ms_p99"), spread_ms(latency), strict=True))
    return Row(case, variant, len(is_right), float(1 - np.mean(is_right)), detail=detail)


def spread_ms(latency: Sequence[float]) -> tuple[float, float]:
    """Return which times half and 99 of 100 frames keep within, ms."""
    half, most = np.quantile(latency, (0.5, 0.99))
    return round(float(half), 2), round(float(most), 1)


def _off(row: Row) -> str:
    if "median" not in row.detail:
        return "-"
    return "{median:g} / {worst:g} {unit}".format_map(row.detail)


def _latency(row: Row) -> str:
    return "{ms_p50:.1f} / {ms_p99:.0f}".format_map(row.detail) if "ms_p50" in row.detail else "-"


LOOP = Section(
    name="loop",
    title="A gripper stopped by conditions in words",
    about="""\
A simulated gripper turns a cap on a thread, pulls a load, and loosens a cap, through a sensor that
sees the object; the grip is elastic up to Coulomb's limit and slips beyond, the wrist has play of
up to 1.5 degrees that nobody measures. Object, gel, light, load, friction and speed are drawn from
fixed seeds. *In words*: "it has turned 90 degrees clockwise" with the wrist's commanded motion
beside the pictures, "it slips by more than 0.3 mm", "contact is lost"; each frame is judged before
the next. A turn is right within 3 degrees of its goal; a slip is caught where the pull ends at
0.2 mm or more, and at most 0.2 s after 0.3 mm are passed.""",
    shares=whole(_loop_rows),
    views={
        "": Listing(
            {
                "case": "case",
                "controller": "variant",
                "n": "count",
                "right": "right:.3f",
                "median / worst": _off,
                "ms, half / 99 of 100 frames": _latency,
            }
        )
    },
)


@dataclass
class _Watched:
    """What came of some streams."""

    alarms: int = 0
    streams: int = 0
    seconds: float = 0.0
    latency_ms: list[float] = field(default_factory=list)


def _watching_rows(run: Run) -> Iterator[Row]:
    latency: list[float] = []
    for name, half, real in recordings_by_half(run.real):
        turns = [turn for turn in rows_of_half(read_gold_turns(real.folder), half)
                 if turn.half_turn is not None and turn.quality is not Quality.POOR]  # fmt: skip
        if turns:
            yield from _moment_rows(run, titled(name, half), turns, latency)
    if run.real is not None:
        for half in HALVES:
            for title, watched in _held(run, run.real, half).items():
                yield _alarm_row(f"{title}, {half}", watched)
                latency += watched.latency_ms
    if latency:
        half_ms, most_ms = spread_ms(latency)
        outcome = f"{half_ms:.1f} ms, 99 of 100 within {most_ms:.0f} ms"
        yield Row("from a frame to its verdict", "latency", len(latency), outcome=outcome)


def _moment_rows(run: Run, case: str, turns: list[GoldTurn], latency: list[float]) -> Iterator[Row]:
    turns = turns[: run.size(len(turns), 2)]
    waited = {
        "half the turn is passed": [(turn, abs(turn.turn_deg) / 2, turn.half_turn)
                                    for turn in turns],
        "30 degrees are passed": [(turn, LEAST_DEG, turn.past_30_deg) for turn in turns
                                  if turn.past_30_deg is not None],
    }  # fmt: skip
    for what, asked in waited.items():
        delays, is_right = [], []
        for turn, angle, moment in asked:
            run.progress(case, len(delays), len(asked))
            clip = read_clip(turn.recording.path)
            way = "clockwise" if turn.turn_deg > 0 else "counterclockwise"
            condition = f"it has turned {angle:.0f} degrees {way}"
            monitor = run.answerer.monitor(None, condition, sure=SURE, since="begin", fps=clip.fps)
            frame = _first(monitor, clip.frames, clip.fps, turn.first_frame, latency)
            delay = np.inf if frame is None else (frame - moment.frame) / clip.fps
            delays.append(delay)
            is_right.append(abs(delay) <= WITHIN_S + moment.half_width / clip.fps)
        known = np.array([each for each in delays if np.isfinite(each)])
        yield Row(f"{case}: {what}", "named within 0.3 s", len(delays),
                  float(1 - np.mean(is_right)),
                  outcome=f"{np.median(known):+.2f} s median, {len(delays) - len(known)} never",
                  )  # fmt: skip


def _first(
    monitor: Monitor, frames: Frames, fps: float, begin: int, latency: list[float]
) -> int | None:
    """Return the first frame at which a condition holds, counted from frame `begin` on."""
    for number, frame in enumerate(frames):
        verdict = monitor.push(frame, number / fps)
        latency.append(verdict.latency_ms)
        if number == begin:
            monitor.begin()
        if verdict.holds:
            return number
    return None


def _held(run: Run, folder: Path, half: str) -> dict[str, _Watched]:
    """Watch held imprints for motion, and untouched gels for a touch."""
    held, idle = _Watched(), _Watched()
    seconds = run.size(HELD_S, 2.0)
    for kind in ("physiclear", "calibration"):
        for place, imprint in enumerate(SOURCES[kind](folder, half)):
            if place >= run.size(10**6, 2):
                break
            run.progress(f"held imprints, {half}", held.streams, held.streams + 1)
            rng = generator_for(run.seed, "held stream", kind, half, place)
            _watch(run.answerer, imprint, rng, seconds, "it moves", held)
            _watch(run.answerer, imprint, rng, seconds / 4, "something touches", idle)
    return {"held imprints": held, "untouched gels": idle}


def _watch(
    answerer: Answerer,
    imprint: Imprint,
    rng: np.random.Generator,
    seconds: float,
    condition: str,
    watched: _Watched,
) -> None:
    monitor = answerer.monitor(None, condition, since="begin", fps=RATE_HZ)
    begin_s = IDLE_S + SETTLED_S
    is_touched = condition == "it moves"
    for number in range(round((begin_s + seconds) * RATE_HZ)):
        time_s = number / RATE_HZ
        ground = imprint.idle[int(rng.integers(len(imprint.idle)))]
        if len(imprint.idle) == 1:
            ground = ground + rng.normal(0, NOISE_GREY, ground.shape)
        strength = float(np.clip((time_s - IDLE_S) / 0.2, 0, 1)) if is_touched else 0.0
        verdict = monitor.push(as_image(ground + strength * imprint.change), time_s)
        watched.latency_ms.append(verdict.latency_ms)
        if verdict.holds or number == round(begin_s * RATE_HZ):
            watched.alarms += verdict.holds
            monitor.begin()
    watched.streams += 1
    watched.seconds += seconds


def _alarm_row(case: str, watched: _Watched) -> Row:
    minutes = watched.seconds / 60
    outcome = f"{watched.alarms} in {minutes:.1f} min, {10 * watched.alarms / minutes:.2f} in ten"
    return Row(case, "false alarms", watched.streams, outcome=outcome)


WATCHING = Section(
    name="watching",
    title="Conditions on real recordings",
    about="""\
"It has turned 40 degrees clockwise", half of each turn measured by eye, and 30 degrees, waited for
from the first labelled frame on; the moment named, at a probability of one half, is right within
0.3 s and what its label is unsure of. False alarms at 0.95: of motion where real imprints are held
over their own idle frames in random order, of touch where nothing touches. Latency on one core,
tracking included.""",
    shares=whole(_watching_rows),
    views={
        "": Listing(
            {"case": "case", "what": "variant", "n": "count", "right": "right:.3f", "": "outcome"}
        )
    },
)
