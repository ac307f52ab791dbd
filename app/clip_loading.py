"""Load an uploaded recording: read it, perceive it once, and name it as its owner does."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm import (
    CLIP_SUFFIXES,
    IMAGE_SUFFIXES,
    GeoTLMError,
    Seen,
    declared_bytes,
    read_clip,
    second_opinions,
)

from .budget import WORKING

if TYPE_CHECKING:
    from geotlm_lm import Answerer

Image = NDArray[np.uint8]

SUFFIXES = sorted({*CLIP_SUFFIXES, *IMAGE_SUFFIXES})
"""Endings of recordings, and of single frames, several of which are one."""

ADVICE = {
    "pass --layout THW": "save frames[..., None], or use the command line with --layout THW",
    "or, with --layout THW, (T,H,W)": "or, on the command line with --layout THW, (T,H,W)",
    "pass --layout": "use the command line with --layout",
    "pass --square-pixels": "use the command line with --square-pixels",
    "by --topic": "as `topic`, on the page under Frames and notes of the Ask tab",
}
"""What is said to a person at the command line, and to one who has none."""


@dataclass(frozen=True, eq=False)
class LoadedClip:
    """A clip that was read and perceived, ready for questions and pictures.

    `session` is the conversation about it, which remembers its turns and its frame of reference.
    """

    encoded: Any
    seen: Seen
    opinions: dict[str, Any]
    frames: list[tuple[Image, str]]
    notes: str
    session: Any


def load_clip(
    answerer: Answerer,
    path: str | list[str] | None,
    first: float | str | None = None,
    last: float | str | None = None,
    topic: str | None = None,
) -> LoadedClip:
    """Read the recording at `path`, and perceive or track it once.

    Args:
        answerer: The model.
        path: Of the recording, or of several images of it; None when nothing was given yet.
        first: First frame to use; None or no text to use all.
        last: Last frame to use.
        topic: Of a bag's images; None where it has images on one topic only.

    Raises:
        GeoTLMError: If there is no recording, or it cannot be used, in one sentence.
    """
    if not path:
        raise GeoTLMError("No recording was given; upload a clip first.")
    return perceive(answerer, read_named(path, topic), span=span_of(first, last))


def latest_upload(paths: list[str] | None) -> list[str]:
    """Return the recording that was given last, alone, or the images given after it.

    Args:
        paths: What was given one after the other: recordings, or images of one.
    """
    given = list(paths or [])
    whole = [place for place, one in enumerate(given) if not _is_image(one)]
    if not whole:
        return given
    return given[whole[-1] + 1 :] or given[-1:]


@contextmanager
def with_clip_name(folder: str | Path) -> Iterator[None]:
    """Tell what is wrong with a recording without the folder it lies in.

    Uploads lie in a temporary folder whose name means nothing to the person who uploaded.

    Args:
        folder: That is not named.
    """
    try:
        yield
    except GeoTLMError as error:
        sentence = str(error).replace(f"{folder}/", "").replace(str(folder), "the images")
        if sentence == str(error):
            raise
        raise type(error)(_advised(sentence)) from error


def perceive(
    answerer: Answerer,
    recording: Any,
    *,
    span: tuple[int, int] | None = None,
    track: Any = None,
    depth_mm: NDArray[np.float32] | None = None,
) -> LoadedClip:
    """Perceive a recording once, and draw and judge it by other means beside.

    Args:
        answerer: The model.
        recording: A `Clip` of two frames or more.
        span: First and last frame to use; None to use all.
        track: Of the recording, where it was tracked before.
        depth_mm: True indentation of each frame, where it was simulated.
    """
    encoded = answerer.encode(recording, span=span, track=track)
    clip = encoded.clip
    geometry = encoded.perception.geometry
    field, mask = (np.asarray(x[0], np.float32) for x in (geometry.shear_change, geometry.mask))
    threshold = answerer.bundle.calibration.contact_threshold
    captions = [f"frame {number}" for number in clip.frame_numbers]
    return LoadedClip(
        encoded=encoded,
        seen=Seen(
            clip.frames,
            clip.background,
            field,
            mask,
            encoded.view,
            depth_mm,
            has_contact=not encoded.is_untouched and encoded.contact_share >= threshold,
        ),
        opinions=second_opinions(answerer, encoded).to_dict(),
        frames=list(zip(clip.frames, captions, strict=True)),
        notes="\n".join(f"- {note}" for note in clip.notes),
        session=answerer.session(encoded),
    )


def span_of(first: float | str | None, last: float | str | None) -> tuple[int, int] | None:
    """Return the first and last frame; None where neither is given.

    Raises:
        GeoTLMError: If only one is given, or one is no whole number.
    """
    ends = ["" if one is None else str(one).strip() for one in (first, last)]
    if not any(ends):
        return None
    if not all(ends):
        raise GeoTLMError("Only one end of the span was given; give both frame numbers or none.")
    if not all(one.isdecimal() for one in ends):
        raise GeoTLMError(
            f"The span was {ends[0]} to {ends[1]}, expected two whole numbers; "
            f"give the numbers of two frames, counted from 0, or leave both fields empty."
        )
    return int(ends[0]), int(ends[1])


def read_named(path: str | list[str], topic: str | None = None) -> Any:
    """Return the recording in one file, or in several images, named as whoever gave it knows it.

    Args:
        path: Of the file, or of a folder of images, or of each image.
        topic: As `load_clip` has it.

    Raises:
        GeoTLMError: If it cannot be read, or others' recordings take the memory.
    """
    paths = [path] if isinstance(path, str) else list(path)
    if len(paths) == 1:
        path = Path(paths[0])
        with with_clip_name(path.parent):
            read = partial(read_clip, path, topic=topic)
            return _named(WORKING.read(declared_bytes(path), read), path.name)
    if not all(_is_image(one) for one in paths):
        raise GeoTLMError("Several recordings were given; give one, or the images of one.")
    with tempfile.TemporaryDirectory() as folder, with_clip_name(folder):
        for one in paths:
            shutil.copy(one, Path(folder) / Path(one).name)
        read = partial(read_clip, folder)
        return _named(WORKING.read(declared_bytes(Path(folder)), read), "the images")


def _named(clip: Any, name: str) -> Any:
    return replace(clip, name=name, notes=tuple(map(_advised, clip.notes)))


def _advised(sentence: str) -> str:
    """Return a sentence with advice that can be followed without the command line."""
    for said, instead in ADVICE.items():
        sentence = sentence.replace(said, instead)
    return sentence


def _is_image(path: str) -> bool:
    return Path(path).suffix.lower() in IMAGE_SUFFIXES
