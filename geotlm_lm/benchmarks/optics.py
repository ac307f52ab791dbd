"""The simulator's images beside real ones: the same statistics of both, and how far they are apart.

Every number comes from the images alone, float32 (224, 224, 3) in RGB grey levels.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.benchmarks.rows import Listing, Row, Run, Section, every
from geotlm_lm.core.geometry import IMAGE_SIDE
from geotlm_lm.core.labels import Motion
from geotlm_lm.data.touch_table import TABLE_NAME, read_touch_table
from geotlm_lm.recordings.images import IMAGE_SUFFIXES, read_still_image
from geotlm_lm.recordings.read import read_clip
from geotlm_lm.simulation.indenters import TRAINING_OBJECTS
from geotlm_lm.simulation.randomise import random_scenes
from geotlm_lm.simulation.scene import Scene
from geotlm_lm.simulation.simulate import simulate

ABOUT = """\
The same statistics of real and simulated images. A spread runs from the 10th to the 90th percentile
over recordings, or over touched frames where an imprint is measured; each real source weighs the
same. Noise between frames is a codec's on both sides. Shapes and depths differ between the two, so
that an imprint's strength and sharpness are the object's as well. A median can be inside although
many real values are not covered: read the last column as well."""

SCENES, COLOURS = 600, ("R", "G", "B")

NOISE, LEVEL, AREA = "noise between idle frames", "idle gel, mean level", "imprint, share of image"
STRENGTH, ALIKE = "imprint, change over idle level, RMS", "imprint, correlation of B and R"
GRADIENT = "imprint, gradient, 95th percentile"
UNITS = {NOISE: "grey", LEVEL: "grey", AREA: "%", STRENGTH: "%", ALIKE: "1", GRADIENT: "grey/px"}
"""What is measured -> its unit."""

IDLE_FRAMES = 30
"""Idle frames used at most, the last ones before the touch."""

FINE_SIGMA_PX, RIM_PX = 3.0, 12
"""Finer than this Gaussian is noise, coarser is drift; border left out, 1 mm, where it bends."""

TOUCHED_SHARE, DARKEST_GREY = 0.06, 20.0
"""Change relative to the idle level, or to the darkest grey where it is darker, that counts as
touched: 3 grey levels in real recordings, ten times what noise leaves after smoothing."""

SMALL_PATCH, LEAST_AREA = 0.1, 0.02
"""Area over the greatest patch's below which a touched patch is noise or a lifted rim, and share of
the image that has to be touched before an imprint is measured."""

Floats = NDArray[np.float32]

NO_FRAME = np.empty((0, IMAGE_SIDE, IMAGE_SIDE, 3), np.float32)


@dataclass(frozen=True, eq=False)
class Touches:
    """A gel of `source` idle (224, 224, 3), in idle frames of a video in turn, and touched."""

    source: str
    idle: Floats
    series: Floats
    touched: Floats


def optics_rows(run: Run) -> list[Row]:
    """Return one row per statistic; none where `run.real` holds no image to compare with.

    Raises:
        UnreadableClip: If a real image cannot be read.
    """
    run.progress("optics", 0, 1)
    real = measured(real_touches(run.real, run.size(None, 3)))
    simulated = measured(simulated_touches(run.seed, run.size(SCENES, 6)))["simulated"]
    return [
        compared(case, unit, by_source, simulated[case])
        for title, unit in UNITS.items()
        for case in (title, *(f"{title}, {colour}" for colour in COLOURS))
        if (by_source := [own[case] for own in real.values() if case in own]) and case in simulated
    ]


def compared(
    case: str, unit: str, real: Sequence[Sequence[float]], simulated: Sequence[float]
) -> Row:
    """Return how far the simulated median lies outside the real spread, 0 inside, and both spreads.

    Each source of `real` weighs the same: sensors differ more than the recordings of one.
    """
    values, own = np.concatenate([np.asarray(one) for one in real]), np.asarray(simulated)
    weights = np.concatenate([np.full(len(one), 1 / len(one)) for one in real])
    spread, (low, middle, high) = _spread(values, weights), _spread(own, np.ones(len(own)))
    covered = float(np.average((values >= low) & (values <= high), weights=weights))
    detail = {"real": spread, "simulated": [low, middle, high], "covered": covered}
    outside = max(spread[0] - middle, middle - spread[2], 0.0)
    return Row(case, "simulator", len(own), outside, unit, detail=detail)


def _spread(values: NDArray[Any], weights: NDArray[Any]) -> list[float]:
    return np.quantile(values, (0.1, 0.5, 0.9), weights=weights, method="inverted_cdf").tolist()


def measured(recordings: Iterable[Touches]) -> dict[str, dict[str, list[float]]]:
    """Return, by source, the values of each statistic over recordings or touched frames."""
    found: dict[str, dict[str, list[float]]] = {}
    for one in recordings:
        values = found.setdefault(one.source, {})
        level = _by_colour(LEVEL, one.idle.mean(axis=(0, 1), dtype=np.float64))
        imprints = [imprint_statistics(frame, one.idle) for frame in one.touched]
        for part in (level, noise_statistics(one.series), *imprints):
            for key, value in part.items():
                values.setdefault(key, []).append(value)
    return found


def noise_statistics(frames: Floats) -> dict[str, float]:
    """Return the noise of successive idle frames (t, 224, 224, 3); nothing of fewer than two."""
    if len(frames) < 2:
        return {}
    change = np.diff(frames, axis=0) / np.float32(np.sqrt(2))
    fine = np.stack([one - cv2.GaussianBlur(one, (0, 0), FINE_SIGMA_PX) for one in change])
    # Sums in double precision: of 50,000 values, single precision keeps four digits.
    fine = fine[:, RIM_PX:-RIM_PX, RIM_PX:-RIM_PX].astype(np.float64)
    return _by_colour(NOISE, np.sqrt(np.square(fine).mean(axis=(0, 1, 2))))


def imprint_statistics(frame: Floats, idle: Floats) -> dict[str, float]:
    """Return the statistics of a touched gel's imprint; nothing if it is under `LEAST_AREA`."""
    change = frame - idle
    size = np.abs(cv2.GaussianBlur(change, (0, 0), 2.0)).max(axis=-1)
    change = change - change[size <= np.median(size)].mean(axis=0)  # the lamps' drift
    shading = change / np.maximum(idle, DARKEST_GREY)
    touched = touched_region(shading)
    if touched.mean() < LEAST_AREA:
        return {}
    slope = np.hypot(*np.gradient(cv2.GaussianBlur(change, (0, 0), 1.0), axis=(0, 1)))[touched]
    alike = np.corrcoef(change[touched].T.astype(np.float64))
    strength = np.sqrt(np.square(shading[touched]).mean(axis=0, dtype=np.float64))
    found = {AREA: 100 * float(touched.mean()), ALIKE: float(alike[2, 0])}
    found |= _by_colour(STRENGTH, 100 * strength)
    return found | _by_colour(GRADIENT, np.quantile(slope, 0.95, axis=0))


def touched_region(shading: Floats) -> NDArray[np.bool_]:
    """Return where the gel is touched, (224, 224): change over idle level, smoothed, is large.

    Patches far smaller than the greatest, and what lies at the image's border, do not count: the
    gel's rim lifts and glitters when a hand presses beside it.
    """
    smooth = cv2.GaussianBlur(shading, (0, 0), 2.0)
    inner = (np.sqrt(np.square(smooth).mean(axis=-1)) > TOUCHED_SHARE).astype(np.uint8)
    inner[:RIM_PX] = inner[-RIM_PX:] = inner[:, :RIM_PX] = inner[:, -RIM_PX:] = 0
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (9, 9))
    patches = cv2.connectedComponentsWithStats(cv2.morphologyEx(inner, cv2.MORPH_CLOSE, disc))
    areas = patches[2][:, cv2.CC_STAT_AREA].astype(np.float64)
    areas[0] = 0
    return (areas > SMALL_PATCH * areas.max())[patches[1]]


def real_touches(folder: Path, most: int | None = None) -> Iterator[Touches]:
    """Yield folders of stills, `calibration/*/background.png`, and recordings of `physiclear`.

    Raises:
        UnreadableClip: If one of them cannot be read.
    """
    for background in sorted(folder.glob("calibration/*/background.png")):
        paths = [one for one in sorted(background.parent.iterdir()) if one != background]
        images = [read_still_image(one) for one in paths if one.suffix.lower() in IMAGE_SUFFIXES]
        touched = [_squared(image[None]) for image in images[:most]]
        idle = _squared(read_still_image(background)[None])[0]
        source = f"calibration/{background.parent.name}"
        yield Touches(source, idle, NO_FRAME, np.concatenate([NO_FRAME, *touched]))
    for row in read_touch_table(folder / "physiclear" / TABLE_NAME)[:most]:
        frames = read_clip(row.path).frames
        row.check_length(len(frames))
        series = _squared(frames[row.idle[-IDLE_FRAMES:]])
        idle = series.mean(axis=0)
        touched = _strongest(_squared(frames[row.contact_start : row.contact_end + 1]), idle)
        yield Touches(f"physiclear {row.fps:g} fps", idle, series, touched)


def simulated_touches(seed: int, count: int) -> Iterator[Touches]:
    """Yield `count` random scenes, each idle and touched."""
    motions = [motion for motion in Motion if motion != Motion.NONE]
    scenes = random_scenes(seed, count, objects=TRAINING_OBJECTS, motions=motions)
    for index, scene in enumerate(scenes):
        yield simulated_touch(scene, seed, index)


def simulated_touch(scene: Scene, seed: int, index: int = 0) -> Touches:
    """Return scene number `index` of a series, touched and with its object lifted off."""
    clip = simulate([scene], seed=seed, first_index=index)[0].clip
    idle, series, optics = clip.background.astype(np.float32), NO_FRAME, scene.optics
    if optics.video is not None:  # successive frames, as they are measured of a real video
        optics = replace(optics, video=replace(optics.video, frames_apart=1))
        away = replace(scene.path, depth_mm=(0.0,) * len(scene.path))
        lifted = [replace(scene, path=away, motion=Motion.NONE, optics=optics)]
        # Another seed: the two clips' noise would be the same crops.
        series = simulate(lifted, seed=seed + 1, first_index=index)[0].clip.frames
    touched, series = clip.frames.astype(np.float32), series.astype(np.float32)
    return Touches("simulated", idle, series, _strongest(touched, idle))


def _strongest(frames: Floats, idle: Floats) -> Floats:
    """Return the frame that differs most from the idle gel, RMS; (1, 224, 224, 3)."""
    return frames[[int(np.argmax([np.square(frame - idle).mean() for frame in frames]))]]


def _squared(frames: NDArray[np.uint8]) -> Floats:
    """Return frames at the model's size; unlike the stem's not rounded, for the noise's sake."""
    how = cv2.INTER_LINEAR if min(frames.shape[1:3]) < IMAGE_SIDE else cv2.INTER_AREA
    side = (IMAGE_SIDE, IMAGE_SIDE)
    return np.stack([cv2.resize(one.astype(np.float32), side, interpolation=how) for one in frames])


def _by_colour(title: str, values: NDArray[Any]) -> dict[str, float]:
    return {f"{title}, {c}": float(value) for c, value in zip(COLOURS, values, strict=True)}


def _shown(key: str) -> Callable[[Row], str]:
    return lambda row: "{1:.2f} ({0:.2f} to {2:.2f})".format(*row.detail[key])


_COLUMNS = {
    "statistic": lambda row: row.case,
    "unit": lambda row: row.unit,
    "real, median (spread)": _shown("real"),
    "simulated, median (spread)": _shown("simulated"),
    "median outside by": lambda row: f"{row.error:.2f}" if row.error else "inside",
    "real covered": lambda row: f"{row.detail['covered']:.0%}",
}

OPTICS = Section(
    name="optics",
    title="The simulator's images beside real ones",
    about=ABOUT,
    run=optics_rows,
    views={"": (Listing(_COLUMNS), every)},
    needs_real=True,
)
