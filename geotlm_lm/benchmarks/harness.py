"""What every benchmark is made of, and how it is run: `Variant x Case -> Row`. Knows no model.

A bench has sections; a section gives rows and says how they are shown.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property, partial
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
    """What one variant (a method, a model, a preset) made of one case (a set of clips, a scene).

    `error` is the share of wrong answers, or a distance in `unit` ("deg", "um"), None where nothing
    is graded; `interval` its 95 % interval, objects resampled as wholes. `outcome` is the result in
    words where numbers do not say it, `detail` what else the section shows, as plain JSON values.
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
    """File of a released encoder, its adapter (None: told by the file) and its attention heads."""

    weights: Path
    name: str | None = None
    heads: int | None = None


@dataclass(frozen=True)
class Run:
    """How a bench is run, and what it is run on."""

    seed: int = 0
    clips: int | None = None  # simulated, of each task; None for a section's own number
    is_quick: bool = False  # in under two minutes everything is seen to run; proves nothing
    real: Path | None = None  # folder of labelled recordings
    data: Sequence[Path] = ()
    model: Path | None = None  # a bundle's folder; None for the one that ships
    encoder: EncoderFile | None = None  # whose tokens the protocols take; None: the embedded one's
    folder: Path = Path("runs/bench")  # keeps what a stopped run need not do again
    progress: Progress = silent
    answerer_given: Answerer | None = None  # loaded already
    workers: Workers = ALONE  # no number but times depends on them

    @cached_property
    def answerer(self) -> Answerer:
        """The model, loaded once and only if a section asks for it."""
        if self.answerer_given is not None:
            return self.answerer_given
        from geotlm_lm.answering.answerer import loaded

        return loaded(self.model)

    def size(self, whole: Size, quick: Size) -> Size:
        """Return how much of something is done: `whole`, or `quick` of a quick run."""
        return quick if self.is_quick else whole


def every(row: Row) -> bool:
    """Show all rows of a section in one table."""
    return True


Cell = str | Callable[[Row], str]
"""Text of a row's cell: a function, or the name of a field or of a number of the detail, with a
format behind a colon; "-" where there is none."""


@dataclass(frozen=True)
class Listing:
    """One line per row; `columns` gives the cells by the column's title."""

    columns: Mapping[str, Cell]
    shows: Callable[[Row], object] = every


@dataclass(frozen=True)
class Pivot:
    """One line per case and one column per variant, in order of appearance."""

    cell: Cell
    corner: str = "clips"  # title of the column of cases
    with_count: bool = True
    shows: Callable[[Row], object] = every


@dataclass(frozen=True)
class Section:
    """One part of a bench; `about` says in Markdown what is measured and how to read it.

    `shares` gives the rows in independent shares by name: workers take one each, and a stopped run
    keeps them. `views` are tables by their titles. `headline` is Markdown for the page and the
    README.
    """

    name: str
    title: str
    about: str
    shares: Callable[[Run], Mapping[str, Share]]
    views: Mapping[str, Listing | Pivot]
    figure: Callable[[Sequence[Row], Path], None] | None = None
    headline: Callable[[Sequence[Row]], str] | None = None

    def run(self, run: Run) -> Iterator[Row]:
        """Yield the rows of all shares."""
        for share in self.shares(run).values():
            yield from share()


def whole(rows: Callable[[Run], Iterable[Row]]) -> Callable[[Run], Mapping[str, Share]]:
    """Return the shares of a section whose rows are one share."""
    return lambda run: {"": partial(rows, run)}


@dataclass(frozen=True)
class Bench:
    """One table of the benchmarks, with what it answers in Markdown, and its sections in order."""

    name: str
    title: str
    about: str
    sections: tuple[Section, ...]

    def section(self, name: str) -> Section:
        """Return a section by name."""
        return next(section for section in self.sections if section.name == name)


def rows_of(record: RunRecord, section: str) -> list[Row]:
    """Return the rows of a recorded section; none where it was not run."""
    recorded = record.numbers["sections"].get(section, {"rows": []})
    return [Row.from_dict(row) for row in recorded["rows"]]
