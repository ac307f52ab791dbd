"""What an answer, a command and a simulated clip cost in time and memory, against their errors.

Times run from the clip in memory to the motion. The model's read-outs share a perception, as
several questions about one clip do; each counts its time in full. The simulator's times are of the
whole surface at image resolution, without profile and rendering.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from geotlm_lm.backbone.imprint import imprint_of
from geotlm_lm.backbone.motions import motions_of
from geotlm_lm.backbone.stem import measure_clip
from geotlm_lm.benchmarks.cases import (
    TASKS,
    by_task,
    real_recordings,
    rows_of_half,
    simulated_cases,
    task_of,
    window_cases,
)
from geotlm_lm.benchmarks.damaged import write_video
from geotlm_lm.benchmarks.harness import Listing, Row, Run, Section, whole
from geotlm_lm.benchmarks.judging import (
    Case,
    Variant,
    ask_all,
    milliseconds,
    rows_of_replies,
)
from geotlm_lm.benchmarks.rendering import save_figure
from geotlm_lm.benchmarks.stability import scene_of
from geotlm_lm.benchmarks.variants import FITS, GENERATED, PROBE, QUESTION, all_variants, rival
from geotlm_lm.checkpoint import reading_of
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import FRAME_COUNT, IMAGE_SIDE
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.numbers import seed_for
from geotlm_lm.core.process import THREAD_VARIABLES
from geotlm_lm.motion.measured import measured
from geotlm_lm.motion.network import belief_of_one
from geotlm_lm.probe.rigid_flow import RigidFlow
from geotlm_lm.simulation.camera import idle_frame
from geotlm_lm.simulation.contact import PRESETS, Preset, dome_mm
from geotlm_lm.simulation.optics import lit
from geotlm_lm.simulation.profile import Profile, build_profile
from geotlm_lm.simulation.scene import Scene
from geotlm_lm.simulation.surface import pressed_surface
from geotlm_lm.simulation.touch import Touch, simulate_touch

LINE, SENTENCE = "way all", "It turns clockwise, about 12 degrees, in the camera image."
"""What `QUESTION` asks, and an answer to it."""

FOUR, PAIRS = "four frames", "pairs"

CaseSet = tuple[str, tuple[Motion, ...], list[Case]]
"""Title of cases of one source and number of frames, the motions in question, the cases."""

COMMAND = (
    "import atexit, runpy; held = lambda: [x for x in open('/proc/self/status') if 'VmHWM' in x]; "
    "atexit.register(lambda: print(*held())); runpy.run_module('geotlm_lm', run_name='__main__')"
)
"""A command that last prints the most memory it ever held, where there is Linux to tell it."""

Way = Callable[[], Any]

Fields = tuple[NDArray[np.float32], NDArray[np.float32] | None]
"""Indentation (frames, side, side) and drift (frames, 2, side, side), mm; no drift if not asked."""

Solve = Callable[[Scene, Profile], Fields]

HEIGHT, DRIFT, IMAGE = "height, um RMS", "drift, relative L2", "image, grey RMS"
"""What is held against the reference."""


def in_turn(ways: Mapping[str, Way], repeats: int) -> dict[str, list[tuple[Any, float]]]:
    """Return the result and the milliseconds of every repeat of every way.

    Another way begins each round, and the first round is not counted.
    """
    runs: dict[str, list[tuple[Any, float]]] = {name: [] for name in ways}
    names = list(ways)
    for turn in range(repeats + 1):
        first = turn % len(names)
        for name in (*names[first:], *names[:first]):
            started = time.perf_counter()
            result = ways[name]()
            if turn:
                runs[name].append((result, 1e3 * (time.perf_counter() - started)))
    return runs


def with_front(rows: Sequence[Row]) -> list[Row]:
    """Return rows of one case that tell whether none beats them in both error and median time."""

    def is_on_front(own: Row) -> bool:
        better = [row for row in rows if row.error <= own.error and row.ms_p50 <= own.ms_p50]
        return all((row.error, row.ms_p50) == (own.error, own.ms_p50) for row in better)

    return [replace(row, detail={**row.detail, "is_on_front": is_on_front(row)}) for row in rows]


def _method_rows(run: Run) -> Iterator[Row]:
    presets = ("ultrafast", "fast", "medium")  # of OpenCV's flow, by number
    fits = {f"optical flow, {name}": RigidFlow(place) for place, name in enumerate(presets)}
    fits |= {name: fit for name, fit in FITS.items() if not isinstance(fit, RigidFlow)}
    methods = {name: rival(fit.predict) for name, fit in fits.items()}
    own = all_variants(run.answerer, run.seed)
    methods |= {"linear probe": own[PROBE], "words": own[GENERATED]}
    for case_set in case_sets(run):
        run.progress(f"methods: {case_set[0]}", 0, 1)
        yield from rows_in_turn(methods, case_set, run.size(3, 1), run.seed)


def rows_in_turn(
    methods: Mapping[str, Variant], case_set: CaseSet, repeats: int, seed: int
) -> list[Row]:
    """Put every case to every method in turn, `repeats` rounds."""
    title, among, cases = case_set
    runs = in_turn({title: partial(ask_all, methods, cases, among)}, repeats)[title]
    rows = []
    for row in rows_of_replies(title, runs[0][0], seed=seed):
        ms = [reply.milliseconds for result, _ in runs for reply in result.replies[row.variant]]
        rows.append(replace(row, detail={}, **milliseconds(ms)))
    return with_front(rows)


def case_sets(run: Run) -> Iterator[CaseSet]:
    """Yield simulated and, if there are any, real clips: four frames, and the first and last."""
    for task in ("rotation", "sliding"):
        seed = seed_for(run.seed, "runtime", task)
        cases = list(simulated_cases(task, run.size(60, 2), seed))
        yield (f"simulated {task}, {FOUR}", TASKS[task], cases)
        yield (f"simulated {task}, {PAIRS}", TASKS[task], _pairs(cases))
    for name, recordings in real_recordings(run.real).items():
        for part, real in by_task(recordings).items():
            rows = rows_of_half(real.rows, "report")
            few = rows[:: -(-len(rows) // run.size(40, 1)) or 1]
            title, among = f"real {name}{part}, report", task_of(real.rows)
            cases = list(window_cases(replace(real, rows=few)))
            four, pair = ([x for x in cases if x.tags["frames"] == n] for n in ("four", "pair"))
            yield (f"{title}, {FOUR}", among, four)
            # A recorded pair is shown as a, a, b, b.
            yield (f"{title}, {PAIRS}", among, _pairs(pair))


def _pairs(cases: Sequence[Case]) -> list[Case]:
    return [replace(case, clip=case.clip.select([0, FRAME_COUNT - 1])) for case in cases]


def runtime_clip(run: Run) -> Clip:
    """Return a simulated turn of four frames with a background."""
    return next(simulated_cases("rotation", 1, seed_for(run.seed, "runtime", "rotation"))).clip


def long_recording(clip: Clip) -> Clip:
    """Return 5 s at 25 fps, the idle gel and then the clip: what is tracked."""
    return Clip(np.repeat(np.concatenate([clip.background[None], clip.frames]), 25, axis=0))


@torch.no_grad()
def _stage_rows(run: Run) -> Iterator[Row]:
    clip, bundle = runtime_clip(run), run.answerer.bundle
    model, speaker, recording = bundle.model, bundle.speaker, long_recording(clip)
    imprint, stem = imprint_of(clip), measure_clip(clip)
    inputs, motions = (torch.from_numpy(x)[None] for x in (stem.inputs, stem.motions.numbers()))
    tokens = model.backbone.encode_inputs(inputs)
    perception = model.fuse(tokens)
    token, geometry = perception.fused_token, perception.geometry
    belief = belief_of_one(bundle.motion(measured(inputs, motions, geometry, token)))
    reading = reading_of(token, [belief])[0].numpy()
    prefix = speaker.prefix(reading)
    ways = {
        "track of 125 frames": lambda: run.answerer.track(recording),
        "stem": lambda: measure_clip(clip),
        "of it: the imprint": lambda: imprint_of(clip),
        "of it: rigid motions": lambda: motions_of(imprint),
        "backbone": lambda: model.backbone.encode_inputs(inputs),
        "DGR and fused token": lambda: model.fuse(tokens),
        "linear probe": lambda: model.probe.predict(token),
        "belief": lambda: bundle.motion(measured(inputs, motions, geometry, token)),
        "question read": lambda: bundle.reader.read(QUESTION),
        "language model's slots": lambda: speaker.prefix(reading),
        "its sentence, compared": lambda: speaker.says(prefix, QUESTION, LINE, SENTENCE),
    }
    repeats = run.size(30, 1)
    for name, runs in in_turn(ways, repeats).items():
        yield Row("one clip", name, repeats, **milliseconds([ms for _, ms in runs]))


def _command_rows(run: Run) -> Iterator[Row]:
    bundle = () if run.model is None else ("--model", str(run.model))
    with tempfile.TemporaryDirectory() as folder:
        touch = simulate_touch(Touch(twist_deg=12.0)).clip
        clip, film = f"{folder}/clip.npz", f"{folder}/film.avi"
        np.savez_compressed(clip, frames=touch.frames, background=touch.background)
        write_video(Path(film), "MJPG", long_recording(touch).frames)
        commands = {
            "--help": ("--help",),
            "answer": ("answer", "--clip", clip, "--q", QUESTION, *bundle),
            "chat, one question": ("chat", "--clip", clip, *bundle),
            "watch, 5 s recorded": ("watch", "--source", film, *bundle),
        }
        ways = {name: partial(run_fresh, COMMAND, *words) for name, words in commands.items()}
        for name, runs in in_turn(ways, run.size(5, 1)).items():
            held = [int(line.split()[1]) for line in runs[0][0] if line.startswith("VmHWM")]
            peak, times = held[0] / 2**10 if held else None, milliseconds([ms for _, ms in runs])
            yield Row("one fresh process", name, len(runs), memory_mib=peak, **times)


def run_fresh(code: str, *words: str) -> list[str]:
    """Run Python code on one thread, `QUESTION` typed in; return the lines it printed."""
    own = {**os.environ, **dict.fromkeys(THREAD_VARIABLES, "1")}
    line, typed = [sys.executable, "-c", code, *words], f"{QUESTION}\n"
    done = subprocess.run(line, input=typed, stdout=subprocess.PIPE, text=True, env=own, check=True)
    return done.stdout.splitlines()


def moving(body: str, **amount: float) -> Scene:
    """Return a body that slides, turns or is pressed, 0.6 mm deep."""
    gel = {"thickness_mm": 4.0, "poisson_ratio": 0.48, "friction": 0.5}
    return scene_of(4, body=body, **{"turn_deg": 0.0} | amount, **gel)


def scenes() -> dict[str, Scene]:
    """Return a ball, a ridged key and a nut: twisted by 9 degrees, slid by 0.9 mm, pressed."""
    moves = {"twist": {"turn_deg": 9.0}, "slide": {"x_mm": 0.9}, "press": {"from_mm": 0.2}}
    return {
        f"{name}, {move}": moving(body, **amount)
        for name, body in (("ball", "ball_medium"), ("key", "key"), ("nut", "hex_nut"))
        for move, amount in moves.items()
    }


def solved(preset: Preset, scene: Scene, profile: Profile, *, with_drift: bool = True) -> Fields:
    """Return what a preset makes of a scene."""
    surface = pressed_surface(scene, profile, preset, with_drift=with_drift)
    return surface.indentation_mm, surface.drift_mm


def overlap(scene: Scene, profile: Profile) -> Fields:
    """Return the body's overlap with the gel at rest as its indentation, and no drift."""
    path, optics = scene.path, scene.optics
    mm_per_px = (optics.mm_per_px_x, optics.mm_per_px_y)
    dome = dome_mm(scene.gel, mm_per_px, IMAGE_SIDE, optics.mounting)
    poses = zip(path.depth_mm, path.x_mm, path.y_mm, path.rotation_rad, strict=True)
    reached = [d - dome - profile.sample(pose, mm_per_px, IMAGE_SIDE) for d, *pose in poses]
    return np.maximum(np.stack(reached), 0).astype(np.float32), None


SOLVERS: dict[str, Solve] = {
    **{name: partial(solved, PRESETS[name]) for name in ("accurate", "good", "fast", "draft")},
    "half-space, 64 cells": partial(solved, replace(PRESETS["good"], is_half_space=True)),
    "geometric overlap": overlap,
}


def _simulator_rows(run: Run) -> Iterator[Row]:
    chosen = scenes() if not run.is_quick else {"ball, slide": moving("ball_medium", x_mm=0.9)}
    yield from error_rows(chosen, SOLVERS, run.size("reference", "good"), run.size(3, 1))


def error_rows(
    chosen: Mapping[str, Scene], solvers: Mapping[str, Solve], reference: str, repeats: int
) -> Iterator[Row]:
    """Yield a row per measure and solver: medians over the scenes, their range in the detail.

    The preset `reference` counts as exact and runs once, the solvers `repeats` times in turn.
    """
    errors: dict[str, dict[str, list[float]]] = {name: {} for name in (HEIGHT, DRIFT, IMAGE)}
    times: dict[str, list[float]] = {}
    for scene in chosen.values():
        profile = build_profile(scene.body)
        started = time.perf_counter()
        exact = solved(PRESETS[reference], scene, profile)
        once = {reference: [(exact, 1e3 * (time.perf_counter() - started))]}
        ways = {name: partial(solve, scene, profile) for name, solve in solvers.items()}
        for name, runs in (once | in_turn(ways, repeats)).items():
            times.setdefault(name, []).append(median(ms for _, ms in runs))
            for measure, error in differences(scene, runs[0][0], exact).items():
                errors[measure].setdefault(name, []).append(error)
    for measure, by_name in errors.items():
        rows = []
        for name, own in by_name.items():
            detail, ms = {"range": [min(own), max(own)]}, median(times[name])
            rows.append(Row(measure, name, len(own), median(own), ms_p50=ms, detail=detail))
        yield from with_front(rows)


def differences(scene: Scene, fields: Fields, exact: Fields) -> dict[str, float]:
    """Return how far height, image and, where both tell it, drift are from what is exact."""
    idle = idle_frame(scene.optics.idle)
    image, true_image = (
        np.stack([lit(frame, idle, scene.optics) for frame in indentation_mm])
        for indentation_mm, _ in (fields, exact)
    )
    apart = {HEIGHT: 1e3 * _rms(fields[0] - exact[0]), IMAGE: _rms(image - true_image)}
    if fields[1] is not None and exact[1] is not None:
        # From the first frame on: the spread of the first press is no shear.
        moved, true_moved = (drift[1:] - drift[:1] for _, drift in (fields, exact))
        off = float(np.linalg.norm(moved - true_moved))
        apart[DRIFT] = off / float(np.linalg.norm(true_moved))
    return apart


def _rms(values: NDArray[np.floating]) -> float:
    return float(np.sqrt(np.square(values).mean()))


def draw_fronts(cases: str, scale: str, rows: Sequence[Row], path: Path) -> None:
    """Draw error over median time by case, the front as a line; a "log" scale shows no 0."""
    from matplotlib.figure import Figure

    shown = [row for row in rows if row.case.endswith(cases) and (row.error or scale == "linear")]
    titles = list(dict.fromkeys(row.case for row in shown))
    names = list(dict.fromkeys(row.variant for row in shown))
    lines = -(-len(titles) // 2)
    figure = Figure(figsize=(8, 2.6 * lines + 1.2), layout="constrained")
    for place, title in enumerate(titles, start=1):
        axes = figure.add_subplot(lines, 2, place)
        own = [row for row in shown if row.case == title]
        for row in own:
            at = names.index(row.variant)
            axes.plot(row.ms_p50, row.error, "os^D"[at // 10], c=f"C{at}", label=row.variant)
        front = sorted((row.ms_p50, row.error) for row in own if row.detail["is_on_front"])
        if front:
            axes.step(*zip(*front, strict=True), where="post", color="black", zorder=0)
        axes.set(xscale="log", yscale=scale, title=title, xlabel="ms per clip", ylabel="error")
        axes.grid(alpha=0.3)
    legend = figure.axes[0].get_legend_handles_labels()
    figure.legend(*legend, loc="outside lower center", ncols=3, fontsize="small")
    save_figure(figure, rows, path)


_TIMED = {
    "what": lambda row: row.variant + " *" * row.detail.get("is_on_front", False),
    "ms, median": "ms_p50:.1f",
    "p95": "ms_p95:.1f",
}
_METHODS = Listing(
    {"clips": "case", "n": "count"}
    | _TIMED
    | {"error": "error:.3f", "95 %": lambda row: "{:.3f}-{:.3f}".format(*row.interval)}
)
_PRESETS = Listing(
    {
        "compared": "case",
        "what": _TIMED["what"],
        "ms": "ms_p50:.1f",
        "error": "error:.3g",
        "range": lambda row: "{:.2g} to {:.2g}".format(*row.detail["range"]),
    }
)

METHODS = Section(
    name="methods",
    title="Ways to name a motion",
    about="""\
Every method is put to every clip in turn, on one thread, from the clip in memory to the motion.
Words may name any of ten motions, the others choose among the task's. `*` marks what nothing beats
in both error and median time.""",
    shares=whole(_method_rows),
    views={
        "Simulated clips": replace(_METHODS, shows=lambda row: row.case.startswith("simulated")),
        "Real recordings": replace(_METHODS, shows=lambda row: row.case.startswith("real")),
    },
    figure=partial(draw_fronts, FOUR, "linear"),
)

STAGES = Section(
    name="stages",
    title="Stages of an answer",
    about="Each stage alone on one clip, one thread; one prompt serves all ten scores.",
    shares=whole(_stage_rows),
    views={"": Listing(_TIMED)},
)

COMMANDS = Section(
    name="commands",
    title="Cold starts of the commands",
    about="Fresh processes on one thread, files cached; MiB is the most they ever held.",
    shares=whole(_command_rows),
    views={"": Listing(_TIMED | {"MiB": "memory_mib:.0f"})},
)

SIMULATOR = Section(
    name="simulator",
    title="Simulator",
    about="""\
Presets and two shortcuts against the reference preset on a ball, a key and a nut that are twisted,
slid or pressed: medians and ranges over nine scenes, one thread, surfaces alone.""",
    shares=whole(_simulator_rows),
    views={"": _PRESETS},
    figure=partial(draw_fronts, "", "log"),
)
