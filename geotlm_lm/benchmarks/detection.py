"""How small a motion is told, what is told of none, and whether and when something touches.

Real imprints are moved and held over real idle frames. Recordings that begin untouched, and grips
already closed, are shown with their idle gel given, and without, where that has to be found.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from geotlm_lm.benchmarks.candidates import CANDIDATES, METHODS, MOVING, TOLD, Leanings, leanings
from geotlm_lm.benchmarks.cases import HALVES, Half, by_half, half_of, rows_of_half, titled
from geotlm_lm.benchmarks.harness import Listing, Pivot, Row, Run, Section, Share
from geotlm_lm.benchmarks.imprints import (
    BEFORE_LABEL,
    GRIPS,
    RELEASES,
    SOURCES,
    MovedImprint,
    moved_imprints,
    picture,
    table_rows,
)
from geotlm_lm.benchmarks.judging import Graded, share_row, share_rows
from geotlm_lm.benchmarks.rendering import right_with_interval
from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.edit import opposite
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import Component
from geotlm_lm.data.touch_table import TABLE_NAME, read_touch_table
from geotlm_lm.recordings.read import read_clip
from geotlm_lm.track.events import EventKind

if TYPE_CHECKING:
    from geotlm_lm.answering import Encoded

UNMOVED = {
    Motion.STILL: "held still",
    Motion.PRESS: "pressed in",
    Motion.RELEASE: "let go",
    Motion.NONE: "untouched",
}
"""Truths in which nothing turns and nothing slides -> what is shown."""

NOUNS = {Component.TURN: "turns", Component.SLIDE: "slides"}

Answered = tuple[MovedImprint, Leanings]


def detection_shares(run: Run) -> Mapping[str, Share]:
    """Return what yields the rows of each kind of gel and half."""
    if run.real is None:
        return {}
    return {
        titled(kind, half): partial(_rows, run, run.real, kind, half)
        for kind in SOURCES
        for half in HALVES
    }


def _rows(run: Run, folder: Path, kind: str, half: Half) -> Iterator[Row]:
    options = {"most": 1, "sizes_px": (0.2, 1.0), "held": 1} if run.is_quick else {}
    clips = moved_imprints(folder, half, seed=run.seed, kinds=(kind,), **options)
    answered: dict[str, list[Answered]] = {}
    shown: set[str] = set()
    for moved in clips:
        if moved.object_id not in shown:
            shown.add(moved.object_id)
            run.progress(f"moved imprints, {titled(kind, half)}", len(shown), len(shown))
        seen = leanings(run.answerer, moved.clip)
        answered.setdefault(case_of(moved), []).append((replace(moved, clip=None), seen))
    for case in sorted(answered):
        own = answered[case]
        made = moved_rows if own[0][0].component in MOVING else unmoved_rows
        yield from made(titled(case, half), own, run.seed)
        if own[0][0].way is Motion.PRESS:
            backwards = answered[case.replace(UNMOVED[Motion.PRESS], UNMOVED[Motion.RELEASE])]
            case = case.replace(UNMOVED[Motion.PRESS], "claimed of a press, survives backwards")
            yield from surviving_rows(titled(case, half), own, backwards, run.seed)


def case_of(moved: MovedImprint) -> str:
    """Return the name of the set of like clips that one belongs to."""
    frames = {"four": "four frames", "pair": "pairs"}[moved.frames]
    shown = UNMOVED.get(moved.way) or f"{NOUNS[moved.component]} by {moved.path_px:g} px"
    return f"{moved.kind}, {shown}, {frames}"


def moved_rows(case: str, answered: Sequence[Answered], seed: int) -> Iterator[Row]:
    """Yield what is told of motions of one size, and what each method leans to."""
    families = [moved.family for moved, _ in answered]
    named = [(seen.named(moved.component), moved.way) for moved, seen in answered]
    detail = {
        "claimed": float(np.mean([way is not None for way, _ in named])),
        "wrong_way": float(np.mean([way not in (None, true) for way, true in named])),
        "refused": sum(seen.belief is None for _, seen in answered),
    }
    yield share_row(case, TOLD, [way is true for way, true in named], families, seed, detail=detail)
    for name in METHODS:
        right = [seen.leans(name, moved.component) is moved.way for moved, seen in answered]
        yield share_row(case, name, right, families, seed, detail=off_by(name, answered))


def off_by(name: str, answered: Sequence[Answered]) -> dict[str, float]:
    """Return the path in px that a candidate stays below in 95 of 100 clips, where it has any."""
    paths = [seen.paths[name] for _, seen in answered if name in seen.paths]
    if not paths:
        return {}
    turn, right, down = np.abs(paths).T
    far = {"turn": turn, "slide": np.hypot(right, down)}
    return {f"{part}_px_95": float(np.quantile(values, 0.95)) for part, values in far.items()}


def unmoved_rows(case: str, answered: Sequence[Answered], seed: int) -> Iterator[Row]:
    """Yield the share of clips in which no turn and no slide is told, there being none."""
    families = [moved.family for moved, _ in answered]
    claimed = {
        part: np.array([seen.named(part) is not None for _, seen in answered]) for part in MOVING
    }
    touches = [seen.belief is not None and seen.belief.contact >= 0.5 for _, seen in answered]
    detail = {str(part): float(own.mean()) for part, own in claimed.items()}
    detail["touch"] = float(np.mean(touches))
    silent = ~np.logical_or(*claimed.values())
    yield share_row(case, TOLD, silent, families, seed, detail=detail)
    # Of what grows, a path is no noise.
    for name in CANDIDATES if answered[0][0].way is Motion.STILL else ():
        yield Row(case, name, len(answered), detail=off_by(name, answered))


def surviving_rows(
    case: str, pressed: Sequence[Answered], backwards: Sequence[Answered], seed: int
) -> Iterator[Row]:
    """Yield the share of turns told of a press that are told the other way of it backwards."""
    survives, families = [], []
    for (moved, seen), (_, reverse) in zip(pressed, backwards, strict=True):
        if way := seen.named(Component.TURN):
            survives.append(reverse.named(Component.TURN) is opposite(way))
            families.append(moved.family)
    if survives:
        yield share_row(case, TOLD, survives, families, seed)


def _is_moved(row: Row) -> bool:
    return " by " in row.case


_UNMOVED_COLUMNS = {
    "clips": "case",
    "n": "count",
    "method": "variant",
    "right (95 %)": right_with_interval,
    "a turn told": "turn:.3f",
    "a slide told": "slide:.3f",
    "touch told": "touch:.3f",
    "turn px, 95 %": "turn_px_95:.3f",
    "slide px, 95 %": "slide_px_95:.3f",
}

_TOLD_COLUMNS = {
    "clips": "case",
    "n": "count",
    "told the right way (95 %)": right_with_interval,
    "told at all": "claimed:.3f",
    "the wrong way": "wrong_way:.3f",
    "refused": "refused",
}


DETECTION = Section(
    name="detection",
    title="How small a motion is told",
    about="""\
Real imprints over real idle frames of the same gel in turn, with their noise, codec and flicker:
moved by a known path (pixels of a 224-pixel image, 0.08 mm on a GelSight Mini; of turns at the
contact's radius), held still, pressed in and let go, or left out. *Told* is what is decided: a
component moves and goes this way. The others are forced to choose a way, whether or not anything is
told: the belief by its leaning, each single measurement, and both rivals. Of clips in which nothing
turns or slides, nothing may be told, and a turn told of a press has to be told the other way of the
same played backwards; beside it the path that a measurement stays below in 95 of 100
of them. *physiclear* and *calibration* are unmarked gels, *gelslim4* and *letac* have dots; a
calibration has one idle picture, with fresh noise.""",
    views=by_half(
        Listing(_TOLD_COLUMNS, lambda row: _is_moved(row) and row.variant == TOLD), "Moved: told"
    )
    | by_half(
        Pivot("right:.3f", shows=lambda row: _is_moved(row) and row.variant != TOLD),
        "Moved: the right way, as a forced choice",
    )
    | by_half(Listing(_UNMOVED_COLUMNS, lambda row: not _is_moved(row)), "Nothing turns or slides"),
    shares=detection_shares,
)


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


def contact_grades(recording: Recording, encoded: Encoded | None) -> Iterator[tuple[str, bool]]:
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
    return {half: partial(_contact_rows, run, run.real, half) for half in HALVES}


def _contact_rows(run: Run, folder: Path, half: Half) -> Iterator[Row]:
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
                for what, is_right in contact_grades(recording, encoded):
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
