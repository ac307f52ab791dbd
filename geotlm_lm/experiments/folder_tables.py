"""Tables of what a folder of recordings can be asked beyond its labelled windows.

Whole recordings, gels that nothing touches, presses, and what is made of real imprints.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from geotlm_lm.core.labels import SLIDES, Motion
from geotlm_lm.data.touch_table import DirectedRow, TouchRow, UntouchedRow
from geotlm_lm.experiments.compare import Method, ask_all, claims, per_object, summarise
from geotlm_lm.experiments.methods import BY_OBJECT, CONTRASTS, in_question
from geotlm_lm.experiments.negatives import NoContactWindows, PressedIn, backwards
from geotlm_lm.experiments.semi_real import SemiRealHeld, SemiRealSlides, UntouchedCases
from geotlm_lm.experiments.whole_recordings import WholeRecordings

Progress = Callable[[str, int, int], None]
"""Called with what is being judged, how many clips are done, and how many there are."""


def judge_whole(
    methods: Mapping[str, Method],
    name: str,
    directed: Sequence[DirectedRow],
    seed: int,
    progress: Progress,
) -> dict[str, Any]:
    """Return the table of one folder's recordings as a user hands them over: whole."""
    title, cases = f"real {name}, whole recordings", WholeRecordings(directed)
    tell = telling(progress, title, len(cases))
    replies = ask_all(in_question(methods, cases.among), cases, cases.among, tell)
    table = summarise(replies, CONTRASTS, seed=seed)
    return {title: table | {"by_object": per_object(replies, BY_OBJECT)}}


def judge_negatives(
    methods: Mapping[str, Method],
    name: str,
    touched: Sequence[TouchRow],
    untouched: Sequence[UntouchedRow],
    seed: int,
    progress: Progress,
    contrasts: Sequence[tuple[str, str]] = CONTRASTS,
) -> dict[str, Any]:
    """Return the tables of clips without a direction: no contact, pressed in only, held still.

    Each clip is also played backwards, which speaks for or against a direction that is claimed.
    """
    tables = {}
    windows = NoContactWindows(untouched)
    for title, cases, total in (
        (f"real {name}, no visible contact", windows, len(untouched)),
        (f"real {name}, pressed in", PressedIn(touched), len(PressedIn(touched))),
        (f"semi-real {name}, held or pressed", SemiRealHeld(touched, seed), 3 * len(touched)),
    ):
        replies = ask_all(
            in_question(methods, tuple(Motion)),
            cases,
            tuple(Motion),
            telling(progress, title, total),
        )
        if len(replies):
            tell = telling(progress, f"{title}, backwards", total)
            turned = ask_all(
                in_question(methods, tuple(Motion)), backwards(cases), tuple(Motion), tell
            )
            tables[title] = summarise(replies, contrasts, seed=seed)
            tables[title]["claims"] = claims(replies, turned)
    if windows.too_short and (title := f"real {name}, no visible contact") in tables:
        tables[title]["too_short_left_out"] = windows.too_short
    return tables


def judge_made(
    methods: Mapping[str, Method],
    name: str,
    touched: Sequence[TouchRow],
    seed: int,
    progress: Progress,
    contrasts: Sequence[tuple[str, str]] = CONTRASTS,
) -> dict[str, Any]:
    """Return the tables of what is made of one folder's recordings: untouched and semi-real."""
    tables = {}
    untouched, slides = UntouchedCases(touched), SemiRealSlides(touched, seed)
    for title, cases, among in (
        (f"real {name}, untouched", untouched, tuple(Motion)),
        (f"semi-real {name}, sliding", slides, SLIDES),
    ):

        def tell(done: int, title: str = title, total: int = len(cases)) -> None:
            progress(title, done, total)

        replies = ask_all(in_question(methods, among), cases, among, tell)
        if len(replies):
            tables[title] = summarise(replies, contrasts, seed=seed)
    if (title := f"semi-real {name}, sliding") in tables:
        tables[title]["cut_off_left_out"] = slides.cut_off
    return tables


def telling(progress: Progress, title: str, total: int) -> Callable[[int], None]:
    """Return what tells `progress` how many clips of one table are done."""
    return lambda done: progress(title, done, max(done, total))
