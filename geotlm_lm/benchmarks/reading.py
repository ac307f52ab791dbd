"""Whether questions are understood: exact queries, kinds of asks, and whether doubt is earned."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from itertools import islice

import numpy as np

from geotlm_lm.benchmarks.rendering import right_with_interval
from geotlm_lm.benchmarks.rows import Listing, Pivot, Row, Run, Section
from geotlm_lm.benchmarks.statistics import share_row
from geotlm_lm.query.grammar import Pair, corpus, grammar
from geotlm_lm.query.grammar_linter import VIEWS, cell_of
from geotlm_lm.query.labelled import BLIND, SET_UPS, TUNE, Labelled, labelled
from geotlm_lm.query.text import read
from geotlm_lm.training.calibration import expected_calibration_error

ABOUT = """\
Each question is read into a query by the language model. *Exact* is every word of the query,
numbers included, but for the order of facts; *kind* is what sort of thing is asked. Families of
phrasing, and their clauses, were kept from training; the *blind* questions, and the *set-ups* that
state one to five facts in several sentences, were written by people who had seen no template and no
rule, and nothing was chosen by them; the *tune* questions, written so too, are what readers
were chosen and calibrated by."""

EXACT, KIND = "exact query", "kind of ask"
SURE = 0.8
PAIRS = 2000

SEEN_PAIRS = 40_000
EACH = 20
"""Questions read of each ask from each point of view, at most."""


def reading_rows(run: Run) -> Iterator[Row]:
    """Yield what is understood of every set of questions."""
    for name, questions in _sets(run).items():
        run.progress(f"reading, {name}", 0, 1)
        found = [run.answerer.bundle.reader.read(one.text) for one in questions]
        exact = [q.is_met(r.line) for q, r in zip(questions, found, strict=True)]
        kinds = [q.has_kinds(r.line) for q, r in zip(questions, found, strict=True)]
        families = [str(place) for place in range(len(questions))]
        sure = np.array([one.probability for one in found])
        detail = _doubt(sure, np.array(exact))
        yield share_row(name, EXACT, exact, families, run.seed, detail=detail)
        yield share_row(name, KIND, kinds, families, run.seed)

    yield from _seen_rows(run)


def _seen_rows(run: Run) -> Iterator[Row]:
    """Yield what is read of families that were trained on, by ask and point of view."""
    cells: dict[tuple[str, str], list[Pair]] = defaultdict(list)
    for pair in islice(grammar().pairs(run.seed + 1, "train"), run.size(SEEN_PAIRS, 500)):
        cell = cells[cell_of(read(pair.query).parts)]
        if len(cell) < run.size(EACH, 1):
            cell.append(pair)
    reader = run.answerer.bundle.reader
    for ask in sorted({one for one, _ in cells}):
        run.progress(f"reading, seen families, {ask}", 0, 1)
        for view in VIEWS:
            questions = _of(cells.get((ask, view), ()))
            exact = [one.is_met(reader.read(one.text).line) for one in questions]
            if exact:
                yield Row(ask, view, len(exact), 1 - sum(exact) / len(exact))


def _sets(run: Run) -> dict[str, list[Labelled]]:
    count = run.size(PAIRS, 60)
    pairs = list(islice(grammar().pairs(run.seed, "test"), count))
    return {
        "grammar, families held out": _of(pairs),
        "corpus, families held out": _of(corpus("test")),
        "blind": labelled(BLIND)[: run.size(10_000, 40)],
        "set-ups": labelled(SET_UPS)[: run.size(10_000, 40)],
        "tune": labelled(TUNE)[: run.size(10_000, 40)],
    }


def _of(pairs: Sequence[Pair]) -> list[Labelled]:
    return [Labelled(one.text, (one.query,)) for one in pairs]


def _doubt(sure: np.ndarray, exact: np.ndarray) -> dict[str, float]:
    is_sure = sure >= SURE
    return {
        "mean_stated": float(sure.mean()),
        "calibration_error": expected_calibration_error(sure, exact),
        "sure": float(is_sure.mean()),
        "sure_and_wrong": float((is_sure & ~exact).sum() / max(is_sure.sum(), 1)),
    }


_COLUMNS = {
    "questions": lambda row: row.case,
    "read": lambda row: str(row.count),
    "right": lambda row: f"{1 - row.error:.3f}",
    "mean stated": lambda row: f"{row.detail['mean_stated']:.3f}",
    "calibration error": lambda row: f"{row.detail['calibration_error']:.3f}",
    "read with 0.8 or more": lambda row: f"{row.detail['sure']:.3f}",
    "wrong of these": lambda row: f"{row.detail['sure_and_wrong']:.3f}",
}

READING = Section(
    name="reading",
    title="Understanding",
    about=ABOUT,
    run=reading_rows,
    views={
        "": (Pivot(right_with_interval, "questions"), lambda row: row.variant in (EXACT, KIND)),
        "Families that were trained on, by ask and point of view": (
            Pivot(lambda row: f"{row.right:.2f} ({row.count})", "ask", with_count=False),
            lambda row: row.variant in VIEWS,
        ),
        "Doubt": (Listing(_COLUMNS), lambda row: row.variant == EXACT),
    },
)
