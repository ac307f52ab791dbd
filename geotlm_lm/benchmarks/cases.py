"""Clips with known motions that variants are judged on: simulated, real, public and semi-real.

Simulated clips show everyday objects that no weight was trained on. Real ones are windows of
labelled recordings, split in halves by what is touched. A semi-real clip carries the imprint of a
real touch (its change against the idle gel) over that gel by a known path, with fresh noise; it
lacks the change of lighting from place to place and the gel's creep.
"""

from __future__ import annotations

import hashlib
import tomllib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.benchmarks.harness import Listing, Pivot, Row
from geotlm_lm.benchmarks.judging import Case
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.edit import Edit, opposite
from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.core.labels import DIRECTED, ROTATIONS, SLIDES, Motion
from geotlm_lm.core.numbers import generator_for, seed_for
from geotlm_lm.data import tactile_tracking as tracking
from geotlm_lm.data.labelled_recordings import (
    LabelledRecordings,
    WindowRow,
    find_labelled_recordings,
)
from geotlm_lm.data.manifest import Manifest, read_manifest
from geotlm_lm.data.tactile_tracking import (
    TactileTracking,
    Trial,
    is_tactile_tracking,
    pair_clip,
    read_tactile_tracking,
)
from geotlm_lm.data.touch_table import TouchRow
from geotlm_lm.recordings.read import read_clip

if TYPE_CHECKING:
    from geotlm_lm.simulation.simulate import SimulatedClip

TASKS: dict[str, tuple[Motion, ...]] = {
    "rotation": ROTATIONS,
    "sliding": SLIDES,
    "all": tuple(Motion),
}
"""The paper's two tasks, and all ten motions together."""

MOST_TRIES = 6
"""Scenes simulated per clip asked for, at most: a bound on a search, not an expected number."""

Half = Literal["tune", "report"]
HALVES: tuple[Half, ...] = ("report", "tune")
"""Of the real recordings: what is reported, and what thresholds and bundles are chosen by."""

LISTED = tomllib.loads(Path(__file__).with_name("halves.toml").read_text(encoding="utf-8"))
"""Families by half, with the salt of those that are not listed."""

TUNE_TITLE = "Of the half that things are chosen by"
"""Over the tables of `tune`, which are never mixed with those of `report`."""

PAIRS_PER_TRIAL = 50
"""Pairs of each trial judged per task at most, evenly through it: neighbouring ones are nearly the
same, and the paper's totals are 49 and 76 a trial."""

DataSet = TactileTracking | Manifest

TrackedPairs = Sequence[tuple[Trial, Sequence[tracking.LabelledPair]]]

Floats = NDArray[np.float32]

TRAVEL_SHARE, SIDEWAYS_SHARE, TURN_DEG = (0.02, 0.12), 0.4, 2.0
"""Travel relative to the width of the view, 0.4 to 2.4 mm of a GelSight Mini's 20 mm; travel across
it at most, relative to it; and turn on the way at most: hands never slide quite straight."""

NOISE_GREY = 0.4
"""Fresh noise of each frame; the recordings' own, after their codec, is 0.25 to 0.4 grey levels."""

BORDER_SHARE, MOST_AT_BORDER = 0.05, 0.35
"""Width of the image's border relative to its width, and RMS change there relative to the whole
image's, above which an imprint is cut off: moved, its straight cut would be seen."""

LEAST_CHANGE_GREY, PRESS_FROM = 1.5, 0.25
"""RMS change over the image below which there is no imprint worth moving, and strength a press
begins at, relative to the recorded touch."""

_TOWARDS = {Motion.LEFT: (-1, 0), Motion.RIGHT: (1, 0), Motion.UP: (0, -1), Motion.DOWN: (0, 1)}


def simulated_clips(
    task: str, count: int, seed: int, left_out: Counter[str] | None = None
) -> Iterator[SimulatedClip]:
    """Yield readable simulated clips of a task, with the whole truth about them.

    `left_out["unreadable_left_out"]` counts those whose images do not show the motion.
    """
    from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS
    from geotlm_lm.simulation.simulate import simulate_series

    yielded = 0
    root, most = seed_for(seed, "evaluation", task), MOST_TRIES * count
    for made in simulate_series(root, most, objects=EVERYDAY_OBJECTS, motions=TASKS[task]):
        if made.label.is_readable:
            yield made
            yielded += 1
            if yielded == count:
                return
        elif left_out is not None:
            left_out["unreadable_left_out"] += 1


def simulated_cases(
    task: str, count: int, seed: int, left_out: Counter[str] | None = None
) -> Iterator[Case]:
    """Yield the same clips as cases."""
    for made in simulated_clips(task, count, seed, left_out):
        yield Case(made.clip, made.label.motion, made.object_name, made.object_name)


def half_of(family: str) -> Half:
    """Return the half of a family of objects: as halves.toml says, else by its hash."""
    family = LISTED["same"].get(family, family)
    digest = hashlib.sha256(f"{LISTED['salt']}:{family}".encode()).digest()
    hashed: Half = "report" if digest[0] % 2 else "tune"
    return next((half for half in HALVES if family in LISTED[half]), hashed)


def rows_of_half(rows: Iterable[Any], half: Half | None) -> tuple[Any, ...]:
    """Return the rows of a half, by their `object_family`; all for None."""
    return tuple(row for row in rows if half in (None, half_of(row.object_family)))


def titled(title: str, half: Half | None) -> str:
    """Return the title of a set of a half's clips."""
    return title if half is None else f"{title}, {half}"


def is_reported(row: Row) -> bool:
    """Whether a row is not of the half that things are chosen by."""
    return f", {HALVES[1]}" not in row.case


def by_half(view: Listing | Pivot) -> dict[str, tuple[Listing | Pivot, Callable[[Row], bool]]]:
    """Return the views of a section whose halves are never shown in one table."""
    return {"": (view, is_reported), TUNE_TITLE: (view, lambda row: not is_reported(row))}


def real_recordings(folder: Path | None) -> dict[str, LabelledRecordings]:
    """Return the labelled recordings of `folder`, or of each folder inside, by folder name.

    Raises:
        UnreadableClip: If there are none, or none with a usable direction.
    """
    if folder is None:
        return {}
    recordings = find_labelled_recordings(folder)
    usable = {own.folder.resolve().name: own for own in recordings if own.rows}
    if not usable:
        skipped = sum((own.skipped for own in recordings), Counter())
        if not skipped:
            raise UnreadableClip(
                f"{folder}: the tables of windows hold no row; write one row per motion."
            )
        raise UnreadableClip(
            f"{folder}: no row has a usable direction (left out: {dict(skipped)}); expected one of "
            f"{', '.join(Motion)}."
        )
    return usable


def recordings_by_half(folder: Path | None) -> Iterator[tuple[str, Half, LabelledRecordings]]:
    """Yield each folder of labelled recordings by name, once for each half with its rows."""
    for name, real in real_recordings(folder).items():
        for half in HALVES:
            yield name, half, replace(real, rows=rows_of_half(real.rows, half))


def by_task(recordings: LabelledRecordings) -> dict[str, LabelledRecordings]:
    """Split recordings whose labels are of more than one task, so that each is asked as a task.

    The keys are what to add to the name: nothing where all labels are of one task.
    """
    others = tuple(motion for motion in Motion if motion not in DIRECTED)
    tasks = {" rotation": ROTATIONS, " sliding": SLIDES, " without direction": others}
    parts = {
        name: tuple(row for row in recordings.rows if row.motion in among)
        for name, among in tasks.items()
    }
    kept = {name: rows for name, rows in parts.items() if rows}
    if len(kept) == 1:
        return {"": recordings}
    return {name: replace(recordings, rows=rows) for name, rows in kept.items()}


def task_of(rows: Iterable[WindowRow]) -> tuple[Motion, ...]:
    """Return the smallest task that holds every label."""
    held = {row.motion for row in rows}
    return next(x for x in (ROTATIONS, SLIDES, DIRECTED, tuple(Motion)) if held <= set(x))


def window_cases(recordings: LabelledRecordings) -> Iterator[Case]:
    """Yield each window as four frames and as a pair, both forwards and backwards."""
    for window in recordings.windows(frames=("four", "pair"), backwards=True):
        tags = {
            "frames": window.frames,
            "played": "backwards" if window.is_backwards else "forwards",
            "fps": "unknown" if window.clip.fps is None else f"{window.clip.fps:g}",
        }
        row = window.row
        yield Case(window.clip, window.motion, row.object_id, row.object_family, tags)


def held_across(case: Case) -> Case:
    """Show a clip as a sensor held across records it, turned by 90 degrees counterclockwise."""
    return replace(
        case, clip=turned_by_quarter(case.clip), motion=Edit.of("quarter-ccw").of_way(case.motion)
    )


def turned_by_quarter(clip: Clip) -> Clip:
    """Return a clip turned by 90 degrees counterclockwise."""
    frames = np.ascontiguousarray(np.rot90(clip.frames, axes=(1, 2)))
    idle = clip.background
    idle = None if idle is None else np.ascontiguousarray(np.rot90(idle))
    return replace(clip, frames=frames, background=idle)


def open_data_sets(paths: Sequence[Path]) -> dict[str, DataSet]:
    """Read TactileTracking's folders and manifests; return them by the names their tables get.

    Raises:
        UnreadableClip: If a path is neither, or nothing in it can be used.
        UsageError: If two have one name.
    """
    opened: dict[str, DataSet] = {}
    for path in paths:
        if is_tactile_tracking(path):
            data_set = read_tactile_tracking(path)
            name = f"TactileTracking {data_set.folder.resolve().name}"
        elif path.is_dir():
            raise UnreadableClip(
                f"{path}: holds no trials of TactileTracking, expected folders with poses; give "
                f"another folder, a manifest's file, or labelled recordings with --real."
            )
        else:
            data_set = read_manifest(path)
            name = f"manifest {data_set.path.stem}"
        if name in opened:
            raise UsageError(f"{path}: another data set is called '{name}' too; rename one.")
        opened[name] = data_set
    return opened


def listed_cases(manifest: Manifest, among: Sequence[Motion]) -> Iterator[Case]:
    """Yield the clips of a manifest that show motions of a task, each read whole."""
    for row, clip in manifest.clips(among):
        tags = {"sensor": row.sensor or "unnamed"}
        yield Case(clip, row.motion, row.object_id, row.object_id, tags)


def tracked_pairs(data: TactileTracking, task: str) -> tuple[TrackedPairs, dict[str, Any]]:
    """Choose the pairs to judge, and tell how: no method has seen a pair by then.

    The paper gives the number of its pairs and no threshold. The rule of the sweep is taken that
    comes nearest to that number, in proportion to the trials that are here.
    """
    usual = tracking.PairRule()
    swept = tracking.sweep_pair_counts(data.trials, usual, task)
    target = tracking.PAPER_PAIRS[task] * len(data.trials) / tracking.PAPER_TRIALS
    chosen = tracking.nearest_rule(swept, usual, task, target)
    labelled = [(trial, tracking.labelled_pairs(trial, chosen, task)) for trial in data.trials]
    judged = [(trial, tracking.evenly_spaced(own, PAIRS_PER_TRIAL)) for trial, own in labelled]
    facts = {
        "rule": asdict(chosen),
        "found": sum(len(own) for _, own in labelled),
        "paper": tracking.PAPER_PAIRS[task],
        "paper_share": len(data.trials) / tracking.PAPER_TRIALS,
    }
    return judged, facts


def pair_cases(pairs: TrackedPairs) -> Iterator[Case]:
    """Yield pairs of frames of TactileTracking's trials, as clips a, a, b, b."""
    for trial, own in pairs:
        recording = trial.recording() if own else None
        for pair in own:
            clip = pair_clip(recording, trial, pair)
            yield Case(clip, pair.motion, trial.object_id, trial.object_id)


def semi_real_slides(
    rows: Sequence[TouchRow], seed: int, left_out: Counter[str] | None = None
) -> Iterator[tuple[Case, float]]:
    """Yield a slide of each imprint, forwards and backwards, and its travel in its frames' pixels.

    The four ways come in turn; `seed` is the root of travels, turns and noise. In the end
    `left_out["cut_off_left_out"]` counts imprints that are faint or reach the border.
    """
    count = 0
    for row, imprint, idle, rng in _imprints(rows, seed, "semi-real"):
        motion, count = SLIDES[count % len(SLIDES)], count + 1
        path_px, turn_deg = slide_path(motion, idle.shape[1], rng)
        clip = carried(imprint, idle, rng, row.path.name, path_px=path_px, turn_deg=turn_deg)
        for shown, truth in ((clip, motion), (clip.reversed(), opposite(motion))):
            case = Case(shown, truth, row.object_id, row.object_family)
            yield case, travel_of(imprint, path_px, turn_deg)
    if left_out is not None:
        left_out["cut_off_left_out"] = len(rows) - count


def semi_real_held(rows: Sequence[TouchRow], seed: int) -> Iterator[Case]:
    """Yield each imprint held still, pressed in and let go, in the place where it was recorded.

    Held, only fresh noise changes from frame to frame. Pressed in, the recorded change against the
    idle gel grows from `PRESS_FROM` of it to all of it: real contacts also widen, which lacks here.
    """
    for row, imprint, idle, rng in _imprints(rows, seed, "semi-real held"):
        still, pressed = (
            carried(imprint, idle, rng, row.path.name, growth=(begin, 1.0))
            for begin in (1.0, PRESS_FROM)
        )
        shown = (still, Motion.STILL), (pressed, Motion.PRESS)
        for clip, motion in (*shown, (pressed.reversed(), Motion.RELEASE)):
            tags = {"held": "held still" if motion is Motion.STILL else "pressed or let go"}
            yield Case(clip, motion, row.object_id, row.object_family, tags)


def slide_path(
    motion: Motion, columns: int, rng: np.random.Generator
) -> tuple[NDArray[np.float64], float]:
    """Draw the travel right and down of a slide in frames so wide, in pixels, and its turn, deg."""
    along = rng.uniform(*TRAVEL_SHARE) * columns
    aside = rng.uniform(-SIDEWAYS_SHARE, SIDEWAYS_SHARE) * along
    toward = np.array(_TOWARDS[motion], float)
    path_px = along * toward + aside * toward[::-1]
    return path_px, rng.uniform(-TURN_DEG, TURN_DEG)


def travel_of(imprint: Floats, path_px: Sequence[float], turn_deg: float) -> float:
    """Return how far the middle of an imprint goes when it is carried, in pixels.

    The turn is about the middle of the image, and takes an imprint beside it along.
    """
    rows, columns = imprint.shape[:2]
    weight = np.square(imprint).sum(axis=-1)
    weight /= weight.sum()
    arm_x = float(weight.sum(axis=0) @ np.arange(columns)) - columns / 2
    arm_y = float(weight.sum(axis=1) @ np.arange(rows)) - rows / 2
    cos, sin = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    x = path_px[0] + (cos - 1) * arm_x - sin * arm_y
    y = path_px[1] + sin * arm_x + (cos - 1) * arm_y
    return float(np.hypot(x, y))


def carried(
    imprint: Floats,
    idle: Floats,
    rng: np.random.Generator,
    name: str = "",
    *,
    path_px: Sequence[float] = (0.0, 0.0),
    turn_deg: float = 0.0,
    growth: tuple[float, float] = (1.0, 1.0),
) -> Clip:
    """Return four frames of an imprint on the idle gel, evenly from its own place to another.

    `imprint` is a touched frame's change against the idle gel, (rows, columns, 3), grey levels. It
    travels `path_px` right and down, turns about the image's middle, positive clockwise, and
    grows from the first strength of `growth` to the last, 1 as recorded.
    """
    rows, columns = idle.shape[:2]
    frames = []
    for share in np.linspace(0, 1, FRAME_COUNT):
        # OpenCV turns counterclockwise for positive angles; here clockwise is positive.
        matrix = cv2.getRotationMatrix2D((columns / 2, rows / 2), -turn_deg * share, 1.0)
        matrix[:, 2] += share * np.asarray(path_px)
        moved = cv2.warpAffine(imprint, matrix, (columns, rows), flags=cv2.INTER_CUBIC)
        strength = growth[0] + share * (growth[1] - growth[0])
        noise = rng.normal(0, NOISE_GREY, idle.shape)
        frames.append(_as_image(idle + strength * moved + noise))
    return Clip(np.stack(frames), background=_as_image(idle), name=name)


def _imprints(
    rows: Sequence[TouchRow], seed: int, purpose: str
) -> Iterator[tuple[TouchRow, Floats, Floats, np.random.Generator]]:
    """Yield each recording with its imprint, neither faint nor cut off, its idle gel and a draw."""
    for index, row in enumerate(rows):
        frames = read_clip(row.path).frames
        row.check_length(len(frames))
        idle = frames[row.surely_idle].mean(axis=0, dtype=np.float32)
        touched = frames[row.contact_start : row.contact_end + 1]
        changes = [np.square(frame - idle).mean() for frame in touched]
        imprint = touched[int(np.argmax(changes))] - idle
        width = round(BORDER_SHARE * idle.shape[1])
        square = np.square(imprint).mean(axis=-1)
        inner, whole = square[width:-width, width:-width], square.mean()
        at_border = (square.sum() - inner.sum()) / (square.size - inner.size)
        if whole >= LEAST_CHANGE_GREY**2 and at_border <= MOST_AT_BORDER**2 * whole:
            yield row, imprint.astype(np.float32), idle, generator_for(seed, purpose, index)


def _as_image(values: NDArray[np.floating]) -> NDArray[np.uint8]:
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)
