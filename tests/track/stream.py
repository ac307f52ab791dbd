"""A simulated recording of several motions in a row, whose times and amounts are known."""

import numpy as np

from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation.scene import Body, Path, Scene
from geotlm_lm.simulation.simulate import simulate

FPS = 25.0
TOUCH, TURN, TURN_END, BACK, BACK_END, RELEASE, FREE = 12, 24, 48, 60, 78, 88, 96
"""Frames: it is pressed in until `TURN`, held from `TURN_END` to `BACK`, and lifted by `FREE`."""

TURN_DEG, BACK_DEG = 40.0, 28.0


def stream(name="bottle_cap"):
    """Return frames in which an object no weight was trained on turns clockwise and back."""
    places = np.arange(FREE + 12)
    depth = np.interp(places, [TOUCH, TOUCH + 8, RELEASE, FREE], [-0.3, 0.7, 0.7, -0.3])
    stops = [TURN, TURN_END, BACK, BACK_END]
    turn = np.interp(places, stops, [0.0, TURN_DEG, TURN_DEG, TURN_DEG - BACK_DEG])
    still = (0.0,) * len(places)
    path = Path(tuple(depth.tolist()), still, still, tuple(np.radians(turn).tolist()))
    return simulate([Scene(Body(name, texture_um=10.0), path, Motion.CLOCKWISE)], seed=11)[0].clip
