"""Clips of the six atomic actions as picture files, drawn by our own simulator."""

import cv2
import numpy as np

from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation.scene import Body, Scene
from geotlm_lm.simulation.simulate import simulate
from tests.data.tracked_trials import QUIET, path_of

PATHS = {
    "rotate_cw": {"turn_deg": (0, 15)},
    "rotate_ccw": {"turn_deg": (15, 0)},
    "slide_left": {"x": (0.75, -0.75)},
    "slide_right": {"x": (-0.75, 0.75)},
    "slide_up": {"y": (0.75, -0.75)},
    "slide_down": {"y": (-0.75, 0.75)},
}


def write_actions(root, *, body="letter_l", sensor="gsmini", actions=tuple(PATHS), frames=4):
    """Write root/<body>/<sensor>/<action>-0/<frame>.png and bg.png beside the frames."""
    for action in actions:
        scene = Scene(
            Body(body, variant=2), path_of(frames, **PATHS[action]), Motion.STILL, optics=QUIET
        )
        (made,) = simulate([scene], seed=1)
        folder = root / body / sensor / f"{action}-0"
        folder.mkdir(parents=True)
        write_image(folder / "bg.png", made.clip.background)
        for number, frame in enumerate(made.clip.frames):
            # Without leading zeros: 10 must come after 9, not after 1.
            write_image(folder / f"{number + 8}.png", frame)


def write_image(path, frame):
    """Write one RGB image."""
    cv2.imwrite(str(path), cv2.cvtColor(np.ascontiguousarray(frame), cv2.COLOR_RGB2BGR))
