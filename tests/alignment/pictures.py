"""Pictures that are moved by a known motion."""

import cv2
import numpy as np

from geotlm_lm.alignment.direct import Rigid

ROWS, COLUMNS = 112, 150


def texture(seed=0, grain_px=3.0, radius_px=28.0):
    """A grainy imprint in the middle of a flat picture, of deviation 20 grey levels or so."""
    rng = np.random.default_rng(seed)
    grain = cv2.GaussianBlur(rng.normal(size=(ROWS, COLUMNS)).astype(np.float32), (0, 0), grain_px)
    y, x = np.mgrid[:ROWS, :COLUMNS]
    y, x = y - (ROWS - 1) / 2, x - (COLUMNS - 1) / 2
    window = np.exp(-((x**2 + y**2) / (2 * radius_px**2)))
    return (40 * grain / grain.std() * window).astype(np.float32)


def moved(image, motion):
    """Move a picture's content, by OpenCV's own idea of a turn about the middle."""
    middle = ((image.shape[1] - 1) / 2, (image.shape[0] - 1) / 2)
    # OpenCV counts angles counterclockwise as drawn.
    matrix = cv2.getRotationMatrix2D(middle, -np.degrees(motion.turn_rad), 1.0)
    matrix[:, 2] += motion.right_px, motion.down_px
    return cv2.warpAffine(image, matrix, image.shape[::-1], flags=cv2.INTER_CUBIC)


def turned(degrees, right_px=0.0, down_px=0.0):
    return Rigid(np.radians(degrees), right_px, down_px)
