"""Frames from pictures: a folder of images in the order of their names, pages of a TIFF, stills.

How files state that their pictures are to be shown, turned and of which pixels, is here as well.
"""

from __future__ import annotations

import re
import struct
import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

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


TURNS = {
    2: "mirrored left to right",
    3: "turned by 180 degrees",
    4: "mirrored top to bottom",
    5: "mirrored and turned by 90 degrees counterclockwise",
    6: "turned by 90 degrees clockwise",
    7: "mirrored and turned by 90 degrees clockwise",
    8: "turned by 90 degrees counterclockwise",
}
"""Orientation as EXIF numbers it -> what OpenCV does to the stored picture."""

TURN_NOTES = {
    number: f"Pictures were {turn} as the file states; directions are those of the turned picture."
    for number, turn in TURNS.items()
}

FIRST_QUARTER = 5
"""Orientation from which on rows and columns change places."""

SQUARE = (0.99, 1.01)
"""Width of a pixel over its height that counts as square: what rounding leaves of it."""

WIDEST_PIXEL = 8.0
"""Width over height, or the other way, from which a file's pixels are taken for a mistake."""


@dataclass(frozen=True)
class StatedShape:
    """What a file states about the pictures in it."""

    orientation: int = 1  # as EXIF numbers it; OpenCV applies it by itself
    pixel_aspect: float = 1.0  # width of a pixel over its height, of the turned picture

    @property
    def notes(self) -> tuple[str, ...]:
        """What is done about it, one sentence each."""
        turned = (TURN_NOTES[self.orientation],) if self.orientation in TURN_NOTES else ()
        if self._is_square:
            return turned
        ratio = f"The file states pixels {self.pixel_aspect:.3g} times as wide as high"
        if self._is_senseless:
            return (*turned, f"{ratio}, which is not used.")
        return (*turned, f"{ratio}: pictures were stretched until their pixels are square.")

    def squared(self, image: Frames, name: str) -> Frames:
        """Return a turned picture with the narrower side of its pixels stretched."""
        if self._is_square or self._is_senseless:
            return image
        rows, columns = self._squared_size(*image.shape[:2])
        kept_frames(rows, columns, name)  # refused before room is made for it
        return cv2.resize(image, (columns, rows), interpolation=cv2.INTER_LINEAR)

    def shown_size(self, rows: int, columns: int) -> tuple[int, int]:
        """Return the size (rows, columns) of a stored picture once it is turned and stretched."""
        is_quarter = self.orientation >= FIRST_QUARTER
        return self._squared_size(*((columns, rows) if is_quarter else (rows, columns)))

    def _squared_size(self, rows: int, columns: int) -> tuple[int, int]:
        if self._is_square or self._is_senseless:
            return rows, columns
        if self.pixel_aspect > 1:
            return rows, round(columns * self.pixel_aspect)
        return round(rows / self.pixel_aspect), columns

    @property
    def _is_square(self) -> bool:
        return SQUARE[0] <= self.pixel_aspect <= SQUARE[1]

    @property
    def _is_senseless(self) -> bool:
        return not 1 / WIDEST_PIXEL <= self.pixel_aspect <= WIDEST_PIXEL


def video_shape(degrees: float, wide: float, high: float) -> StatedShape:
    """Return what a video states: degrees clockwise, width and height of a pixel or 0."""
    orientation = {90: 6, 180: 3, 270: 8}.get(round(degrees) % 360, 1)
    return StatedShape(orientation, _turned_aspect(orientation, wide, high))


def image_shape(file: BinaryIO) -> StatedShape:
    """Return the orientation and the resolutions that an open image file states, if it is whole."""
    from PIL import Image
    from PIL.TiffImagePlugin import PREFIXES

    # Of damaged values Pillow warns on stderr; here they state nothing.
    warnings.filterwarnings("ignore", module=r"PIL\.")
    file.seek(0)
    header = file.read(16)
    file.seek(0)
    try:
        if header.startswith(tuple(PREFIXES)):
            orientation, across, down = _stated_by_tiff(file, header)
        else:
            # Looking for what is not in a PNG, Pillow decodes all of it.
            is_stated = not header.startswith(_PNG) or b"eXIf" in file.read()
            with Image.open(file, formats=("JPEG", "PNG", "WEBP", "BMP")) as image:
                orientation = image.getexif().get(_ORIENTATION, 1) if is_stated else 1
                info = image.info
            # PNG and JPEG may state a ratio without a unit.
            across, down = info.get("aspect") or info.get("jfif_density") or info.get("dpi", (1, 1))
        orientation = orientation if orientation in TURNS else 1
        # More dots to the inch across than down: pixels that are narrower than high.
        return StatedShape(orientation, _turned_aspect(orientation, float(down), float(across)))
    except (*DAMAGED, Image.DecompressionBombError):
        return StatedShape()


def _stated_by_tiff(file: BinaryIO, header: bytes) -> tuple[int, float, float]:
    """Return orientation and resolutions by the first directory: Pillow opens not every TIFF."""
    from PIL.TiffImagePlugin import ImageFileDirectory_v2

    is_big = header[2:4] in (b"+\0", b"\0+")
    directory = ImageFileDirectory_v2(header if is_big else header[:8])
    file.seek(directory.next)
    directory.load(file)
    across, down = (float(directory.get(tag, 1)) for tag in (_ACROSS, _DOWN))
    return int(directory.get(_ORIENTATION, 1)), across, down


_PNG = b"\x89PNG"

_ORIENTATION, _ACROSS, _DOWN = 274, 282, 283
"""Tags of EXIF and TIFF."""

DAMAGED = (
    OSError,
    EOFError,
    ValueError,
    ArithmeticError,
    TypeError,
    LookupError,
    SyntaxError,
    struct.error,
)
"""What Pillow raises on files that are damaged or end early: it believes what they say."""


def _turned_aspect(orientation: int, wide: float, high: float) -> float:
    if not (wide > 0 and high > 0):
        return 1.0
    return high / wide if orientation >= FIRST_QUARTER else wide / high
