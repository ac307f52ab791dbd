"""Trials in TactileTracking's layout, written by our own simulator: the poses are what it drew."""

import cv2
import numpy as np

from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation.scene import Body, Optics, Path, Scene
from geotlm_lm.simulation.simulate import simulate
from tests.recordings.test_read import write_video

ROWS, COLUMNS = 240, 320
QUIET = Optics(noise_grey=(0.3, 0.3, 0.3), drift_grey=0.0)


def path_of(count=6, *, x=(0.0, 0.0), y=(0.0, 0.0), turn_deg=(0.0, 0.0), depth=0.6):
    """Return an even path from the first to the second value of each."""
    turn = np.linspace(*np.radians(turn_deg), count)
    spans = (np.full(count, depth), np.linspace(*x, count), np.linspace(*y, count), turn)
    return Path(*(tuple(float(value) for value in row) for row in spans))


def poses_of(path):
    """Return start_T_curr of every frame: the sensor as seen from its start, object at rest."""
    placed = np.tile(np.eye(4), (len(path), 1, 1))  # object -> sensor
    for pose, x, y, turn in zip(placed, path.x_mm, path.y_mm, path.rotation_rad, strict=True):
        pose[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
        pose[:2, 3] = x / 1e3, y / 1e3
    return placed[0] @ np.linalg.inv(placed)


def write_trial(folder, path, *, body="letter_l", idle=0, light=0.0, seed=3):
    """Write one trial and return its simulated clip."""
    optics = Optics(
        noise_grey=QUIET.noise_grey, drift_grey=0.0, idle=idle, light_change=(light,) * 3
    )
    scene = Scene(Body(body, variant=2), path, Motion.STILL, optics=optics)
    (made,) = simulate([scene], seed=seed)
    folder.mkdir(parents=True)
    frames = [cv2.resize(frame, (COLUMNS, ROWS)) for frame in made.clip.frames]
    write_video(folder / "gelsight.avi", frames, 25)
    np.save(folder / "true_start_T_currs.npy", poses_of(path))
    masks = [cv2.resize(grid, (COLUMNS, ROWS)) > 0.3 for grid in made.contact]
    np.save(folder / "contact_masks.npy", np.stack(masks))
    np.save(folder / "gradient_maps.npy", np.zeros((len(frames), ROWS, COLUMNS, 2), np.float32))
    return made
