"""Frames from .npy and .npz files; headers are checked before anything is read or allocated."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Callable, Collection, Iterator
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip, UsageError, damage_as
from geotlm_lm.recordings.pixels import (
    Layout,
    check_layout,
    layout_of,
    parts_of,
    require_numbers,
    rgb_frames,
    still_to_rgb,
)
from geotlm_lm.recordings.policy import (
    DECLARED_BYTES,
    FEWEST_KEPT,
    KEPT_BYTES,
    Source,
    SourceFrame,
    kept_frames,
    read_source,
)

ARRAY_SUFFIXES = (".npy", ".npz")

SQUARE_PIXELS = "square_pixels"
"""Key of an archive that says whether the camera's pixels were square when frames were saved."""

BESIDES = ("fps", "background", "layout", SQUARE_PIXELS)
"""Keys of an archive that hold no frames."""

MOST_ARRAYS = 100
"""Of an archive that is looked through for the one that holds frames."""

PLAIN_BYTES, MOST_PACKED = 64 * 2**20, 200
"""Bytes beyond which an array must not unpack to more than so many times what it takes in the file:
frames that a sensor recorded pack to a third, and black ones to a thousandth."""

STILL_BYTES = KEPT_BYTES // FEWEST_KEPT
"""Bytes that an array beside the frames may unpack to: no frame is larger."""

ARCHIVE_BYTES = 4 * KEPT_BYTES
"""Bytes the frames of an archive may unpack to, of which `KEPT_BYTES` are held: a bound on time."""

BLOCK_BYTES = 16 * 2**20
"""Bytes of an archive unpacked at once, at least one step of frames."""


def read_array(path: Path, layout: str | None = None) -> Clip:
    """Return the clip in a .npy file, of a checked layout, None to guess it."""
    stored = map_array(path)
    return _clip_of(lambda stride: stored[::stride], stored.shape, stored.dtype, layout, str(path))


def read_archive(path: Path, layout: str | None = None) -> Clip:
    """Return the clip in a .npz file with `frames` and, optionally, `fps`, `background`, `layout`.

    Where no array is called `frames`, the only other one is taken for them (`numpy.savez(path,
    frames)` calls it `arr_0`), or of several the only one with the shape of pictures, in colour
    before grey, as in an archive of `rgb` and `depth`. A note says so. The layout is checked, None
    to guess it; the background has the same order of colours.
    """
    name = str(path)
    with _refusing_damage(name), zipfile.ZipFile(path) as archive:
        keys = _keys(archive)
        key = _key_of_frames(archive, keys, name)
        layout = layout or _stated_layout(archive, keys)
        # All that can be refused by what is declared is refused before anything is unpacked.
        shape, is_fortran, dtype = _member_header(archive, key, name)
        _require_frames(shape, dtype, layout, name)
        beside = [beside for beside in ("fps", "background") if beside in keys]
        for other in beside:
            other_shape, _, other_dtype = _member_header(archive, other, name)
            _check_unpacked(other_shape, other_dtype, STILL_BYTES, other, name)
        # Stored with the first axis fastest, a frame lies scattered over the whole array.
        frame_bytes = math.prod(shape[1:]) * dtype.itemsize
        is_whole = is_fortran or frame_bytes * FEWEST_KEPT > KEPT_BYTES
        _check_unpacked(shape, dtype, KEPT_BYTES if is_whole else ARCHIVE_BYTES, key, name)
    # A compressed array cannot be mapped: frames are held as stored beside those in RGB.
    held_bytes = 0 if is_whole else frame_bytes
    clip = _clip_of(
        lambda stride: _unpacked(path, key, stride), shape, dtype, layout, name, held_bytes
    )
    if key != "frames":
        clip = clip.with_note(f"The array '{key}' was taken for the frames.")
    with _refusing_damage(name), zipfile.ZipFile(path) as archive:
        others = {other: _read_member(archive, other) for other in beside}
    fps, idle = others.get("fps"), others.get("background")
    return replace(
        clip,
        fps=None if fps is None else _number(fps, name),
        background=None if idle is None else still_to_rgb(idle, parts_of(layout)[1], name),
    )


def _stated_layout(archive: zipfile.ZipFile, keys: Collection[str]) -> str | None:
    """Return what an archive states by `layout`; None where that is missing or no layout."""
    if "layout" not in keys or _member_header(archive, "layout", "")[2].kind != "U":
        return None
    try:
        return check_layout(str(_read_member(archive, "layout")))
    except UsageError:
        return None


def stated_square_pixels(path: Path) -> bool | None:
    """Return whether a .npz states by `square_pixels` that they are; None where it does not."""
    with _refusing_damage(str(path)), zipfile.ZipFile(path) as archive:
        if f"{SQUARE_PIXELS}.npy" not in archive.namelist():
            return None
        value = _read_member(archive, SQUARE_PIXELS)
    is_one = value.size == 1 and value.dtype.kind in "bui"
    if not is_one or value.reshape(()) not in (0, 1):
        held = f"has value {value.reshape(())}" if is_one else f"has shape {value.shape}"
        raise UnreadableClip(
            f"{path}: '{SQUARE_PIXELS}' {held} and type {value.dtype}, expected one truth value; "
            f"save True or False or leave it out."
        )
    return bool(value.reshape(()))


def declared_count(path: Path) -> tuple[int | None, float | None]:
    """Return how many frames a .npy or .npz file holds, and the rate that it states."""
    if path.suffix.lower() == ".npy":
        return next(iter(map_array(path).shape), None), None
    name = str(path)
    with _refusing_damage(name), zipfile.ZipFile(path) as archive:
        keys = _keys(archive)
        shape, _, _ = _member_header(archive, _key_of_frames(archive, keys, name), name)
        if "fps" not in keys or math.prod(_member_header(archive, "fps", name)[0]) != 1:
            return next(iter(shape), None), None
        return next(iter(shape), None), _number(_read_member(archive, "fps"), name)


def declared_frames(path: Path) -> int:
    """Return the bytes that the frames in a .npy or .npz file take; twice as many while read."""
    name = str(path)
    if path.suffix.lower() == ".npy":
        return _as_rgb(map_array(path).shape)
    with _refusing_damage(name), zipfile.ZipFile(path) as archive:
        key = _key_of_frames(archive, _keys(archive), name)
        shape, _, dtype = _member_header(archive, key, name)
        packed = min(math.prod(shape) * dtype.itemsize, KEPT_BYTES)
        return max(_as_rgb(shape), (packed + _as_rgb(shape)) // 2)


def _as_rgb(shape: tuple[int, ...]) -> int:
    return math.prod(shape) * (1 if 3 in shape[1:] else 3)


def _keys(archive: zipfile.ZipFile) -> list[str]:
    return sorted(entry.removesuffix(".npy") for entry in archive.namelist())


def _key_of_frames(archive: zipfile.ZipFile, keys: list[str], name: str) -> str:
    """Return `frames`, else the only array, else the only one that may be pictures by its shape."""
    if "frames" in keys:
        return "frames"
    others = [key for key in keys if key not in BESIDES]
    if MOST_ARRAYS > len(others) > 1:
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


def map_array(path: Path) -> NDArray:
    """Return the array in a .npy file without reading its numbers yet; Python objects never."""
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
    """Return the declared shape, whether the first axis runs fastest, and the type."""
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


def _member_header(
    archive: zipfile.ZipFile, key: str, name: str
) -> tuple[tuple[int, ...], bool, np.dtype]:
    """Return what an array of an archive declares, refusing what it cannot hold or nobody needs."""
    stored = archive.getinfo(f"{key}.npy")
    with archive.open(stored) as stream:
        shape, is_fortran, dtype = _read_header(stream, name)
        needed = stream.tell() + math.prod(shape) * dtype.itemsize
    if stored.file_size < needed <= ARCHIVE_BYTES:  # of more the sentence is another
        raise zipfile.BadZipFile(f"{stored.file_size} bytes of {needed}")
    times = stored.file_size / max(stored.compress_size, 1)
    if stored.file_size > PLAIN_BYTES and times > MOST_PACKED:
        raise UnreadableClip(
            f"{name}: '{key}' unpacks to {stored.file_size // 2**20} MiB, {times:.0f} times what "
            f"it takes, expected at most {MOST_PACKED} times, as a camera's noise cannot be "
            f"packed; save what was recorded."
        )
    return shape, is_fortran, dtype


def _require_frames(
    shape: tuple[int, ...], dtype: np.dtype, layout: str | None, name: str
) -> tuple[Layout, str | None]:
    """Return the layout of frames that are declared, refusing what can be none."""
    axes, note = layout_of(shape, parts_of(layout)[0], name)
    if math.prod(shape) == 0:
        raise UnreadableClip(f"{name}: holds no pixels (shape {shape}); record or export it again.")
    require_numbers(dtype, name)
    kept_frames(*(shape[axes.index(axis)] for axis in "HW"), name)
    return axes, note


def _read_member(archive: zipfile.ZipFile, key: str) -> NDArray:
    with archive.open(f"{key}.npy") as stream:
        return np.lib.format.read_array(stream, allow_pickle=False)


def _unpacked(path: Path, key: str, stride: int) -> NDArray:
    """Return every `stride`-th frame, in blocks: all of them need not fit."""
    with _refusing_damage(str(path)), zipfile.ZipFile(path) as archive:
        with archive.open(f"{key}.npy") as stream:
            shape, is_fortran, dtype = _read_header(stream, str(path))
            if stride > 1 and not is_fortran:
                frame_bytes = math.prod(shape[1:]) * dtype.itemsize
                kept = np.empty((-(-shape[0] // stride), *shape[1:]), dtype)
                at_once = max(BLOCK_BYTES // (stride * frame_bytes), 1)
                for start in range(0, len(kept), at_once):
                    count = min(stride * at_once, shape[0] - stride * start)
                    block = np.frombuffer(stream.read(count * frame_bytes), dtype)
                    kept[start : start + at_once] = block.reshape(count, *shape[1:])[::stride]
                return kept
        return _read_member(archive, key)[::stride]


def _check_unpacked(
    shape: tuple[int, ...], dtype: np.dtype, most: int, key: str, name: str
) -> None:
    declared = math.prod(shape) * dtype.itemsize
    if declared > most:
        raise UnreadableClip(
            f"{name}: '{key}' unpacks to {declared / 2**30:.1f} GiB, the limit for .npz is "
            f"{most / 2**30:g} GiB; save it as .npy instead."
        )


def _clip_of(
    stored_at: Callable[[int], NDArray],
    shape: tuple[int, ...],
    dtype: np.dtype,
    layout: str | None,
    name: str,
    held_bytes: int = 0,
) -> Clip:
    """Return the clip of frames of a declared shape, which `stored_at` gives at a stride."""
    axes, layout_note = _require_frames(shape, dtype, layout, name)
    notes = [] if layout_note is None else [layout_note]

    def frames(stride: int) -> Iterator[SourceFrame]:
        pictures, more = rgb_frames(stored_at(stride), axes, parts_of(layout)[1], name)
        notes.extend(more)
        yield from map(SourceFrame, pictures)

    rows, columns = (shape[axes.index(axis)] for axis in "HW")
    return read_source(
        Source(name, frames, shape[0], (rows, columns), stored_bytes=held_bytes, notes=notes)
    )


def _number(value: NDArray, name: str) -> float | None:
    if value.size != 1 or value.dtype.kind not in "uif":
        raise UnreadableClip(
            f"{name}: 'fps' has shape {value.shape} and type {value.dtype}, expected one number; "
            f"save frames per second or leave it out."
        )
    return float(value.reshape(()))


def _refusing_damage(name: str) -> AbstractContextManager[None]:
    return damage_as(
        f"{name}: is cut off or is no numpy file, expected what numpy.save or numpy.savez "
        f"writes; copy or record it again."
    )
