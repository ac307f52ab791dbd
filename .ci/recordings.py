"""Simulates the recordings that the page opens: `PYTHONPATH=. python .ci/recordings.py`."""

import sys
from dataclasses import replace
from pathlib import Path

import av
import cv2
import numpy as np

from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation.randomise import random_scene
from geotlm_lm.simulation.scene import Path as Poses
from geotlm_lm.simulation.simulate import simulate

FOLDER = Path(__file__).resolve().parents[1] / "app" / "recordings"
SIZE, FPS = (320, 240), 25

CLEAR_MM = 0.3
"""Height above the gel at which nothing touches."""

PLANS = {
    # Of each stretch: seconds, and what it adds to depth, x, y (mm) and turn (degrees).
    "key": (
        *(4, (0.2, -0.8), 0.8),
        *((0.4, "press"), (0.3,), (1.1, 0, 0, 0, 50), (0.2,), (0.8, 0, 0, 0, -32)),
        *((0.5,), (0.24, 0, 1.8, 0.9, 0), (0.4,), (0.4, "lift")),
    ),
    "screw_head": (
        *(6, (-0.5, 0.0), 0.9),
        *((0.4, "press"), (0.2,), (0.6, 0, 0, 0, 32), (0.2,), (0.5, 0, 0, 0, -30), (0.2,)),
        *((0.6, 0, 0, 0, 34), (0.2,), (0.5, 0, 0, 0, -30), (0.3,), (0.4, "lift")),
    ),
    "pen_clip": (
        *(4, (0.8, -1.4), 0.7),
        *((0.4, "press"), (0.4,), (0.9, 0, 0, 2.2, 0), (0.4,), (0.8, 0, -2.0, 0, 0)),
        *((0.4,), (0.7, 0, 0, 0, -25), (0.3,), (0.3, "lift")),
    ),
    "hex_nut": (
        *(3, (0.6, -0.3), 0.9),
        *((0.4, "press"), (0.5,), (0.5, "lift"), (0.5,), (0.4, "press"), (0.3,)),
        *((0.6, 0.3), (0.4,), (0.3, "lift")),
    ),
}
"""Of each object: seed, middle of the contact (mm), depth (mm), and its stretches."""


def poses_of(place: tuple[float, float], depth: float, stretches: tuple) -> Poses:
    """Return the poses of a plan, which begins and ends above the gel."""
    clear = depth + CLEAR_MM
    here = np.array([-CLEAR_MM, *place, 0.0])
    rows = [np.tile(here, (round(0.6 * FPS), 1))]
    for seconds, *step in stretches:
        if step in (["press"], ["lift"]):
            step = [clear if step == ["press"] else -clear]
        far = np.zeros(4)
        far[: len(step)] = step
        far[3] = np.radians(far[3])
        count = round(seconds * FPS)
        share = (1 - np.cos(np.pi * np.arange(1, count + 1) / count)) / 2  # it speeds up and slows
        rows.append(here + share[:, None] * far)
        here = here + far
    rows.append(np.tile(here, (round(0.5 * FPS), 1)))
    return Poses(*(tuple(row.tolist()) for row in np.concatenate(rows).T))


def record(name: str, path: Path) -> None:
    """Write the recording of an object as an H.264 video."""
    seed, place, depth, *stretches = PLANS[name]
    scene = random_scene(np.random.default_rng(seed), object_name=name, motion=Motion.CLOCKWISE)
    body = replace(scene.body, tilt_x=0.0, tilt_y=0.0)
    scene = replace(scene, body=body, path=poses_of(place, depth, tuple(stretches)))
    (made,) = simulate([scene], seed=seed)
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=FPS)
        stream.width, stream.height, stream.pix_fmt = *SIZE, "yuv420p"
        stream.options = {"crf": "13", "preset": "veryslow", "threads": "1"}
        for frame in made.clip.frames:
            image = cv2.resize(frame, SIZE, interpolation=cv2.INTER_CUBIC)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="rgb24")))
        container.mux(stream.encode())
    print(f"{path.name}: {len(made.clip)} frames, {path.stat().st_size / 1024:.0f} KiB")


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for name in sys.argv[1:] or PLANS:
        record(name, FOLDER / f"{name}.mov")
