"""Draws one frame of each kind of gel beside two real ones.

`PYTHONPATH=. python .ci/gels.py ../shared/real docs` writes gels.png: the same key pressed into a
gel of each kind, the change from its idle gel small in the corner. Real are a ball on a GelSight
Mini and a gripped fruit on one with dots, whose idle gel is taken from its sixteenth frame.
"""

import sys
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from geotlm_lm.core.labels import Motion
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.simulation.gels import GELS
from geotlm_lm.simulation.randomise import random_scene
from geotlm_lm.simulation.scene import Path as Poses
from geotlm_lm.simulation.simulate import simulate

SEED, SIDE, INSET = 5, 224, 80
POSES = Poses((0.8, 0.8), (-0.6, 0.6), (0.0, 0.2), (0.4, 0.5))
BALL, FRUIT = "calibration/ball_press", "incipient_slip/clips/avocado_real__exp_num_4__camera_0.avi"
FRUIT_FRAMES = (16, 225)


def simulated(name: str) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return the last frame of a touch on a kind of gel, and the idle gel."""
    rng = generator_for(SEED, "picture", name)
    scene = random_scene(rng, object_name="key", motion=Motion.RIGHT, gels={name: 1.0})
    body = replace(scene.body, size=1.0, tilt_x=0.0, tilt_y=0.0, texture_um=10.0)
    (made,) = simulate([replace(scene, path=POSES, body=body)], seed=SEED)
    return made.clip.frames[-1], made.clip.background


def real(folder: Path) -> dict[str, tuple[NDArray[np.uint8], NDArray[np.uint8]]]:
    """Return a frame and the idle gel of two public recordings."""
    video = cv2.VideoCapture(str(folder / FRUIT))
    frames = []
    for place in FRUIT_FRAMES:
        video.set(cv2.CAP_PROP_POS_FRAMES, place)
        frames.append(video.read()[1])
    ball = [cv2.imread(str(folder / BALL / name)) for name in ("background.png", "6.310mm_20.png")]
    pairs = {"REAL: mini": ball, "REAL: mini, dots": frames}
    return {
        name: tuple(
            cv2.resize(image[..., ::-1], (SIDE, SIDE), interpolation=cv2.INTER_AREA)
            for image in pair[::-1]
        )
        for name, pair in pairs.items()
    }


def with_change(frame: NDArray[np.uint8], idle: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return a frame with its change from the idle gel in the lower right corner."""
    change = np.clip(frame.astype(float) - idle + 128, 0, 255).astype(np.uint8)
    picture = frame.copy()
    small = cv2.resize(change, (INSET, INSET), interpolation=cv2.INTER_AREA)
    picture[-INSET - 2 :, -INSET - 2 :] = 255
    picture[-INSET:, -INSET:] = small
    return picture


def main(folder: Path, docs: Path) -> None:
    """Draw the picture."""
    shown = real(folder)
    shown |= {
        f"{name} ({kind.share:.0%})" if kind.share else f"{name} (LEFT OUT)": simulated(name)
        for name, kind in GELS.items()
    }
    figure = Figure(figsize=(9, 9.6), dpi=75, layout="constrained")
    for axis, (name, pair) in zip(figure.subplots(4, 4).flat, shown.items(), strict=True):
        axis.imshow(with_change(*pair))
        axis.set_title(name, fontsize=10)
        axis.axis("off")
    figure.savefig(docs / "gels.png")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
