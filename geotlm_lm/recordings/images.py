"""Frames from pictures: a folder of images in the order of their names, pages of a TIFF, stills."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from io import BytesIO
from pathlib import Path

import cv2
import numpy as np

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.files import plain_name
from geotlm_lm.core.image_size import declared_size, is_cut_off, page_sizes
from geotlm_lm.recordings.frame_order import FrameOrder, frame_order
from geotlm_lm.recordings.pixels import AS_STORED, quiet_decoders, rgb_of_8_bits
from geotlm_lm.recordings.policy import (
    DECODED_FRAMES,
    Source,
    SourceFrame,
    kept_frames,
    read_source,
)
from geotlm_lm.recordings.stated_shape import StatedShape, image_shape

IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp")

STACK_SUFFIXES = (".tif", ".tiff")

BACKGROUND_STEM = "background"
"""Name, without its ending, of the idle gel's image among a folder's frames."""

PAGES_AT_ONCE = 32
"""Pages decoded before those between the kept ones are let go."""

_MASK = re.compile(r"(?:contact[_-]?)?masks?(?:$|[_\-. \d])", re.IGNORECASE)


def read_folder(folder: Path) -> Clip:
    """Return the clip of the images in `folder`; hidden files are passed over."""
    images = folder_images(folder)
    paths, idle = images.frames, images.idle
    if not paths:
        raise UnreadableClip(
            f"{folder}: the folder holds {_contents(folder)}, expected "
            f"{', '.join(IMAGE_SUFFIXES)}; give the folder the frames lie in, or convert them."
        )
    first, first_shape = _read_image(paths[0])
    order_note = f"{len(paths)} images were read in natural order of their names."
    notes = [order_note, *images.order.notes, *first_shape.notes]

    def decode(path: Path) -> Frames:
        frame, shape = _read_image(path)
        notes.extend(note for note in shape.notes if note not in notes)
        if frame.shape != first.shape:
            raise UnreadableClip(
                f"{path}: is {frame.shape[1]}x{frame.shape[0]} pixels, {paths[0].name} is "
                f"{first.shape[1]}x{first.shape[0]}; keep frames of one recording in the folder."
            )
        return frame

    def frames(stride: int) -> Iterator[SourceFrame]:
        yield SourceFrame(lambda: first)
        yield from (SourceFrame(partial(decode, path)) for path in paths[stride::stride])

    numbers = images.order.numbers
    clip = read_source(
        Source(str(folder), frames, len(paths), first.shape[:2], notes=notes, numbers=numbers)
    )
    if images.masks:
        left_out = f"{len(images.masks)} images named as masks ({images.masks[0].name})"
        clip = clip.with_note(f"{left_out} were left out.")
    if idle is None:
        return clip
    note = f"Background: {idle.name} of the folder was taken for the idle gel."
    return replace(clip, background=read_still_image(idle)).with_note(note)


def _contents(folder: Path) -> str:
    """Return what most files of a folder without images are."""
    endings = Counter(path.suffix.lower() for path in listed(folder) if path.is_file())
    del endings[""]
    if not endings:
        return "no images"
    [(ending, count)] = endings.most_common(1)
    return f"no images but {count} {ending} file{'s' * (count > 1)}"


@dataclass(frozen=True)
class FolderImages:
    """The images in a folder: frames in order, the idle gel, and what is left out."""

    frames: list[Path]
    order: FrameOrder
    idle: Path | None  # an image named `background`
    masks: list[Path]  # of contact, named `mask_1` and the like


def folder_images(folder: Path) -> FolderImages:
    """Return the images in `folder`; hidden files are passed over."""
    # Copies made on a Mac bring a hidden `._frame1.png`, which is no image, beside every frame.
    images = sorted(
        path
        for path in listed(folder)
        if path.suffix.lower() in IMAGE_SUFFIXES
        and not path.name.startswith(".")
        and path.is_file()
    )
    idle = next((path for path in images if path.stem.lower() == BACKGROUND_STEM), None)
    images = [path for path in images if path != idle]
    masks = [path for path in images if _MASK.match(path.stem)]
    if len(masks) == len(images):  # nothing lies beside them: masks are what was asked for
        masks = []
    names = [path.name for path in images if path not in masks]
    order = frame_order(str(folder), names) if names else FrameOrder((), ())
    return FolderImages([folder / name for name in order.names], order, idle, masks)


def listed(folder: Path) -> list[Path]:
    """Return what lies in a folder, in no order."""
    try:
        return list(folder.iterdir())
    except OSError as error:
        raise UnreadableClip(
            f"{folder}: cannot be opened ({error.strerror}); check its permissions."
        ) from error


def read_still_image(path: Path) -> Frames:
    """Return one image file as uint8 RGB, shape (rows, columns, 3); refuse any other."""
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


def decoded_image(stored: bytes, name: str, refusal: str | None = None) -> Frames:
    """Return the image in a file's content as uint8 RGB, shape (rows, columns, 3).

    `refusal` is the sentence for content that is no whole image; None for that of a file.
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
            refusal
            or f"{name}: is cut off or is no image, expected {', '.join(IMAGE_SUFFIXES)}; "
            f"copy or record it again."
        )
    return rgb_of_8_bits([image], name)[0]


def is_stack(path: Path) -> bool:
    """Tell whether a path is a readable TIFF of two pages or more; only directories are read."""
    if path.suffix.lower() not in STACK_SUFFIXES:
        return False
    try:
        with path.open("rb") as file:
            return len(page_sizes(file, most=2)) > 1
    except OSError:
        return False


def read_stack(path: Path) -> Clip:
    """Return the clip of the pages of a TIFF, as programs of microscopes and cameras save them."""
    name = str(path)
    with path.open("rb") as file:
        sizes = page_sizes(file, most=DECODED_FRAMES + 1)
        if None in sizes or not sizes:
            raise _damaged_stack(name)
        shape = image_shape(file)
    if len(sizes) == 1:
        raise UnreadableClip(
            f"{name}: only 1 frame was found, motion needs 2 or more; give the folder it lies in."
        )
    is_whole, sizes = len(sizes) <= DECODED_FRAMES, sizes[:DECODED_FRAMES]
    other = next((size for size in sizes if size != sizes[0]), None)
    if other is not None:
        raise UnreadableClip(
            f"{name}: page {sizes.index(other) + 1} is {other[1]}x{other[0]} pixels, page 1 is "
            f"{sizes[0][1]}x{sizes[0][0]}; keep frames of one recording in the file."
        )
    kept_frames(*sizes[0], name)

    def frames(stride: int) -> Iterator[SourceFrame]:
        pages = rgb_of_8_bits(_decoded_pages(path, len(sizes), stride), name)
        yield from (SourceFrame(partial(shape.squared, page, name)) for page in pages)

    notes = [f"{len(sizes)} pages were read as frames.", *shape.notes]
    size = shape.shown_size(*sizes[0])
    return read_source(Source(name, frames, len(sizes), size, notes=notes, is_whole=is_whole))


def _decoded_pages(path: Path, count: int, stride: int) -> list[np.ndarray]:
    kept: list[np.ndarray] = []
    for start in range(0, count, PAGES_AT_ONCE):
        asked = min(PAGES_AT_ONCE, count - start)
        try:
            with quiet_decoders(), plain_name(path) as plain:
                is_read, pages = cv2.imreadmulti(plain, start, asked, flags=AS_STORED)
        except cv2.error:
            is_read, pages = False, ()
        if not is_read or len(pages) < asked or len({page.shape for page in pages}) > 1:
            raise _damaged_stack(str(path))
        kept += pages[-start % stride :: stride]
    return kept


def _damaged_stack(name: str) -> UnreadableClip:
    return UnreadableClip(
        f"{name}: is cut off or is no TIFF of whole pages; copy or record it again."
    )
