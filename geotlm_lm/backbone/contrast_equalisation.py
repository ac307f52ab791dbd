"""Align contrast-equalised images: the motion of an imprint's faint inside, not of its rim.

The rim of a round imprint stands still while its face turns, and holds the fit of one rigid motion
back. Where local contrast is equalised, a faint cross counts as much as the rim around it: laid
on the first frame directly, the relief alone then tells 0.85 of 300 simulated turns within their
tolerance, 0.76 as it is, and 0.89 of as many slides for 0.86.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.backbone.alignment import align_sequence, changed_weight, correlation, small
from geotlm_lm.backbone.alignment_images import AlignmentImages
from geotlm_lm.backbone.rigid import MIDDLE
from geotlm_lm.core.geometry import FRAME_COUNT

Floats = NDArray[np.float32]

EQUALISED_SHAPE = (FRAME_COUNT - 1, 2, 2, 4)
"""Frames but the first; relief, green residual; laid on the first frame directly, and as a sum of
steps; turn in rad, positive clockwise as drawn, way to the right and down in pixels of the
224-pixel image, and how much alike the two images then are (of a sum, those of its last step)."""

NEIGHBOURHOOD_PX = 7.0
"""Deviation of the Gauss bell over which contrast is equalised, pixels of the aligned images: a
rim and the face inside it lie farther apart."""

CONTRAST = 0.5
"""What is left of any contrast, in units of the images."""

FAINTEST = 0.15
"""Contrast that is halved to that: what is far fainter is noise."""


def equalise_contrast(image: Floats) -> Floats:
    """Return an image whose contrast is alike everywhere: local contrast normalisation.

    Args:
        image: As `alignment.small` makes it, (SIDE, SIDE).
    """
    detail = image - _mean_around(image)
    contrast = np.sqrt(_mean_around(np.square(detail)))
    return small(CONTRAST * detail / (contrast + FAINTEST))


def equalised_motions(traces: AlignmentImages) -> Floats:
    """Return the motion of each frame against those before it, after contrast equalisation.

    Args:
        traces: Of a clip of four frames.

    Returns:
        `EQUALISED_SHAPE`; a frame that repeats the one before has its motion, one that repeats the
        first zeros.
    """
    sequences = [
        [equalise_contrast(image) for image in images] for images in (traces.relief, traces.green)
    ]
    centre = _centre(changed_weight(sequences[0][0], sequences[0][-1]))
    found = np.zeros((len(traces.relief), *EQUALISED_SHAPE[1:]), np.float32)
    for k, aligned in enumerate(align_sequence(sequences, traces.aspect), start=1):
        for place, (images, one) in enumerate(zip(sequences, aligned, strict=True)):
            laid = ((one.direct, one.direct, images[0]), (one.summed, one.step, images[k - 1]))
            for kind, (motion, last, before) in enumerate(laid):
                way = motion.way_to(centre) * traces.pixel_px
                alike = correlation(last.moved(before), images[k])
                found[k, place, kind] = motion.turn_rad, *way, alike
    return found[traces.places[1:]]


def _mean_around(image: Floats) -> Floats:
    return cv2.GaussianBlur(image, (0, 0), NEIGHBOURHOOD_PX)


def _centre(weight: Floats) -> Floats:
    """Return the middle of what changed, (x, y) in pixels from the image's middle."""
    down, right = ((np.indices(weight.shape) - MIDDLE) * weight).sum(axis=(1, 2)) / weight.sum()
    return np.float32([right, down])
