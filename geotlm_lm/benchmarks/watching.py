"""Conditions watched on real recordings: when they hold, how soon, and how often for nothing."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from geotlm_lm.answering import Answerer
from geotlm_lm.answering.monitor import Monitor
from geotlm_lm.benchmarks.carrying import as_image
from geotlm_lm.benchmarks.cases import HALVES, recordings_by_half, rows_of_half, titled
from geotlm_lm.benchmarks.harness import Listing, Row, Run, Section
from geotlm_lm.benchmarks.imprints import NOISE_GREY, SOURCES, Imprint
from geotlm_lm.benchmarks.loop import spread_ms
from geotlm_lm.core.clip import Frames
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.data.touch_table import GoldTurn, Quality, read_gold_turns
from geotlm_lm.recordings.read import read_clip

SURE = 0.5
"""Probability at which a moment is named: where it has likely come."""

WITHIN_S, LEAST_DEG = 0.3, 30.0
"""Off which a named moment may be beside what its label is unsure of, and the other turn waited
for."""

HELD_S, IDLE_S, SETTLED_S, RATE_HZ = 20.0, 1.0, 0.6, 25.0
"""How long an imprint is held, how long the gel is untouched before, when counting begins after the
touch, and the frame rate."""


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
    run=_watching_rows,
    views={
        "": (
            Listing(
                {
                    "case": lambda row: row.case,
                    "what": lambda row: row.variant,
                    "n": lambda row: str(row.count),
                    "right": lambda row: "-" if row.right is None else f"{row.right:.3f}",
                    "": lambda row: row.outcome,
                }
            ),
            lambda row: True,
        )
    },
)
