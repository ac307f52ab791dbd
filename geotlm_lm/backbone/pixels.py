"""Frames to the pixels each released encoder was trained on, as its authors prepare them."""

from __future__ import annotations

import cv2
import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import NDArray
from torch import Tensor

from geotlm_lm.backbone.view import View
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.geometry import FRAME_COUNT, IMAGE_SIDE, camera_size

Size = tuple[int, int]
"""Rows and columns."""

IMAGENET = ((0.485, 0.456, 0.406), (0.229, 0.224, 0.225))
"""Mean and standard deviation of red, green and blue."""

CLIP_STATISTICS = ((0.48145466, 0.4578275, 0.40821073), (0.26862954, 0.26130258, 0.27577711))
"""The same of the images CLIP was trained on."""


def four_frames(clip: Clip) -> NDArray[np.uint8]:
    """Return the frames of a clip of exactly four."""
    if len(clip) != FRAME_COUNT:
        raise ValueError(f"an encoder reads {FRAME_COUNT} frames, found {len(clip)}")
    return clip.frames


def background(clip: Clip) -> NDArray[np.uint8]:
    """Return the idle gel, which the clip must have."""
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


IDLE_LEVEL = 130 / 255
"""What an unchanged pixel becomes for AnyTouch 2 once the idle gel is subtracted."""

SPARSH_TITLE = "Sparsh V-JEPA"
SPARSH_ASPECT = 4 / 3
"""Columns over rows of a picture of which Sparsh's authors cut nothing."""

T3_CUT = 224 / 256
"""Side of the square that T3 cuts from the middle, over the picture's shorter side."""


def clip_difference(clip: Clip, image: Size) -> Tensor:
    """Return (4, 3, rows, columns), oldest first: difference from the idle gel, CLIP's scale.

    The difference is taken at the camera's size, before resizing.
    """
    difference = to_unit(four_frames(clip)) - to_unit(background(clip)) + IDLE_LEVEL
    return normalised(resized(difference.clamp(0, 1), image), CLIP_STATISTICS)


def whole_frames(clip: Clip, image: Size, how: str = "bilinear") -> Tensor:
    """Return (4, 3, rows, columns): whole pictures, no background taken away."""
    frames = rounded(resized(to_unit(four_frames(clip)), image, how))
    return normalised(frames, IMAGENET)


def upright_difference(clip: Clip, image: Size) -> Tensor:
    """Return (3, 4, rows, columns) in [0, 1], newest frame first, landscape pictures upright.

    Sparsh's authors turn landscape pictures by 90 degrees clockwise; its tokens' grid is turned
    back. Others they leave as they are, which would give a grid of another shape: a portrait
    picture that comes turned counterclockwise is seen as they show it.

    Raises:
        UnreadableClip: If the picture is not wider than high.
    """
    idle = unsquashed(background(clip))
    rows, columns = idle.shape[:2]
    if columns <= rows:
        raise UnreadableClip(
            f"{clip.name}: frames are {columns}x{rows} pixels, {SPARSH_TITLE} reads pictures wider "
            f"than high; turn the recording by 90 degrees counterclockwise, or export all of the "
            f"camera's picture."
        )
    kept = int(columns / SPARSH_ASPECT)
    cut = slice(int((columns - kept) / 2), int((columns + kept) / 2))
    frames = []
    for frame in four_frames(clip)[::-1]:
        difference = (unsquashed(frame).astype(np.int32) - idle.astype(np.int32)) / 255 + 0.5
        picture = (difference.clip(0, 1) * 255).astype(np.uint8)
        picture = cv2.rotate(picture, cv2.ROTATE_90_CLOCKWISE)
        frames.append(picture if columns / rows == SPARSH_ASPECT else picture[cut])
    return rounded(resized(to_unit(np.stack(frames)), image)).transpose(0, 1)


def uncut_view(clip: Clip) -> View | None:
    """Return the whole image, or None where Sparsh's cut makes it no square."""
    rows, columns = unsquashed(clip.frames[0]).shape[:2]
    return View() if columns / rows == SPARSH_ASPECT else None


def middle_frames(clip: Clip, image: Size) -> Tensor:
    """Return (4, 3, side, side): the middle of whole pictures, ImageNet's mean and deviation.

    T3's authors normalise by each data set's own statistics and by ImageNet's where there are none;
    a recording of yours has none. The shorter side is resized and the middle cut as torchvision's
    Resize and CenterCrop do.
    """
    images = to_unit(np.stack([unsquashed(frame) for frame in four_frames(clip)]))
    rows, columns = images.shape[-2:]
    short = round(min(image) / T3_CUT)
    if rows <= columns:
        size = (short, int(short * columns / rows))
    else:
        size = (int(short * rows / columns), short)
    images = rounded(F.interpolate(images, size=size, mode="bilinear", antialias=True))
    top, left = (round((size[axis] - image[axis]) / 2) for axis in range(2))
    middle = images[..., top : top + image[0], left : left + image[1]]
    return normalised(middle, IMAGENET)


def middle_view(clip: Clip) -> View | None:
    """Return the square that T3 reads; None where it is none in the squashed image."""
    rows, columns = unsquashed(clip.frames[0]).shape[:2]
    return View(side_px=IMAGE_SIDE * T3_CUT) if rows == columns else None


def blue_first(clip: Clip, image: Size) -> Tensor:
    """Return (4, 3, rows, columns) in [0, 1], blue first, as UniT's recorder stores them.

    Resizing is OpenCV's, without antialiasing, of float images.
    """
    frames = four_frames(clip)[..., ::-1].astype(np.float32)
    return to_unit(np.stack([cv2.resize(frame, image[::-1]) for frame in frames]))
