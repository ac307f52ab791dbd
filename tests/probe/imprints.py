"""Imprints that move as told: smooth random relief inside a soft disc, carried by warping."""

import cv2
import numpy as np

from geotlm_lm.core.clip import Clip

IDLE_LEVEL = 110


def textured_imprint(seed, rows=160, columns=200):
    """Smooth random relief inside a soft disc: an imprint of roughly a third of the image."""
    rng = np.random.default_rng(seed)
    relief = cv2.GaussianBlur(rng.standard_normal((rows, columns)).astype(np.float32), (0, 0), 3)
    y, x = np.mgrid[:rows, :columns]
    radius = np.hypot(x - columns / 2, y - rows / 2)
    return relief / relief.std() * 18 / (1 + np.exp((radius - 45) / 3))


def moved_clip(imprint, turns_deg, slides_px, noise=1.0):
    """Frames of an imprint that turns clockwise and slides as told, by warping."""
    rows, columns = imprint.shape
    rng = np.random.default_rng(7)
    frames = []
    for turn_deg, (slide_x, slide_y) in zip(turns_deg, slides_px, strict=True):
        # getRotationMatrix2D turns counter-clockwise as drawn for positive angles.
        matrix = cv2.getRotationMatrix2D((columns / 2, rows / 2), -turn_deg, 1.0)
        matrix[:, 2] += (slide_x, slide_y)
        warped = cv2.warpAffine(imprint, matrix, (columns, rows), flags=cv2.INTER_CUBIC)
        noisy = IDLE_LEVEL + warped + noise * rng.standard_normal(imprint.shape)
        frames.append(np.repeat(np.clip(noisy, 0, 255)[..., None], 3, axis=2))
    idle = np.full((rows, columns, 3), IDLE_LEVEL, np.uint8)
    return Clip(np.stack(frames).astype(np.uint8), background=idle)
