"""Stored numbers and decoded pictures as pixels: guessed, checked, brought to uint8 RGB."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import Literal, get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import MIN_SIDE, Clip, Frames
from geotlm_lm.core.errors import UnreadableClip, UsageError, choice_of
from geotlm_lm.core.geometry import IMAGE_SIDE

Layout = Literal["THWC", "TCHW", "THW"]
"""T frames, H rows, W columns, C colours."""

Order = Literal["RGB", "BGR"]
"""Of the colours: OpenCV gives blue first, and so do arrays saved of its frames."""

COLOURS = (1, 3)
"""Colour counts a frame may have: grey or RGB."""

WITH_ALPHA = (*COLOURS, 4)
"""Channels a frame may have where they are last or the layout is given: alpha is left out. A second
axis of 4 is rather a clip of four frames."""

AS_STORED = cv2.IMREAD_COLOR | cv2.IMREAD_ANYDEPTH
"""Three colours, in as many bits as the file has: a decoder that is left to reduce them takes the
upper 8 of 16, of which a camera of 10 or 12 bits fills none or few."""

FULL_RANGE_FROM = 2**14
"""Value in 16 bits from which an image is taken to use their range; cameras of 10 to 14 bits stay
below it."""

SQUASHED = (
    f"Frames of {IMAGE_SIDE}x{IMAGE_SIDE} were taken for a 4:3 picture squashed to a square; pass "
    f"--square-pixels if the camera's is square."
)
GUESSED_ORDER = "Colours were taken for red, green, blue; pass --layout BGR if OpenCV gave them."
UNSQUASHED = (
    f"Frames of {IMAGE_SIDE}x{IMAGE_SIDE} were taken as the camera took them, as asked or as the "
    f"file states; their last column is left out."
)


def check_layout(layout: str | None) -> str | None:
    """Return `layout` in capitals, None for a guess; `parts_of` splits it."""
    if layout is None:
        return None
    if not isinstance(layout, str):
        raise TypeError(f"a layout is a str such as 'THWC', found {type(layout).__name__}")
    axes, dash, order = layout.upper().rpartition("-")
    is_ordered = order in get_args(Order) and (not dash or axes in ("THWC", "TCHW"))
    if not is_ordered and layout.upper() not in get_args(Layout):
        known = (*get_args(Layout), *get_args(Order), "THWC-BGR", "TCHW-BGR")
        raise UsageError(f"The layout '{layout}' is unknown; {choice_of(layout, known)}")
    return layout.upper()


def parts_of(layout: str | None) -> tuple[Layout | None, Order | None]:
    """Return the axes and the order of colours that a checked layout names, None of what it omits.

    Axes are then guessed, and colours taken for red, green, blue.
    """
    if layout is None or layout in get_args(Layout):
        return layout, None  # type: ignore[return-value]
    axes, _, order = layout.rpartition("-")
    return axes or None, order  # type: ignore[return-value]


def layout_of(
    shape: tuple[int, ...], layout: Layout | None, name: str
) -> tuple[Layout, str | None]:
    """Return the layout of an array of `shape`, guessed unless it is given, and a note on a doubt.

    There is none where the shape fits one layout only.
    """
    if layout is not None:
        is_grey = "C" not in layout
        if len(shape) != len(layout) or not (is_grey or shape[layout.index("C")] in WITH_ALPHA):
            raise UnreadableClip(
                f"{name}: shape {shape} is not of the layout {layout} with 1, 3 or 4 channels; "
                f"give the layout the file has, or leave it out."
            )
        return layout, None
    if len(shape) == 4:
        return _guess(shape, name)
    if len(shape) == 3 and shape[-1] in WITH_ALPHA:
        raise UnreadableClip(
            f"{name}: only 1 frame was found (shape {shape}), motion needs 2 or more; "
            f"stack frames to (T,H,W,3)."
        )
    if len(shape) == 3:
        raise UnreadableClip(
            f"{name}: shape {shape} has no colour axis, expected (T,H,W,3); "
            f"if these are grey frames pass --layout THW."
        )
    if len(shape) == 5:
        clips, advice = f"{shape[0]} clips", "save each clip to its own file"
        if shape[0] == 1:
            clips, advice = "1 clip with an axis too many", "save frames[0]"
        raise UnreadableClip(
            f"{name}: shape {shape} looks like {clips}, expected one of (T,H,W,3); {advice}."
        )
    raise UnreadableClip(
        f"{name}: found shape {shape}, expected (T,H,W,3), (T,3,H,W) or, with --layout THW, "
        f"(T,H,W); save the frames in one of them."
    )


def _guess(shape: tuple[int, ...], name: str) -> tuple[Layout, str | None]:
    last, first = shape[3] in WITH_ALPHA, shape[1] in COLOURS
    if last and first:
        return "THWC", (
            f"Shape {shape} was taken for frames, rows, columns, colours; pass --layout TCHW if "
            f"its colours come second."
        )
    if last or first:
        return "THWC" if last else "TCHW", None
    elsewhere = next((axis for axis in (0, 2) if shape[axis] == COLOURS[-1]), None)
    if elsewhere is not None and shape[3] >= MIN_SIDE:  # else the last axis holds no columns
        place = "first" if elsewhere == 0 else "third"
        raise UnreadableClip(
            f"{name}: shape {shape} has its 3 colours {place}, expected them last or second, "
            f"(T,H,W,3) or (T,3,H,W); move them by np.moveaxis(frames, {elsewhere}, -1)."
        )
    raise UnreadableClip(
        f"{name}: shape {shape} has no axis of 1 or 3 colours, expected (T,H,W,3) or (T,3,H,W); "
        f"keep the colours red, green, blue only."
    )


def rgb_frames(
    array: NDArray, layout: Layout, order: Order | None, name: str
) -> tuple[Iterator[Callable[[], Frames]], list[str]]:
    """Return what makes each frame uint8 RGB, and notes on what was taken for what.

    One by one: a floating-point copy of the whole recording would not fit the bound. Numbers are in
    [0, 1] (floating point only), [0, 255], or uint16 that uses its range; alpha is left out.
    """
    require_numbers(array.dtype, name)
    if array.size == 0:
        raise UnreadableClip(
            f"{name}: holds no pixels (shape {array.shape}); record or export it again."
        )
    if layout == "TCHW":
        array = np.moveaxis(array, 1, -1)
    elif layout == "THW":
        array = array[..., None]
    notes = []
    if order is None and array.shape[-1] >= COLOURS[-1]:
        notes.append(GUESSED_ORDER)
    if array.shape[-1] == WITH_ALPHA[-1]:
        notes.append("The fourth channel was taken for alpha and left out.")
    array = array[..., :3]
    low, high = array.min(), array.max()
    if not np.isfinite(low) or not np.isfinite(high):
        raise UnreadableClip(
            f"{name}: holds NaN or infinite values, expected numbers in 0..1 or 0..255; "
            f"repair or leave out those frames."
        )
    # A little above 1 is neither: resampled 0..1 frames overshoot, and as 0..255 they are black.
    is_overshoot = array.dtype.kind == "f" and 1 < high < 2
    is_deep = array.dtype.kind == "u" and array.dtype.itemsize == 2 and high > 255
    if is_deep:
        _require_full_range(int(high), name)
    elif low < 0 or high > 255 or is_overshoot:
        raise UnreadableClip(
            f"{name}: values run from {low:g} to {high:g}, expected 0..1 or 0..255; "
            f"scale or clip them first."
        )
    is_unit = array.dtype.kind == "f" and high <= 1
    span = "0..65535" if is_deep else "0..1" if is_unit else "0..255"
    if order == "BGR":
        array = array[..., ::-1]
    return (partial(_in_8_bits, frame, span) for frame in array), notes


def _in_8_bits(stored: NDArray, span: str) -> Frames:
    frame = np.empty((*stored.shape[:2], 3), np.uint8)
    if span == "0..65535":
        frame[...] = stored >> 8
    else:
        frame[...] = np.rint(stored * 255.0) if span == "0..1" else np.rint(stored)
    return frame


def require_numbers(dtype: np.dtype, name: str) -> None:
    """Refuse values that can be no pixels."""
    if dtype.kind not in "uif":
        raise UnreadableClip(
            f"{name}: found values of type {dtype}, expected uint8 or floating point; "
            f"save the frames as numbers."
        )


def still_to_rgb(array: NDArray, order: Order | None, name: str) -> Frames:
    """Return one still image, shape (rows, columns, 3), from (H,W), (H,W,C) or (C,H,W) numbers."""
    layout: Layout
    if array.ndim == 2:
        layout = "THW"
    elif array.ndim == 3 and array.shape[-1] in WITH_ALPHA:
        layout = "THWC"
    elif array.ndim == 3 and array.shape[0] in COLOURS:
        layout = "TCHW"
    else:
        raise UnreadableClip(
            f"{name}: the background has shape {array.shape}, expected one image (H,W,3); "
            f"save a single idle frame."
        )
    frames, _ = rgb_frames(array[None], layout, order, name)
    return next(frames)()


def rgb_of_8_bits(decoded: Sequence[NDArray[np.generic]], name: str) -> list[Frames]:
    """Return images of one file, blue first as `AS_STORED` gives them, as uint8 RGB."""
    return [cv2.cvtColor(image, cv2.COLOR_BGR2RGB) for image in of_8_bits(decoded, name)]


def of_8_bits(decoded: Sequence[NDArray[np.generic]], name: str) -> list[Frames]:
    """Return images of one file, of any number of channels, as uint8: the upper bits of 16."""
    [kind, *others] = {image.dtype for image in decoded}
    if others or kind not in (np.uint8, np.uint16):
        raise UnreadableClip(
            f"{name}: holds values of type {kind}, expected 8 or 16 bits; scale the frames to "
            f"0..255 and save them in 8 bits."
        )
    if kind == np.uint16:
        _require_full_range(max(int(image.max(initial=0)) for image in decoded), name)
        return [(image >> 8).astype(np.uint8) for image in decoded]
    return list(decoded)


def _require_full_range(largest: int, name: str) -> None:
    """Refuse 16-bit values that stay too low to use their range, as those of 12-bit cameras do."""
    if largest < FULL_RANGE_FROM:
        raise UnreadableClip(
            f"{name}: holds 16-bit values up to {largest}, expected 8 bits, or 16 that are "
            f"used up to {2**16 - 1}; scale the frames to 0..255 and save them in 8 bits."
        )


@contextmanager
def quiet_decoders() -> Iterator[None]:
    """Keep OpenCV's decoders from writing to stderr: readers raise one sentence instead."""
    loudness = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        yield
    finally:
        cv2.utils.logging.setLogLevel(loudness)


def with_pixel_shape(clip: Clip, *, is_square: bool | None) -> Clip:
    """Return a clip of the size that stands for the shape of its pixels, with a note on it.

    Frames of our square's size are read as a squashed 4:3 picture, those of every other size as
    they are (`core.geometry.camera_size`). Of square pixels, where the user or the file says so, a
    column is left out: frames are then of another size, and lengths in pixels stay what they were,
    as they would not if resized.
    """
    if clip.frames.shape[1:3] != (IMAGE_SIDE, IMAGE_SIDE):
        return clip
    if is_square is None:
        return clip.with_note(SQUASHED)
    if not is_square:
        return clip
    idle = clip.background
    narrower = replace(
        clip,
        frames=with_square_pixels(clip.frames),
        background=None if idle is None else with_square_pixels(idle),
    )
    return narrower.with_note(UNSQUASHED)


def with_square_pixels(pictures: Frames) -> Frames:
    """Return pictures of square pixels, (..., rows, columns, 3), in a size that stands for them."""
    if pictures.shape[-3:-1] != (IMAGE_SIDE, IMAGE_SIDE):
        return pictures
    return np.ascontiguousarray(pictures[..., :-1, :])


def jpeg(quality: float, image: Frames) -> Frames:
    """Return an image through JPEG of a quality from 0 to 100."""
    packed = cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, int(quality)])[1]
    return cv2.imdecode(packed, cv2.IMREAD_COLOR)[..., ::-1].copy()


def gained(gain: float, image: Frames) -> Frames:
    """Return an image exposed `gain` times as long."""
    return as_pixels(image * float(gain))


def drifted(offset_grey: float, gain: float, frames: Frames) -> Frames:
    """Return frames growing brighter evenly, up to `offset_grey` levels and a share `gain`."""
    share = np.linspace(0, 1, len(frames))[:, None, None, None]
    return as_pixels(frames * (1 + gain * share) + offset_grey * share)


def faded(contrast: float, frames: Frames, background: Frames) -> Frames:
    """Return frames with only a share of their change, noise and all, against the background."""
    idle = background.astype(np.float64)
    return as_pixels(idle + contrast * (frames - idle))


def as_pixels(values: NDArray[np.floating]) -> Frames:
    """Return values rounded and cut to what a pixel holds."""
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)
