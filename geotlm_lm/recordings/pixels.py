"""Arrays of any common layout and range to uint8 RGB frames, with notes on what was guessed."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import MIN_SIDE, Frames
from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.recordings.decoding import require_full_range

Layout = Literal["THWC", "TCHW", "THW"]
"""T frames, H rows, W columns, C colours."""

Order = Literal["RGB", "BGR"]
"""Of the colours: OpenCV gives blue first, and so do arrays saved of its frames."""

COLOURS = (1, 3)
"""Colour counts a frame may have: grey or RGB."""

WITH_ALPHA = (*COLOURS, 4)
"""Channels a frame may have where they are last or the layout is given: alpha is left out. A second
axis of 4 is rather a clip of four frames."""


def check_layout(layout: str | None) -> str | None:
    """Return `layout` in capitals, None for a guess; `parts_of` tells its parts.

    Raises:
        UsageError: If it names no layout.
        TypeError: If it is no text.
    """
    if layout is None:
        return None
    if not isinstance(layout, str):
        raise TypeError(f"a layout is a str such as 'THWC', found {type(layout).__name__}")
    axes, dash, order = layout.upper().rpartition("-")
    is_ordered = order in get_args(Order) and (not dash or axes in ("THWC", "TCHW"))
    is_known = is_ordered or layout.upper() in get_args(Layout)
    if not is_known:
        raise UsageError(
            f"The layout '{layout}' is unknown, expected one of {', '.join(get_args(Layout))}, or "
            f"BGR, or both as in THWC-BGR; leave it out to have it guessed."
        )
    return layout.upper()


def parts_of(layout: str | None) -> tuple[Layout | None, Order]:
    """Return the axes that a checked layout names, None to guess them, and the order of colours."""
    if layout is None or layout in get_args(Layout):
        return layout, "RGB"  # type: ignore[return-value]
    axes, _, order = layout.rpartition("-")
    return axes or None, order  # type: ignore[return-value]


def layout_of(shape: tuple[int, ...], layout: Layout | None, name: str) -> tuple[Layout, str]:
    """Return the layout of an array of `shape` and a note on how it was found.

    Args:
        shape: Of the stored array.
        layout: What the user says it is; None to guess.
        name: Of the file, for errors.

    Raises:
        UnreadableClip: If the shape fits no layout, or not the one given.
    """
    if layout is not None:
        is_grey = "C" not in layout
        if len(shape) != len(layout) or not (is_grey or shape[layout.index("C")] in WITH_ALPHA):
            raise UnreadableClip(
                f"{name}: shape {shape} is not of the layout {layout} with 1, 3 or 4 channels; "
                f"give the layout the file has, or leave it out."
            )
        return layout, f"Shape {shape} is read as {layout}, as asked."
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


def _guess(shape: tuple[int, ...], name: str) -> tuple[Layout, str]:
    last, first = shape[3] in WITH_ALPHA, shape[1] in COLOURS
    if last and first:
        return "THWC", (
            f"Shape {shape} fits THWC and TCHW, THWC was assumed; pass --layout TCHW if it is not."
        )
    if last or first:
        found: Layout = "THWC" if last else "TCHW"
        return found, f"Shape {shape} was taken for {found}; pass --layout if it is not."
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


def to_rgb(array: NDArray, layout: Layout, order: Order, name: str) -> tuple[Frames, str]:
    """Return uint8 RGB frames, shape (t, rows, columns, 3), and a note on the range of the values.

    Args:
        array: Numbers in [0, 1] (floating point only), [0, 255], or uint16 that uses its range. A
            fourth channel is left out.
        layout: Of the axes of `array`.
        order: Of its colours.
        name: Of the file, for errors.

    Raises:
        UnreadableClip: If the values are no numbers, not finite, or out of range.
    """
    if array.dtype.kind not in "uif":
        raise UnreadableClip(
            f"{name}: found values of type {array.dtype}, expected uint8 or floating point; "
            f"save the frames as numbers."
        )
    if array.size == 0:
        raise UnreadableClip(
            f"{name}: holds no pixels (shape {array.shape}); record or export it again."
        )
    if layout == "TCHW":
        array = np.moveaxis(array, 1, -1)
    elif layout == "THW":
        array = array[..., None]
    alpha = " The fourth channel was taken for alpha and left out." * (array.shape[-1] == 4)
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
        require_full_range(int(high), name)
    elif low < 0 or high > 255 or is_overshoot:
        raise UnreadableClip(
            f"{name}: values run from {low:g} to {high:g}, expected 0..1 or 0..255; "
            f"scale or clip them first."
        )
    is_unit = array.dtype.kind == "f" and high <= 1
    if order == "BGR":
        array = array[..., ::-1]
    frames = np.empty((*array.shape[:3], 3), np.uint8)
    for target, source in zip(frames, array, strict=True):
        # Frame by frame: a floating-point copy of the whole recording would not fit the bound.
        if is_deep:
            target[...] = source >> 8
        else:
            target[...] = np.rint(source * 255.0) if is_unit else np.rint(source)
    span = "0..65535" if is_deep else "0..1" if is_unit else "0..255"
    advice = "; pass --layout BGR if OpenCV gave them" if order == "RGB" else ""
    range_note = f"Values ({array.dtype}) were taken for {span}, colours for {order}{advice}."
    return frames, range_note + alpha


def still_to_rgb(array: NDArray, order: Order, name: str) -> Frames:
    """Return one still image, shape (rows, columns, 3), from (H,W), (H,W,C) or (C,H,W) numbers.

    Raises:
        UnreadableClip: If it is no single image.
    """
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
    return to_rgb(array[None], layout, order, name)[0][0]
