"""A simulated stream whose motions are known: idle, press, turn, still, release, idle."""

import numpy as np

from geotlm_lm.simulation.scene import Body, Path, Scene
from geotlm_lm.simulation.simulate import simulate

FPS = 25.0
IDLE, PRESS, TURN, STILL, RELEASE = 12, 8, 24, 12, 8
TURN_DEG = 30.0


def touch_path(turn_deg=TURN_DEG, slide_mm=0.0):
    """Return the path of the stream, one pose a frame."""
    deep, free = 0.7, -0.3
    depth = np.concatenate(
        [
            np.full(IDLE, free),
            np.linspace(0.05, deep, PRESS),
            np.full(TURN + STILL, deep),
            np.linspace(deep, 0.05, RELEASE),
            np.full(IDLE, free),
        ]
    )
    moving = np.clip((np.arange(len(depth)) - IDLE - PRESS) / TURN, 0, 1)
    return Path(
        depth_mm=tuple(depth.tolist()),
        x_mm=tuple((slide_mm * moving).tolist()),
        y_mm=(0.0,) * len(depth),
        rotation_rad=tuple(np.radians(turn_deg * moving).tolist()),
    )


TURN_START_S = (IDLE + PRESS) / FPS
TURN_END_S = (IDLE + PRESS + TURN) / FPS
TOUCH_S = IDLE / FPS
LIFT_S = (IDLE + PRESS + TURN + STILL + RELEASE) / FPS


def stream(name="hex_nut", **motion):
    """Return the frames of the stream, simulated; no weight was trained on its object."""
    from geotlm_lm.core.labels import Motion

    scene = Scene(Body(name, texture_um=10.0), touch_path(**motion), Motion.CLOCKWISE)
    return simulate([scene], seed=11)[0].clip
