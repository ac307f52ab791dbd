"""Frames from .npy and .npz files; headers are checked before anything is read or allocated."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.recordings.limits import (
    DECLARED_BYTES,
    FEWEST_KEPT,
    KEPT_BYTES,
    stride_for,
    stride_note,
)
from geotlm_lm.recordings.pixels import Order, layout_of, parts_of, still_to_rgb, to_rgb


def read_array(path: Path, layout: str | None = None) -> Clip:
    """Return the clip in a .npy file.

    Args:
        path: Of the file.
        layout: Checked; None to guess.

    Raises:
        UnreadableClip: If it holds no frames this can read.
    """
    stored = map_array(path)
    return _to_clip(stored, layout, str(path))


def read_archive(path: Path, layout: str | None = None) -> Clip:
    """Return the clip in a .npz file with `frames` and, optionally, `fps` and `background`.

    What it states by `square_pixels` is told by `stated_square_pixels`.

    Where no array is called `frames`, the only other one is taken for them (`numpy.savez(path,
    frames)` calls it `arr_0`), or of several the only one with the shape of pictures, in colour
    before grey, as in an archive of `rgb` and `depth`. A note says so.

    Args:
        path: Of the file.
        layout: Of `frames`, checked; None to guess. The background has the same order of colours.

    Raises:
        UnreadableClip: If it holds no frames this can read.
    """
    name = str(path)
    with _refusing_damage(name), zipfile.ZipFile(path) as archive:
        keys = sorted(entry.removesuffix(".npy") for entry in archive.namelist())
        key = _key_of_frames(archive, keys, name)
        frames, step, count = _read_frames(archive, key, name)
        others = {k: _read_member(archive, k, name) for k in ("fps", "background") if k in keys}
    clip = _to_clip(frames, layout, name, step, count)
    if key != "frames":
        clip = clip.with_note(f"The array '{key}' was taken for the frames.")
    fps, idle = others.get("fps"), others.get("background")
    order = parts_of(layout)[1]
    return Clip(
        clip.frames,
        fps=_one_number(fps, name) if fps is not None else None,
        background=still_to_rgb(idle, order, name) if idle is not None else None,
        name=name,
        frame_numbers=clip.frame_numbers,
        recorded_frames=clip.recorded_frames,
        notes=clip.notes,
    )


def stated_square_pixels(path: Path) -> bool | None:
    """Return whether a .npz file states by `square_pixels` that they are; None where it does not.

    Raises:
        UnreadableClip: If what it holds under that name is not one truth value.
    """
    with _refusing_damage(str(path)), zipfile.ZipFile(path) as archive:
        if f"{SQUARE_PIXELS}.npy" not in archive.namelist():
            return None
        value = _read_member(archive, SQUARE_PIXELS, str(path))
    is_one = value.size == 1 and value.dtype.kind in "bui"
    if not is_one or value.reshape(()) not in (0, 1):
        found = f"has value {value.reshape(())}" if is_one else f"has shape {value.shape}"
        raise UnreadableClip(
            f"{path}: '{SQUARE_PIXELS}' {found} and type {value.dtype}, expected one truth value; "
            f"save True or False or leave it out."
        )
    return bool(value.reshape(()))


SQUARE_PIXELS = "square_pixels"
"""Key of an archive that tells whether the camera's pixels were square when frames were saved."""

BESIDES = ("fps", "background", SQUARE_PIXELS)
"""Keys of an archive that hold no frames."""


def _key_of_frames(archive: zipfile.ZipFile, keys: list[str], name: str) -> str:
    """Return `frames`, else the only array, else the only one that may be pictures by its shape."""
    if "frames" in keys:
        return "frames"
    others = [key for key in keys if key not in BESIDES]
    if len(others) > 1:
        ranks = {key: _picture_rank(archive, key, name) for key in others}
        others = [key for key in others if ranks[key] == max(ranks.values()) > 0]
    if len(others) != 1:
        raise UnreadableClip(
            f"{name}: found the keys {', '.join(keys) or 'none'}, expected 'frames' (and "
            f"optionally 'fps', 'background', '{SQUARE_PIXELS}'); save the frames under that key."
        )
    return others[0]


def _picture_rank(archive: zipfile.ZipFile, key: str, name: str) -> int:
    """Return a rank by an array's shape: colour 3, with alpha 2, grey 1; 0 of no frames."""
    try:
        with archive.open(f"{key}.npy") as stream:
            shape, _, _ = _read_header(stream, name)
    except (UnreadableClip, KeyError, ValueError):  # not an array of numbers: no pictures either
        return 0
    if len(shape) == 4:
        return 3 if 3 in (shape[1], shape[3]) else 2 * (shape[3] == 4)
    return int(len(shape) == 3)


def read_still_array(path: Path, order: Order = "RGB") -> Frames:
    """Return the one image in a .npy file, uint8, shape (rows, columns, 3).

    Raises:
        UnreadableClip: If it holds no single image.
    """
    return still_to_rgb(map_array(path), order, str(path))


def map_array(path: Path) -> NDArray:
    """Return the array in a .npy file without reading its numbers yet; Python objects never.

    Raises:
        UnreadableClip: If the file is cut off, damaged, declares too much, or holds objects.
    """
    with _refusing_damage(str(path)):
        with path.open("rb") as stream:
            shape, _, dtype = _read_header(stream, str(path))
            needed = stream.tell() + math.prod(shape) * dtype.itemsize
        if path.stat().st_size < needed:
            raise UnreadableClip(
                f"{path}: is cut off, it has {path.stat().st_size} bytes and its header declares "
                f"{needed}; copy or record it again."
            )
        if math.prod(shape) == 0:  # numpy cannot map an empty array
            return np.empty(shape, dtype)
        return np.load(path, mmap_mode="r", allow_pickle=False)


def _read_header(stream: IO[bytes], name: str) -> tuple[tuple[int, ...], bool, np.dtype]:
    """Return the declared shape, whether the first axis runs fastest, and the type.

    Refuses what must not be read.
    """
    version = np.lib.format.read_magic(stream)
    read = np.lib.format.read_array_header_1_0
    if version != (1, 0):
        read = np.lib.format.read_array_header_2_0
    shape, is_fortran, dtype = read(stream)
    if dtype.hasobject:
        raise UnreadableClip(
            f"{name}: holds Python objects, which are never unpickled, expected uint8 frames "
            f"(T,H,W,3); stack frames of one size and save those."
        )
    declared = math.prod(shape) * dtype.itemsize
    if declared > DECLARED_BYTES:
        raise UnreadableClip(
            f"{name}: declares {declared / 2**30:.0f} GiB (shape {shape}), the limit is "
            f"{DECLARED_BYTES // 2**30} GiB; cut the recording into parts."
        )
    return shape, is_fortran, dtype


def _read_member(archive: zipfile.ZipFile, key: str, name: str) -> NDArray:
    with archive.open(f"{key}.npy") as stream:
        shape, _, dtype = _read_header(stream, name)
        _check_unpacked(shape, dtype, KEPT_BYTES, key, name)
    with archive.open(f"{key}.npy") as stream:
        return np.lib.format.read_array(stream, allow_pickle=False)


def _read_frames(archive: zipfile.ZipFile, key: str, name: str) -> tuple[NDArray, int, int]:
    """Return the frames that fit, at which step they were taken, and of how many.

    A compressed array cannot be mapped; one that is too large to be held is unpacked in blocks, of
    which every `step`-th frame is kept.
    """
    with archive.open(f"{key}.npy") as stream:
        shape, is_fortran, dtype = _read_header(stream, name)
        frame_bytes = math.prod(shape[1:]) * dtype.itemsize
        # Frames stored with the first axis fastest lie scattered over the whole array.
        is_whole = is_fortran or frame_bytes * FEWEST_KEPT > KEPT_BYTES
        most = KEPT_BYTES if is_whole else ARCHIVE_BYTES
        if _check_unpacked(shape, dtype, most, key, name) > KEPT_BYTES:
            step = -(-shape[0] // (KEPT_BYTES // frame_bytes))
            kept = np.empty((-(-shape[0] // step), *shape[1:]), dtype)
            at_once = max(BLOCK_BYTES // (step * frame_bytes), 1)
            for start in range(0, len(kept), at_once):
                count = min(step * at_once, shape[0] - step * start)
                block = np.frombuffer(stream.read(count * frame_bytes), dtype)
                kept[start : start + at_once] = block.reshape(count, *shape[1:])[::step]
            return kept, step, shape[0]
    frames = _read_member(archive, key, name)
    return frames, 1, shape[0] if shape else 0


def _check_unpacked(shape: tuple[int, ...], dtype: np.dtype, most: int, key: str, name: str) -> int:
    """Return the bytes an array of an archive unpacks to, refusing more than `most`."""
    declared = math.prod(shape) * dtype.itemsize
    if declared > most:
        raise UnreadableClip(
            f"{name}: '{key}' unpacks to {declared / 2**30:.1f} GiB, the limit for .npz is "
            f"{most / 2**30:g} GiB; save it as .npy instead."
        )
    return declared


ARCHIVE_BYTES = 4 * KEPT_BYTES
"""Bytes the frames of an archive may unpack to, of which `KEPT_BYTES` are held: a bound on time."""

BLOCK_BYTES = 16 * 2**20
"""Bytes of an archive unpacked at once, at least one step of frames."""


def _to_clip(
    stored: NDArray, layout: str | None, name: str, step: int = 1, count: int | None = None
) -> Clip:
    """Return stored frames, every `step`-th of a recording of `count`, as a clip that fits."""
    axes, order = parts_of(layout)
    found, layout_note = layout_of(stored.shape, axes, name)
    if stored.shape[0] == 0 or stored.size == 0:
        raise UnreadableClip(
            f"{name}: holds no pixels (shape {stored.shape}); record or export it again."
        )
    rows, columns = (stored.shape[found.index(axis)] for axis in "HW")
    more = stride_for(len(stored), rows, columns, name)
    frames, range_note = to_rgb(stored[::more], found, order, name)
    notes, count, stride = (layout_note, range_note), count or len(stored), step * more
    if stride > 1:
        notes = (*notes, stride_note(stride, count))
    numbers = tuple(range(0, count, stride))
    return Clip(frames, name=name, frame_numbers=numbers, notes=notes, recorded_frames=count)


def _one_number(value: NDArray, name: str) -> float | None:
    if value.size != 1 or value.dtype.kind not in "uif":
        raise UnreadableClip(
            f"{name}: 'fps' has shape {value.shape} and type {value.dtype}, expected one number; "
            f"save frames per second or leave it out."
        )
    return float(value.reshape(()))


@contextmanager
def _refusing_damage(name: str) -> Iterator[None]:
    """Turn whatever numpy and zipfile raise on a damaged file into one sentence.

    They believe what the file says and fail in a dozen ways: TypeError, OverflowError, MemoryError,
    TokenError on headers, BadZipFile, LZMAError, RuntimeError (encrypted) on archives, and more.
    """
    try:
        yield
    except UnreadableClip:
        raise
    except Exception as error:
        raise UnreadableClip(
            f"{name}: is cut off or is no numpy file, expected what numpy.save or numpy.savez "
            f"writes; copy or record it again."
        ) from error
