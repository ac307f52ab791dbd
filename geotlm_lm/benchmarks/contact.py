"""Whether and when something touches: recordings that begin untouched, and grips already closed.

Each is shown with its idle gel given, and without, where that has to be found.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from geotlm_lm.benchmarks.cases import HALVES, Half, by_half, half_of, rows_of_half, titled
from geotlm_lm.benchmarks.harness import Pivot, Row, Run, Section, Share
from geotlm_lm.benchmarks.imprints import BEFORE_LABEL, GRIPS, RELEASES, picture, table_rows
from geotlm_lm.benchmarks.judging import Graded, share_rows
from geotlm_lm.benchmarks.rendering import right_with_interval
from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.data.touch_table import TABLE_NAME, read_touch_table
from geotlm_lm.recordings.read import read_clip
from geotlm_lm.track.events import EventKind

if TYPE_CHECKING:
    from geotlm_lm.answering import Encoded

WITHIN_FRAMES = 3
"""Frames by which a begin of contact may be off: labels by eye are no surer."""

EVERY = 3
"""Of recordings of unmarked gels, which are many."""

NEVER = -1
"""In the place of a first touched frame where nothing touches."""


@dataclass(frozen=True, eq=False)
class Recording:
    """A recording without its idle gel, and what is true of its contact."""

    clip: Clip
    idle: Frames
    kind: str
    family: str
    begin: int  # first touched frame: 0 where it is touched throughout, NEVER without a touch
    only_presses: bool = False  # whether nothing is ever lifted


def contact_recordings(folder: Path, half: Half) -> Iterator[Recording]:
    """Yield the recordings of a half whose contact is known: with dots first, then unmarked."""
    yield from _grips(folder / GRIPS, half)
    yield from _releases(folder / RELEASES, half)
    for table in sorted(folder.glob(f"*/{TABLE_NAME}")):
        for row in rows_of_half(read_touch_table(table), half)[::EVERY]:
            clip = read_clip(row.path)
            idle = _middle(clip.frames[row.surely_idle])
            yield Recording(clip, idle, table.parent.name, row.object_family, row.contact_start)


def _grips(own: Path, half: Half) -> Iterator[Recording]:
    for row in table_rows(own / "labels.csv"):
        family, begin = row["clip"].rpartition("_")[0], int(row["contact_from"])
        if half_of(family) == half:
            clip = read_clip(own / row["clip"])
            before = clip.select(range(begin - BEFORE_LABEL))
            idle = _middle(before.frames)
            yield Recording(clip, idle, "gelslim4", family, begin, only_presses=True)
            yield Recording(before, idle, "gelslim4, cut before the touch", family, NEVER)


def _releases(own: Path, half: Half) -> Iterator[Recording]:
    """Yield grips that open, and backwards: closed by and by, after the gel was seen untouched."""
    rows = table_rows(own / "labels.csv")
    untouched = [read_clip(own / row["name"]) for row in rows if row["label"] == "no contact"]
    idle = picture(own / "idle.png") if rows else None
    for row in rows:
        family = row["name"].partition("_tr_")[0]
        if half_of(family) != half:
            continue
        clip = read_clip(own / row["name"])
        if row["label"] == "no contact":
            yield Recording(clip, idle, "letac, nothing touches", family, NEVER)
            continue
        closing = Clip(clip.frames[::-1], name=clip.name)  # with numbers that rise
        yield Recording(clip, idle, "letac, touched throughout", family, 0)
        yield Recording(closing, idle, "letac, played backwards", family, 0, only_presses=True)
        joined = Clip(np.concatenate([untouched[0].frames, closing.frames]), name=clip.name)
        begin = len(untouched[0])
        yield Recording(joined, idle, "letac, begins untouched", family, begin, only_presses=True)


def grades(recording: Recording, encoded: Encoded | None) -> Iterator[tuple[str, bool]]:
    """Yield what is graded of a recording's contact, and whether it is right.

    Of one that was refused (None) nothing is known, and nothing told.
    """
    begin, count = recording.begin, len(recording.clip)
    is_known = encoded is not None and encoded.belief.is_contact_known
    touched, kinds = np.zeros(count, bool), set()
    if is_known:
        touched[encoded.track.numbers] = encoded.track.is_touched
    if encoded is not None:
        kinds = {event.kind for event in encoded.track.events}
    yield "contact known", is_known
    if begin == NEVER:
        yield "no touch told", not touched.any()
    elif begin:
        yield "no touch told before it", not touched[: max(begin - BEFORE_LABEL, 1)].any()
        is_near = touched.any() and abs(int(np.argmax(touched)) - begin) <= WITHIN_FRAMES
        yield f"begins within {WITHIN_FRAMES} frames", bool(is_near)
    else:
        yield "touch told", bool(touched.mean() >= 0.5)
    if recording.only_presses:
        yield "press not told as release", EventKind.RELEASE not in kinds


def contact_shares(run: Run) -> Mapping[str, Share]:
    """Return what yields the rows of each half."""
    if run.real is None:
        return {}
    return {half: partial(_rows, run, run.real, half) for half in HALVES}


def _rows(run: Run, folder: Path, half: Half) -> Iterator[Row]:
    def graded() -> Iterator[Graded]:
        shown: dict[str, int] = {}
        for recording in contact_recordings(folder, half):
            title = titled(recording.kind, half)
            shown[title] = shown.get(title, 0) + 1
            if run.is_quick and shown[title] > 1:
                continue
            run.progress(f"contact, {title}", shown[title], shown[title])
            for variant, idle in (("idle gel found", None), ("idle gel given", recording.idle)):
                clip = replace(recording.clip, background=idle)
                try:
                    encoded = run.answerer.encode(clip)
                except UnreadableClip:
                    encoded = None
                for what, is_right in grades(recording, encoded):
                    yield f"{title}: {what}", variant, is_right, recording.family

    yield from share_rows(graded(), run.seed)


def _middle(frames: Frames) -> Frames:
    return np.median(frames, axis=0).astype(np.uint8)


CONTACT = Section(
    name="contact",
    title="Whether and when something touches",
    about=f"""\
Recordings that begin untouched, on gels with dots (*gelslim4*, *letac*) and on unmarked ones; clips
in which nothing touches; grips that are closed from the first frame. The *idle gel* is found in the
recording, or given. A touch told while contact is not known is none. *Begins* may be off by
{WITHIN_FRAMES} frames. Where nothing is lifted, no release may be told. *Letac, begins untouched*
joins untouched frames and a grip's, the latter backwards: a press.""",
    shares=contact_shares,
    views=by_half(Pivot(right_with_interval, "recordings, what is graded")),
)
