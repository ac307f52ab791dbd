"""What the model saw, as uint8 RGB pictures: a frame, its difference, the geometry in place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.geometry import FLOW_SCALE_PX, IMAGE_SIDE

if TYPE_CHECKING:
    from geotlm_lm.backbone.view import View

Image = NDArray[np.uint8]
Floats = NDArray[np.float32]

ViewName = Literal["raw", "difference", "contact", "arrows", "depth"]
VIEW_NAMES: tuple[str, ...] = get_args(ViewName)

PICTURE_SIDE = 448
"""Pixels of a picture's longer side; frames are magnified to it, so that thin arrows stay thin."""

DIFFERENCE_GAIN = 4.0
"""Grey levels drawn per grey level of difference: an imprint's residual deviates by 21 to 43."""

CONTACT_COLOUR = (255, 70, 40)
ARROW_COLOUR = (255, 220, 0)
FRAME_COLOUR = (235, 235, 235)
LEGEND_COLOUR = (40, 40, 40)
LEGEND_MARGIN = 8

ARROW_THICKNESS = 2
"""Pixels of an arrow's line; a shorter arrow would be a dot without a direction: it is left out."""


@dataclass(frozen=True)
class ArrowScale:
    """How long arrows are drawn: the same for every clip, so that lengths can be compared."""

    unit_px: float  # of the 224-pixel view, that one unit of the field is drawn as long as
    shown: float  # units of the arrow in the legend
    name: str  # of the unit


LEARNED_SHEAR = ArrowScale(FLOW_SCALE_PX, 5, "learned shear (no unit)")
"""As long as the motion between the two time-bins, where the shear was trained to be physical."""

TRUE_DISPLACEMENT = ArrowScale(1.0, 20, "px of displacement")


@dataclass(frozen=True, eq=False)
class Seen:
    """What pictures are drawn from."""

    frames: Image  # (t, rows, columns, 3)
    idle: Image  # the untouched gel, (rows, columns, 3)
    shear_change: Floats  # right and down, (gh, gw, 2), in units of the scale
    mask: Floats  # of the contact, (gh, gw), in [0, 1]
    view: View  # the square of the image that the grid covers
    depth_mm: Floats | None = None  # of each frame over the whole image, (t, gh, gw); if simulated
    has_contact: bool = True  # what the model makes of an untouched gel is noise: no arrows
    scale: ArrowScale = LEARNED_SHEAR


def views_of(seen: Seen) -> tuple[str, ...]:
    """Return the names of the pictures that can be drawn."""
    return VIEW_NAMES if seen.depth_mm is not None else VIEW_NAMES[:-1]


def picture(seen: Seen, name: ViewName, index: int = -1) -> Image:
    """Return one frame as a picture, its longer side `PICTURE_SIDE` or more.

    Args:
        seen: What there is to draw.
        name: "raw", "difference" to the idle gel, "contact" mask, shear change as "arrows", or
            "depth".
        index: Of the frame; the geometry belongs to all four.

    Raises:
        ValueError: If there is no such view, or none for this clip.
    """
    if name not in views_of(seen):
        raise ValueError(f"there is no view '{name}', expected one of {', '.join(views_of(seen))}")
    frame = seen.frames[index]
    if name == "difference":
        return magnified(difference(frame, seen.idle))
    if name == "contact":
        return draw_contact(magnified(frame), seen.mask, seen.view)
    image = magnified(frame)
    if name == "depth":
        return draw_depth(seen.depth_mm[index], image.shape[:2], seen.depth_mm.max())
    if name == "arrows" and seen.has_contact:
        image = draw_arrows(image, seen.shear_change, seen.mask, seen.view, seen.scale)
        return draw_legend(image, seen.view, seen.scale)
    return image


def magnified(frame: Image) -> Image:
    """Return the frame, a longer side below `PICTURE_SIDE` brought to it."""
    scale = PICTURE_SIDE / max(frame.shape[:2])
    if scale <= 1:
        return frame.copy()
    size = (round(frame.shape[1] * scale), round(frame.shape[0] * scale))
    return cv2.resize(frame, size, interpolation=cv2.INTER_CUBIC)


def difference(frame: Image, idle: Image) -> Image:
    """Return what changed against the idle gel, neutral grey where nothing did."""
    change = frame.astype(np.float32) - idle
    return np.clip(128 + DIFFERENCE_GAIN * change, 0, 255).astype(np.uint8)


def draw_contact(image: Image, mask: Floats, view: View) -> Image:
    """Tint an image of the whole frame where there is contact, and frame the view's square."""
    share = in_image(mask, view, image.shape[:2])[..., None] * 0.6
    tinted = image * (1 - share) + np.float32(CONTACT_COLOUR) * share
    drawn = np.rint(tinted).astype(np.uint8)
    corners = _grid_points(view, image.shape[:2], np.array([[0, 0], [1, 1]], np.float32))
    first, last = (tuple(int(v) for v in np.rint(corner)) for corner in corners)
    return cv2.rectangle(drawn, first, last, FRAME_COLOUR, 1)


def draw_arrows(
    image: Image, field: Floats, mask: Floats, view: View, scale: ArrowScale = LEARNED_SHEAR
) -> Image:
    """Draw a field, as of `arrow_ends`, over an image of the whole frame."""
    drawn = image.copy()
    size = (image.shape[1], image.shape[0])
    for ends in (arrow_ends(field, mask, view, scale) * size).astype(np.float32):
        if np.linalg.norm(ends[1] - ends[0]) > ARROW_THICKNESS:
            _draw_arrow(drawn, ends)
    return drawn


def arrow_ends(
    field: Floats, mask: Floats, view: View, scale: ArrowScale = LEARNED_SHEAR
) -> NDArray[np.float64]:
    """Return where arrows of a field begin and end, where more than the view's mean is in contact.

    Args:
        field: (x right, y down), shape (gh, gw, 2), in units of the scale.
        mask: Contact mask, shape (gh, gw), in [0, 1].
        view: The square the grid covers.
        scale: Of the arrows.

    Returns:
        Shares (x, y) of the picture's width and height, tail before tip, (n, 2, 2).
    """
    gh, gw = mask.shape
    rows, columns = np.nonzero((mask > 0) & (mask >= mask.mean()))
    tails = np.stack([(columns + 0.5) / gw, (rows + 0.5) / gh], axis=-1)
    tips = tails + field[rows, columns] * scale.unit_px / IMAGE_SIDE
    return view.in_picture(np.stack([tails, tips], axis=1))


def draw_motion(
    image: Image, seen: Seen, turn_deg: float, right_px: float, down_px: float
) -> Image:
    """Draw how far each point of the contact has moved, to scale, over an image of the whole frame.

    Args:
        image: To draw over.
        seen: What tells where the contact is; without one there are no arrows.
        turn_deg: Turn about the middle of the contact, clockwise.
        right_px: Travel to the right, pixels of the 224-pixel square.
        down_px: Travel down.
    """
    if not seen.has_contact:
        return image
    filled = np.array([seen.view.picture_width_px, seen.view.picture_height_px])
    still = np.zeros((*seen.mask.shape, 2), np.float32)
    # Of every second cell: long arrows of all would hide each other.
    tails = arrow_ends(still, seen.mask, seen.view)[::2, 0] * filled
    arms = tails - tails.mean(axis=0)
    cosine, sine = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    turned = arms @ np.array([[cosine, sine], [-sine, cosine]])
    tips = tails + turned - arms + (right_px, down_px)
    drawn, size = image.copy(), (image.shape[1], image.shape[0])
    for ends in np.stack([tails, tips], axis=1) / filled * size:
        if np.linalg.norm(ends[1] - ends[0]) > ARROW_THICKNESS:
            _draw_arrow(drawn, ends)
    return drawn


def draw_caption(image: Image, text: str) -> Image:
    """Write a line of text into the upper left corner of an image, on a dark ground."""
    drawn, font, size = image.copy(), cv2.FONT_HERSHEY_SIMPLEX, 0.5
    (width, height), _ = cv2.getTextSize(text, font, size, 1)
    corner = (width + 2 * LEGEND_MARGIN, height + 2 * LEGEND_MARGIN)
    cv2.rectangle(drawn, (0, 0), corner, LEGEND_COLOUR, -1)
    place = (LEGEND_MARGIN, height + LEGEND_MARGIN)
    cv2.putText(drawn, text, place, font, size, FRAME_COLOUR, 1, cv2.LINE_AA)
    return drawn


def draw_legend(image: Image, view: View, scale: ArrowScale = LEARNED_SHEAR) -> Image:
    """Draw an arrow of known length in the lower left corner, with what it stands for."""
    drawn = image.copy()
    ends = np.array([[0.0, 0.0], [scale.shown * scale.unit_px / IMAGE_SIDE, 0.0]])
    ends = _grid_points(view, image.shape[:2], ends)
    text = f"= {scale.shown:g} {scale.name}"
    font, size = cv2.FONT_HERSHEY_SIMPLEX, 0.45
    (width, height), _ = cv2.getTextSize(text, font, size, 1)
    middle = image.shape[0] - LEGEND_MARGIN - height
    tail = np.array([LEGEND_MARGIN, middle], np.float32)
    ends = ends - ends[0] + tail
    begins = round(float(ends[1, 0])) + LEGEND_MARGIN
    corner = (begins + width + LEGEND_MARGIN, image.shape[0])
    cv2.rectangle(drawn, (0, middle - height - LEGEND_MARGIN // 2), corner, LEGEND_COLOUR, -1)
    _draw_arrow(drawn, ends)
    place = (begins, middle + height // 2)
    cv2.putText(drawn, text, place, font, size, FRAME_COLOUR, 1, cv2.LINE_AA)
    return drawn


def _draw_arrow(image: Image, ends: Floats) -> None:
    tail, tip = (tuple(int(v) for v in np.rint(end)) for end in ends)
    cv2.arrowedLine(image, tail, tip, ARROW_COLOUR, ARROW_THICKNESS, cv2.LINE_AA, tipLength=0.3)


def draw_depth(depth_mm: Floats, size: tuple[int, int], deepest_mm: float) -> Image:
    """Return an indentation of the whole image, (gh, gw), as colours in `size` rows and columns.

    It is dark where the gel is at rest, and brightest at `deepest_mm`.
    """
    share = np.clip(depth_mm / max(float(deepest_mm), 1e-6), 0, 1)
    shades = cv2.applyColorMap(np.rint(255 * share).astype(np.uint8), cv2.COLORMAP_VIRIDIS)
    whole = cv2.resize(shades, size[::-1], interpolation=cv2.INTER_LINEAR)
    return cv2.cvtColor(whole, cv2.COLOR_BGR2RGB)


def in_image(grid: Floats, view: View, size: tuple[int, int]) -> Floats:
    """Return a grid's values at the pixels of the whole image; zero outside of the view."""
    gh, gw = grid.shape
    origin, far = _grid_points(view, size, np.array([[0, 0], [1, 1]], np.float32))
    cell = (far - origin) / (gw, gh)
    # Pixel centres stand half a pixel, grid centres half a cell, from their corners.
    shift = origin + 0.5 * cell - 0.5
    matrix = np.float32([[cell[0], 0, shift[0]], [0, cell[1], shift[1]]])
    return cv2.warpAffine(
        np.asarray(grid, np.float32), matrix, size[::-1], flags=cv2.INTER_LINEAR
    ).clip(0, None)


def _grid_points(view: View, size: tuple[int, int], share: NDArray[np.floating]) -> Floats:
    """Return points of the view, given as shares (x, y) of its side, in pixels of the image."""
    return (view.in_picture(share) * (size[1], size[0])).astype(np.float32)
