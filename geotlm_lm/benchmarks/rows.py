"""What every benchmark is made of: a bench has sections, a section gives rows, a row is a number.

A row is what one variant made of one case: `Variant x Case -> Row`. Knows no model.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from geotlm_lm.core.process import Progress, silent
from geotlm_lm.core.record import RunRecord
from geotlm_lm.runs.run import ALONE, Workers

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer

Size = TypeVar("Size")

Share = Callable[[], Iterable["Row"]]
"""Gives some of a section's rows."""

WHOLE, QUICK = "whole", "quick"


@dataclass(frozen=True)
class Row:
    """What one variant made of one case.

    Args:
        case: What was asked about: a set of clips, a scene, a file.
        variant: What was asked: a method, a model, a preset, a number format.
        count: How many clips, questions or runs the numbers are of.
        error: Share of wrong answers, or a distance in `unit`; None where nothing is graded.
        unit: Of the error: "share", "deg", "px", "um", ...
        interval: 95 % interval of the error, clips of one object resampled together.
        ms_p50: Median wall time, milliseconds; None where nothing is timed.
        ms_p95: 95th percentile.
        memory_mib: Peak memory of the process.
        outcome: What became of it, in a word or a sentence; "" where the numbers say it.
        detail: Further numbers that this section shows, plain JSON values.
    """

    case: str
    variant: str
    count: int = 1
    error: float | None = None
    unit: str = "share"
    interval: tuple[float, float] | None = None
    ms_p50: float | None = None
    ms_p95: float | None = None
    memory_mib: float | None = None
    outcome: str = ""
    detail: Mapping[str, Any] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Return the fields that say something, as plain JSON values."""
        empty = (None, "", {})
        return {name: value for name, value in asdict(self).items() if value not in empty}

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Row:
        """Read what `to_dict` gave."""
        row = dict(values)
        if "interval" in row:
            row["interval"] = tuple(row["interval"])
        return cls(**row)

    @property
    def right(self) -> float | None:
        """Share of right answers; None where no share is graded."""
        return None if self.error is None or self.unit != "share" else 1 - self.error


@dataclass(frozen=True)
class EncoderFile:
    """A released encoder that takes the place of the embedded backbone.

    Args:
        weights: The file its authors release.
        name: Of its adapter; None to tell it by the file.
        heads: Attention heads, where the file does not tell.
    """

    weights: Path
    name: str | None = None
    heads: int | None = None


@dataclass(frozen=True)
class Run:
    """How a bench is run, and what it is run on.

    Args:
        seed: Root of clips, questions and resampling.
        clips: Simulated clips of each task where a section judges motions; None for its own number.
        is_quick: Whether to see in under two minutes that everything runs; proves nothing.
        real: Folder of labelled recordings; None leaves them out.
        data: Public data sets judged in addition.
        model: A bundle's folder; None for the one that ships.
        encoder: Whose tokens the paper's protocols are run on; None for the embedded backbone.
        folder: Keeps what a stopped run need not do again.
        progress: Told how far the run is.
        answerer_given: A model that is loaded already.
        workers: Who runs sections and shares of them; numbers but times do not depend on it.
    """

    seed: int = 0
    clips: int | None = None
    is_quick: bool = False
    real: Path | None = None
    data: Sequence[Path] = ()
    model: Path | None = None
    encoder: EncoderFile | None = None
    folder: Path = Path("runs/bench")
    progress: Progress = silent
    answerer_given: Answerer | None = None
    workers: Workers = ALONE

    @cached_property
    def answerer(self) -> Answerer:
        """The model, loaded once and only if a section asks for it."""
        if self.answerer_given is not None:
            return self.answerer_given
        from geotlm_lm.answering.loaded import loaded

        return loaded(self.model, "float32")

    def size(self, whole: Size, quick: Size) -> Size:
        """Return how much of something is done: `whole`, or `quick` of a quick run."""
        return quick if self.is_quick else whole


@dataclass(frozen=True)
class Listing:
    """One line per row.

    Args:
        columns: Title -> the text of a row's cell.
    """

    columns: Mapping[str, Callable[[Row], str]]


@dataclass(frozen=True)
class Pivot:
    """One line per case and one column per variant, in order of appearance.

    Args:
        cell: The text of a row's cell.
        corner: Title of the column of cases.
        with_count: Whether a column says how many clips a case has.
    """

    cell: Callable[[Row], str]
    corner: str = "clips"
    with_count: bool = True


@dataclass(frozen=True)
class Section:
    """One part of a bench.

    Args:
        name: For the command line and the record.
        title: For people.
        about: What is measured and how to read it, Markdown.
        run: Gives the rows.
        shares: Gives the same rows, in order, in shares by name that know nothing of each other:
            workers take one each, and a stopped run keeps them. None where all is one share.
        views: How they are shown, one table each; title -> (view, which rows it shows).
        figure: Draws the rows into a file, where a picture shows more than a table.
        headline: Tells the rows in a few lines of Markdown, for the page and the README.
        needs_real: Whether it is left out without recordings.
    """

    name: str
    title: str
    about: str
    run: Callable[[Run], Iterable[Row]]
    views: Mapping[str, tuple[Listing | Pivot, Callable[[Row], bool]]]
    figure: Callable[[Sequence[Row], Path], None] | None = None
    headline: Callable[[Sequence[Row]], str] | None = None
    needs_real: bool = False
    shares: Callable[[Run], Mapping[str, Share]] | None = None


@dataclass(frozen=True)
class Bench:
    """One table of the benchmarks.

    Args:
        name: accuracy, pareto, stability or omissions.
        title: For people.
        about: What it answers, Markdown.
        sections: Its parts, in order.
    """

    name: str
    title: str
    about: str
    sections: tuple[Section, ...]

    def section(self, name: str) -> Section:
        """Return a section by name.

        Raises:
            KeyError: If there is none.
        """
        return next(one for one in self.sections if one.name == name)


def every(row: Row) -> bool:
    """Show all rows of a section in one table."""
    return True


def rows_of(record: RunRecord, section: str) -> list[Row]:
    """Return the rows of a recorded section; none where it was not run."""
    found = record.numbers["sections"].get(section, {"rows": []})
    return [Row.from_dict(row) for row in found["rows"]]
