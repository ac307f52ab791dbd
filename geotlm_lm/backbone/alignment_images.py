"""The small images of an imprint that are aligned to find its motion, and that can be kept."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.backbone.alignment import small
from geotlm_lm.backbone.imprint import RESIDUAL_SCALE_GREY, Imprint
from geotlm_lm.backbone.relief import RELIEF_SCALE
from geotlm_lm.backbone.rigid import SIDE

Floats = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class AlignmentImages:
    """The images of an imprint that are aligned: 100 kB of the 3 MB that an imprint takes.

    Args:
        relief: Of each frame that does not repeat the one before, about one unit deep, as
            `alignment.small` makes it, (SIDE, SIDE) each.
        green: Residual of the same frames, likewise.
        places: Which of the frames stands at each place of the clip.
        aspect: Width of a pixel over its height.
        pixel_px: Side of a pixel in pixels of the 224-pixel image.
    """

    relief: list[Floats]
    green: list[Floats]
    places: list[int]
    aspect: float
    pixel_px: float


def alignment_images_of(imprint: Imprint) -> AlignmentImages:
    """Return the images of an imprint that are aligned."""
    return AlignmentImages(
        relief=[small(frame / RELIEF_SCALE) for frame in imprint.relief],
        green=[small(image[..., 1] / RESIDUAL_SCALE_GREY) for image in imprint.half],
        places=imprint.places,
        aspect=imprint.aspect,
        pixel_px=imprint.view.side_px / SIDE,
    )
