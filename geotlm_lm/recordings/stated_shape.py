"""How files state that the pictures stored in them are to be shown: turned, of which pixels."""

from __future__ import annotations

import struct
import warnings
from dataclasses import dataclass
from typing import BinaryIO

import cv2

from geotlm_lm.core.clip import Frames
from geotlm_lm.recordings.policy import kept_frames

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
