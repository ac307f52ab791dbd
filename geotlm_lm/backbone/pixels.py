"""Frames to the pixels released encoders were trained on: difference, size, mean and deviation."""

from __future__ import annotations

import cv2
import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import NDArray
from torch import Tensor

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import FRAME_COUNT, camera_size

Size = tuple[int, int]
"""Rows and columns."""

IMAGENET = ((0.485, 0.456, 0.406), (0.229, 0.224, 0.225))
"""Mean and standard deviation of red, green and blue."""

CLIP_STATISTICS = ((0.48145466, 0.4578275, 0.40821073), (0.26862954, 0.26130258, 0.27577711))
"""The same of the images CLIP was trained on."""


def four_frames(clip: Clip) -> NDArray[np.uint8]:
    """Return the frames of a clip.

    Raises:
        ValueError: If there are not exactly four.
    """
    if len(clip) != FRAME_COUNT:
        raise ValueError(f"an encoder reads {FRAME_COUNT} frames, found {len(clip)}")
    return clip.frames


def background(clip: Clip) -> NDArray[np.uint8]:
    """Return the idle gel.

    Raises:
        ValueError: If the clip has none.
    """
    if clip.background is None:
        raise ValueError("the encoder reads the difference from an idle frame, found none")
    return clip.background


def unsquashed(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return a square picture of our own size in the shape of the camera's, others as they are."""
    size = camera_size(*image.shape[:2])
    if size == image.shape[:2]:
        return image
    return cv2.resize(image, size[::-1], interpolation=cv2.INTER_LINEAR)


def to_unit(frames: NDArray[np.uint8]) -> Tensor:
    """Return frames (..., rows, columns, 3) as float32 (..., 3, rows, columns) in [0, 1]."""
    # Copied: a clip's frames are read-only, which torch warns of.
    return torch.from_numpy(np.array(frames)).movedim(-1, -3).float() / 255


def resized(images: Tensor, size: Size, how: str = "bilinear") -> Tensor:
    """Return images (t, 3, rows, columns) at another size, antialiased, aspect ignored."""
    if tuple(images.shape[-2:]) == tuple(size):
        return images
    return F.interpolate(images, size=size, mode=how, antialias=True, align_corners=False)


def rounded(images: Tensor) -> Tensor:
    """Round images in [0, 1] to 256 levels, as resizing 8-bit pictures does."""
    return (images * 255).round().clamp(0, 255) / 255


def normalised(images: Tensor, statistics: tuple[tuple[float, ...], tuple[float, ...]]) -> Tensor:
    """Return images (..., 3, rows, columns) less the mean, over the deviation, of each colour."""
    mean, deviation = (torch.tensor(values)[:, None, None] for values in statistics)
    return (images - mean) / deviation
