"""Frames from a folder of images in the order that their names tell, and single stills."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import cv2
import numpy as np

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.image_size import declared_size, is_cut_off, page_sizes
from geotlm_lm.recordings.decoding import AS_STORED, quiet_decoders, rgb_of_8_bits
from geotlm_lm.recordings.frame_order import FrameOrder, frame_order
from geotlm_lm.recordings.limits import kept_frames, stride_for, stride_note
from geotlm_lm.recordings.stated_shape import StatedShape, image_shape

IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp")

BACKGROUND_STEM = "background"
"""Name, without its ending, of the idle gel's image among a folder's frames."""

_MASK = re.compile(r"(?:contact[_-]?)?masks?(?:$|[_\-. \d])", re.IGNORECASE)


def read_folder(folder: Path) -> Clip:
    """Return the clip of the images in `folder`; hidden files are passed over.

    Raises:
        UnreadableClip: If there are none, one is damaged, or their sizes differ.
    """
    images = folder_images(folder)
    paths, idle = images.frames, images.idle
    if not paths:
        raise UnreadableClip(
            f"{folder}: the folder holds {_held_instead(folder)}, expected "
            f"{', '.join(IMAGE_SUFFIXES)}; give the folder the frames lie in, or convert them."
        )
    first, shape = _read_image(paths[0])
    stride = stride_for(len(paths), *first.shape[:2], str(paths[0]))
    frames, stated = [first], dict.fromkeys(shape.notes)
    for path in paths[stride::stride]:
        frame, shape = _read_image(path)
        stated |= dict.fromkeys(shape.notes)
        if frame.shape != first.shape:
            raise UnreadableClip(
                f"{path}: is {frame.shape[1]}x{frame.shape[0]} pixels, {paths[0].name} is "
                f"{first.shape[1]}x{first.shape[0]}; keep frames of one recording in the folder."
            )
        frames.append(frame)
    order_note = f"{len(paths)} images were read in natural order of their names."
    notes = (order_note, *images.order.notes, *stated)
    if stride > 1:
        notes = (*notes, stride_note(stride, len(paths)))
    if images.masks:
        left_out = f"{len(images.masks)} images named as masks ({images.masks[0].name})"
        notes = (*notes, f"{left_out} were left out.")
    if idle is not None:
        notes = (*notes, f"Background: {idle.name} of the folder was taken for the idle gel.")
    return Clip(
        np.stack(frames),
        background=None if idle is None else read_still_image(idle),
        name=str(folder),
        frame_numbers=images.order.numbers[::stride],
        recorded_frames=images.order.numbers[-1] + 1,
        notes=notes,
    )


def _held_instead(folder: Path) -> str:
    """Return what is to be told of a folder without images: what most of its files are."""
    endings = Counter(one.suffix.lower() for one in listed(folder) if one.is_file())
    del endings[""]
    if not endings:
        return "no images"
    [(ending, count)] = endings.most_common(1)
    return f"no images but {count} {ending} file{'s' * (count > 1)}"


@dataclass(frozen=True)
class FolderImages:
    """The images in a folder.

    Args:
        frames: Of the recording, in order.
        order: Where they stood in the recording, and what is not plain about it.
        idle: The idle gel, an image named `background`; None if there is none.
        masks: Contact masks beside the frames, named `mask_1` and the like.
    """

    frames: list[Path]
    order: FrameOrder
    idle: Path | None
    masks: list[Path]


def folder_images(folder: Path) -> FolderImages:
    """Return the images in `folder`; hidden files are passed over.

    Raises:
        UnreadableClip: If the folder cannot be opened, or holds frames of several recordings.
    """
    images = sorted(filter(_is_image, listed(folder)))
    idle = next((path for path in images if path.stem.lower() == BACKGROUND_STEM), None)
    images = [path for path in images if path != idle]
    masks = [path for path in images if _MASK.match(path.stem)]
    if len(masks) == len(images):  # nothing lies beside them: masks are what was asked for
        masks = []
    frames = [path.name for path in images if path not in masks]
    order = frame_order(str(folder), frames) if frames else FrameOrder((), ())
    return FolderImages([folder / name for name in order.names], order, idle, masks)


def read_still_image(path: Path) -> Frames:
    """Return one image file as uint8 RGB, shape (rows, columns, 3).

    Raises:
        UnreadableClip: If it is no image, several, too large a one, or none of 8 or 16 bits.
    """
    return _read_image(path)[0]


def _read_image(path: Path) -> tuple[Frames, StatedShape]:
    """Return an image with square pixels, and what its file states of their shape."""
    try:
        stored = path.read_bytes()
    except OSError as error:
        raise UnreadableClip(
            f"{path}: cannot be opened ({error.strerror}); check the path and its permissions."
        ) from error
    if len(page_sizes(BytesIO(stored), most=2)) > 1:
        raise UnreadableClip(
            f"{path}: holds several pages, expected one image; give the file as the recording "
            f"that it is, or save one page."
        )
    image, shape = decoded_image(stored, str(path)), image_shape(BytesIO(stored))
    return shape.squared(image, str(path)), shape


def decoded_image(stored: bytes, name: str) -> Frames:
    """Return the image in a file's content as uint8 RGB, shape (rows, columns, 3).

    Args:
        stored: The content.
        name: Of what holds it, for errors.

    Raises:
        UnreadableClip: If it is no image, too large a one, or none of 8 or 16 bits.
    """
    if (size := declared_size(stored)) is not None:
        kept_frames(*size, name)  # refused before the decoder makes room for it
    is_whole = bool(stored) and not is_cut_off(stored)
    try:
        with quiet_decoders():
            image = cv2.imdecode(np.frombuffer(stored, np.uint8), AS_STORED) if is_whole else None
    except cv2.error:
        image = None
    if image is None:
        raise UnreadableClip(
            f"{name}: is cut off or is no image, expected {', '.join(IMAGE_SUFFIXES)}; "
            f"copy or record it again."
        )
    return rgb_of_8_bits([image], name)[0]


def listed(folder: Path) -> list[Path]:
    """Return what lies in a folder, in no order.

    Raises:
        UnreadableClip: If the folder cannot be opened.
    """
    try:
        return list(folder.iterdir())
    except OSError as error:
        raise UnreadableClip(
            f"{folder}: cannot be opened ({error.strerror}); check its permissions."
        ) from error


def _is_image(path: Path) -> bool:
    # Copies made on a Mac bring a hidden `._frame1.png`, which is no image, beside every frame.
    is_hidden = path.name.startswith(".")
    return path.suffix.lower() in IMAGE_SUFFIXES and not is_hidden and path.is_file()
