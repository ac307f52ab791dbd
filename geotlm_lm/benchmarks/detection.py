"""How small a motion is told, and what is told where there is none.

Real imprints are moved and held over real idle frames.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from geotlm_lm.benchmarks.candidates import CANDIDATES, METHODS, MOVING, TOLD, Leanings, leanings
from geotlm_lm.benchmarks.cases import HALVES, Half, by_half, titled
from geotlm_lm.benchmarks.harness import Listing, Pivot, Row, Run, Section, Share
from geotlm_lm.benchmarks.imprints import SOURCES, MovedImprint, moved_imprints
from geotlm_lm.benchmarks.judging import clustered_interval, share_row
from geotlm_lm.benchmarks.rendering import number, right_with_interval
from geotlm_lm.core.edit import opposite
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import Component

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
    families, named, right = [], [], []
    leaning: dict[str, list[bool]] = {name: [] for name in METHODS}
    for moved, seen in answered:
        families.append(moved.family)
        named.append(seen.named(moved.component))
        right.append(named[-1] is moved.way)
        for name, own in leaning.items():
            own.append(seen.leans(name, moved.component) is moved.way)
    claims = np.array([way is not None for way in named])
    detail = {
        "claimed": float(claims.mean()),
        "claimed_interval": clustered_interval(claims, families, seed=seed),
        "wrong_way": float((claims & ~np.array(right)).mean()),
        "refused": sum(seen.belief is None for _, seen in answered),
    }
    yield share_row(case, TOLD, right, families, seed, detail=detail)
    for name, own in leaning.items():
        detail = off_by(name, answered)
        yield share_row(case, name, own, families, seed, detail=detail)


def off_by(name: str, answered: Sequence[Answered]) -> dict[str, float]:
    """Return the median and 95th percentile of a candidate's path in px; none of what has none."""
    paths = [seen.paths[name] for _, seen in answered if name in seen.paths]
    if not paths:
        return {}
    turn, right, down = np.abs(paths).T
    slide = np.hypot(right, down)
    return {
        f"{part}_px_{rank}": float(np.quantile(values, rank / 100))
        for part, values in (("turn", turn), ("slide", slide))
        for rank in (50, 95)
    }


def unmoved_rows(case: str, answered: Sequence[Answered], seed: int) -> Iterator[Row]:
    """Yield the share of clips in which no turn and no slide is told, there being none."""
    families = [moved.family for moved, _ in answered]
    claimed = {
        part: np.array([seen.named(part) is not None for _, seen in answered]) for part in MOVING
    }
    touch = np.mean(
        [seen.belief is not None and seen.belief.contact >= 0.5 for _, seen in answered]
    )
    detail = {str(part): float(own.mean()) for part, own in claimed.items()} | {
        "touch": float(touch)
    }
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


def _share(name: str) -> Callable[[Row], str]:
    return lambda row: number(row.detail.get(name))


def _is_moved(row: Row) -> bool:
    return " by " in row.case


_UNMOVED_COLUMNS = {
    "clips": lambda row: row.case,
    "n": lambda row: str(row.count),
    "method": lambda row: row.variant,
    "right (95 %)": right_with_interval,
    "a turn told": _share("turn"),
    "a slide told": _share("slide"),
    "touch told": _share("touch"),
    "turn px, 95 %": _share("turn_px_95"),
    "slide px, 95 %": _share("slide_px_95"),
}

_TOLD_COLUMNS = {
    "clips": lambda row: row.case,
    "n": lambda row: str(row.count),
    "told the right way (95 %)": right_with_interval,
    "told at all": _share("claimed"),
    "the wrong way": _share("wrong_way"),
    "refused": lambda row: str(row.detail["refused"]),
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
    run=lambda run: (row for share in detection_shares(run).values() for row in share()),
    views=by_half(
        Listing(_TOLD_COLUMNS), "Moved: told", lambda row: _is_moved(row) and row.variant == TOLD
    )
    | by_half(
        Pivot(lambda row: number(row.right)),
        "Moved: the right way, as a forced choice",
        lambda row: _is_moved(row) and row.variant != TOLD,
    )
    | by_half(Listing(_UNMOVED_COLUMNS), "Nothing turns or slides", lambda row: not _is_moved(row)),
    shares=detection_shares,
)
