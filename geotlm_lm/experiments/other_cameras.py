"""Real turns as other cameras would show them: other light, colours, lenses, sizes and mounts.

Every camera changes the frames and the idle gel alike, so that the motion stays what it was. Knows
no model. What damages a clip, until nothing can be told, is `degradations`' affair.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.labels import ROTATIONS
from geotlm_lm.core.record import RunRecord
from geotlm_lm.core.seeding import generator_for
from geotlm_lm.experiments.cases import by_task, real_cases
from geotlm_lm.experiments.compare import Case, ask_all
from geotlm_lm.experiments.degradations import resized
from geotlm_lm.experiments.evaluate import one_thread
from geotlm_lm.experiments.methods import FLOW, GENERATED, GENERATED_LEAN, PROBE, all_methods
from geotlm_lm.recordings.damage import as_pixels

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer

AS_RECORDED = "as recorded"

METHODS = (GENERATED, GENERATED_LEAN, PROBE, FLOW)

Show = Callable[[Frames], Frames]
"""Takes one image, uint8 (rows, columns, 3), and returns it as another camera shows it."""


@dataclass(frozen=True)
class Camera:
    """Another camera.

    Args:
        of_image: What it does to every image alike.
        shaking_px: How far each frame lies from where it should, at most, in each direction.
        flicker: By which share each frame is brighter or darker than the idle gel, at most.
    """

    of_image: Show = lambda image: image
    shaking_px: float = 0.0
    flicker: float = 0.0

    def __call__(self, clip: Clip, rng: np.random.Generator) -> Clip:
        """Return a clip as this camera shows it."""
        frames = [self._of_frame(self.of_image(frame), rng) for frame in clip.frames]
        idle = None if clip.background is None else self.of_image(clip.background)
        return replace(clip, frames=np.stack(frames), background=idle)

    def _of_frame(self, frame: Frames, rng: np.random.Generator) -> Frames:
        if self.shaking_px:
            x, y = rng.uniform(-self.shaking_px, self.shaking_px, 2)
            frame = mapped(np.float32([[1, 0, x], [0, 1, y]]), frame)
        return as_pixels(frame * (1 + rng.uniform(-self.flicker, self.flicker)))


def cameras() -> dict[str, Camera]:
    """Return every camera by what it does, in the order of the table."""
    of_image: dict[str, Show] = {
        "gamma 0.6": partial(toned, lambda v: v**0.6),
        "gamma 1.6": partial(toned, lambda v: v**1.6),
        "half the contrast": partial(toned, lambda v: 0.25 + 0.5 * v),
        "brighter by 50 grey levels": partial(toned, lambda v: v + 50 / 255),
        "warm colours": lambda image: as_pixels(image * np.array([1.2, 1.0, 0.7])),
        "cold colours": lambda image: as_pixels(image * np.array([0.7, 1.0, 1.2])),
        "a third of the colour": partial(coloured, 1 / 3),
        "twice the colour": partial(coloured, 2.0),
        "darker towards the corners": darker_at_the_corners,
        "32 grey levels": lambda image: image // 8 * 8,
        "1.4 times as near": partial(zoomed, 1.4),
        "0.7 times as near": partial(zoomed, 0.7),
        "the middle 0.8 of the picture": partial(cropped, 0.8),
        "the middle 0.6 of the picture": partial(cropped, 0.6),
        "mounted 10 degrees askew": partial(turned, 10.0),
        "mounted 30 degrees askew": partial(turned, 30.0),
        "barrel distortion": partial(bent, 0.2),
        "pincushion distortion": partial(bent, -0.15),
        "out of focus by 2 px": lambda image: cv2.GaussianBlur(image, (0, 0), 2),
        "out of focus by 4 px": lambda image: cv2.GaussianBlur(image, (0, 0), 4),
        "sharpened": lambda image: as_pixels(
            2.0 * image - cv2.GaussianBlur(image.astype(np.float32), (0, 0), 2)
        ),
        "denoised": lambda image: cv2.medianBlur(image, 5),
        "80 x 60 pixels": partial(resized, (80, 60)),
        "160 x 120 pixels": partial(resized, (160, 120)),
        "1280 x 960 pixels": partial(resized, (1280, 960)),
    }
    return {
        AS_RECORDED: Camera(),
        **{name: Camera(show) for name, show in of_image.items()},
        "shaking by 1 px": Camera(shaking_px=1.0),
        "shaking by 2 px": Camera(shaking_px=2.0),
        "light that flickers by 3 %": Camera(flicker=0.03),
    }


def other_cameras(
    answerer: Answerer,
    real_folder: Path,
    *,
    clips: int,
    seed: int,
    shown_by: Mapping[str, Camera] | None = None,
    command: str = "",
    progress: Callable[[str, int, int], None] = lambda what, done, total: None,
) -> RunRecord:
    """Ask which way real turns go, as each camera shows them.

    Args:
        answerer: The loaded model.
        real_folder: Folder of labelled recordings; see `evaluate`.
        clips: Windows of four frames of each set at most, evenly chosen among all.
        seed: Root of question wordings, shaking and flicker.
        shown_by: The cameras by name; None for all.
        command: The command line, for the record.
        progress: Told how many cameras are done.

    Raises:
        UnreadableClip: If the folder holds no labelled turn.
    """
    started, found = time.perf_counter(), cameras() if shown_by is None else shown_by
    sets = turns(real_folder, clips)
    if not sets:
        raise UnreadableClip(
            f"{real_folder}: holds no labelled turns, expected windows.csv with clockwise or "
            f"counterclockwise windows; give the folder of such recordings."
        )
    every = all_methods(answerer, seed)
    methods = {name: every[name] for name in METHODS}
    numbers: dict[str, Any] = {}
    with one_thread():
        for title, cases in sets.items():
            rows = numbers[title] = []
            for place, (name, camera) in enumerate(found.items()):
                progress(title, place, len(found))
                replies = ask_all(methods, _shown(cases, camera, seed, name), ROTATIONS)
                said = replies.motions[GENERATED]
                wrong = sum(m not in (None, t) for m, t in zip(said, replies.truths, strict=True))
                shares = {method: float(replies.right(method).mean()) for method in METHODS}
                own = {"camera": name, "clips": len(cases), "wrong": wrong / len(cases)}
                rows.append(own | shares)
    return RunRecord(
        name="cameras",
        command=command,
        seed=seed,
        seconds=round(time.perf_counter() - started, 1),
        numbers=numbers,
        config={"clips": clips, "threads": 1, "bundle": answerer.bundle.digest()},
    )


def turns(real_folder: Path, most: int) -> dict[str, list[Case]]:
    """Return windows of four frames of labelled turns, both ways, at most so many of each set."""
    sets = {}
    for name, real in real_cases(real_folder).items():
        for part, cases in by_task(real).items():
            if set(cases.among) <= set(ROTATIONS):
                four = [case for case in cases if case.tags["frames"] == "four"]
                kept = np.unique(np.linspace(0, len(four) - 1, most).round().astype(int))
                sets[f"real {name}{part}"] = [four[place] for place in kept]
    return sets


def _shown(cases: Sequence[Case], camera: Camera, seed: int, name: str) -> Iterator[Case]:
    rng = generator_for(seed, "camera", name)
    for case in cases:
        yield replace(case, clip=camera(case.clip, rng))


def toned(curve: Callable[[np.ndarray], np.ndarray], image: Frames) -> Frames:
    """Return an image whose values, from 0 to 1, went through a curve."""
    return as_pixels(255 * curve(np.arange(256) / 255))[image]


def coloured(share: float, image: Frames) -> Frames:
    """Return an image with `share` of each pixel's difference from grey."""
    grey = image.mean(axis=-1, keepdims=True)
    return as_pixels(grey + share * (image - grey))


def darker_at_the_corners(image: Frames) -> Frames:
    """Return an image with two fifths of its light left in the corners, all in the middle."""
    y, x = (np.linspace(-1, 1, side) for side in image.shape[:2])
    away = (np.square(y)[:, None] + np.square(x)) / 2
    return as_pixels(image * (1 - 0.6 * away)[..., None])


def zoomed(factor: float, image: Frames) -> Frames:
    """Return an image of the same size whose middle is magnified; its rim repeats outwards."""
    return mapped(_about_the_middle(image, 0.0, factor), image)


def turned(angle_deg: float, image: Frames) -> Frames:
    """Return an image turned clockwise about its middle; its rim repeats outwards."""
    return mapped(_about_the_middle(image, -angle_deg, 1.0), image)


def _about_the_middle(image: Frames, angle_deg: float, factor: float) -> np.ndarray:
    rows, columns = image.shape[:2]
    return cv2.getRotationMatrix2D(((columns - 1) / 2, (rows - 1) / 2), angle_deg, factor)


def mapped(matrix: np.ndarray, image: Frames) -> Frames:
    """Return an image through an affine map, shape (2, 3), of pixels (x, y)."""
    size = image.shape[1::-1]
    return cv2.warpAffine(image, matrix, size, borderMode=cv2.BORDER_REPLICATE)


def cropped(share: float, image: Frames) -> Frames:
    """Return the middle of an image, `share` of each side."""
    rows, columns = (round(side * (1 - share) / 2) for side in image.shape[:2])
    return image[rows : image.shape[0] - rows, columns : image.shape[1] - columns].copy()


def bent(strength: float, image: Frames) -> Frames:
    """Return an image through a lens: a point 1 off the middle comes from 1 + `strength`."""
    y, x = (np.linspace(-1, 1, side, dtype=np.float32) for side in image.shape[:2])
    bend = 1 + strength * (np.square(y)[:, None] + np.square(x))
    rows, columns = image.shape[:2]
    from_x, from_y = (x * bend + 1) / 2 * (columns - 1), (y[:, None] * bend + 1) / 2 * (rows - 1)
    return cv2.remap(image, from_x, from_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
