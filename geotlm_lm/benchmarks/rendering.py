"""Records -> pages, pictures and the README's numbers, so that no number is typed by hand.

A block of the README stands between `<!-- begin: BENCH.SECTION -->` and `<!-- end: ... -->`; what
is between is replaced by that section's headline.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from geotlm_lm.benchmarks.harness import QUICK, Bench, Cell, Listing, Pivot, Row, Section, rows_of
from geotlm_lm.core.errors import GeoTLMError
from geotlm_lm.core.files import replacing, write_text_atomically
from geotlm_lm.core.record import RunRecord

RECORDS = "records"
"""Folder of records inside the folder of results."""

_BEGIN = re.compile(r"^<!-- begin: (\S+) -->$", re.MULTILINE)


class StaleResults(GeoTLMError):
    """A page, a picture or the README says something else than its record, or has none."""


def page(bench: Bench, record: RunRecord) -> str:
    """Return a bench as a page: every section with its tables and where they come from."""
    parts = [f"# {bench.title}", bench.about]
    if record.config["size"] == QUICK:
        parts.append("A quick run: it shows that everything runs; its numbers prove nothing.")
    for section in bench.sections:
        rows = rows_of(record, section.name)
        if rows:
            parts += [f"## {section.title}", section.about]
            parts += [section.headline(rows)] if section.headline else []
            parts += tables(section, rows)
            if section.figure:
                parts.append(f"![{section.title}]({bench.name}_{section.name}.png)")
            parts.append(provenance(record, section.name))
    return "\n\n".join(parts) + "\n"


def tables(section: Section, rows: Sequence[Row]) -> list[str]:
    """Return the tables of a section, each under its title where it has one."""
    parts = []
    for title, view in section.views.items():
        shown = [row for row in rows if view.shows(row)]
        if shown:
            parts += [f"### {title}"] * bool(title) + [table(view, shown)]
    return parts


def table(view: Listing | Pivot, rows: Sequence[Row]) -> str:
    """Return rows as one Markdown table."""
    if isinstance(view, Listing):
        lines = [[text(cell, row) for cell in view.columns.values()] for row in rows]
        return markdown(list(view.columns), lines)
    variants = list(dict.fromkeys(row.variant for row in rows))
    by_case: dict[str, dict[str, Row]] = {}
    for row in rows:
        by_case.setdefault(row.case, {})[row.variant] = row
    lines = [
        [case]
        + [str(max(row.count for row in own.values()))] * view.with_count
        + [text(view.cell, own[name]) if name in own else "-" for name in variants]
        for case, own in by_case.items()
    ]
    return markdown([view.corner] + ["n"] * view.with_count + variants, lines)


def text(cell: Cell, row: Row) -> str:
    """Return the text of a row's cell."""
    if callable(cell):
        return cell(row)
    name, _, form = cell.partition(":")
    value = row.detail[name] if name in row.detail else getattr(row, name, None)
    return "-" if value is None else format(value, form)


def markdown(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table padded so that it reads as plain text too.

    The first column is set left, all others right.
    """
    cells = [list(header), *(list(row) for row in rows)]
    # A rule cell needs a dash beside its colon.
    widths = [max(2, *(len(line[column]) for line in cells)) for column in range(len(header))]

    def line(values: Sequence[str]) -> str:
        first = values[0].ljust(widths[0])
        others = [value.rjust(width) for value, width in zip(values[1:], widths[1:], strict=True)]
        return "| " + " | ".join([first, *others]) + " |"

    rule = "| " + " | ".join(["-" * widths[0], *("-" * (w - 1) + ":" for w in widths[1:])]) + " |"
    return "\n".join([line(cells[0]), rule, *(line(row) for row in cells[1:])])


def provenance(record: RunRecord, section: str) -> str:
    """Return the line that says how to get a section's numbers again."""
    done = record.numbers["sections"][section]
    return (
        f"`{done['command']}`: {done['seconds'] / 60:.1f} min at commit "
        f"{done['commit'] or 'unknown'}, seed {record.seed}, one thread of {done['processor']}, "
        f"{done['date']}."
    )


def right_with_interval(row: Row) -> str:
    """Return the share of right answers and its 95 % interval."""
    if row.right is None or row.interval is None:
        return "-"
    low, high = 1 - row.interval[1], 1 - row.interval[0]
    return f"{row.right:.3f} ({low:.3f}-{high:.3f})"


def save_results(bench: Bench, record: RunRecord, folder: Path) -> None:
    """Write a record, its page and its pictures below `folder`."""
    record.save(folder / RECORDS / f"{bench.name}.json")
    write_text_atomically(folder / f"{bench.name}.md", page(bench, record))
    redraw_figures([bench], folder)


def save_figure(figure: Any, rows: Sequence[Row], path: Path) -> None:
    """Write a matplotlib figure as PNG that tells which rows it shows, for `check_results`."""
    with replacing(path) as stream:
        figure.savefig(stream, dpi=120, format="png", metadata={"Description": _digest(rows)})


def _digest(rows: Sequence[Row]) -> str:
    text = json.dumps([row.to_dict() for row in rows], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def render_results(benches: Sequence[Bench], folder: Path, readme: Path) -> list[Path]:
    """Write the pages and the README's blocks from the records; return the files that changed.

    Raises:
        StaleResults: If a block is unknown or not closed, or its record is missing.
    """
    wanted = _wanted(benches, folder, readme)
    changed = [path for path, text in wanted.items() if _read(path) != text]
    for path in changed:
        write_text_atomically(path, wanted[path])
    return changed


def check_results(benches: Sequence[Bench], folder: Path, readme: Path) -> None:
    """Compare pages, pictures and the README's blocks with the records.

    Raises:
        StaleResults: If any of them says something else than its record.
    """
    for path, text in _wanted(benches, folder, readme).items():
        if _read(path) != text:
            raise StaleResults(
                f"{path}: its numbers differ from the records in {folder / RECORDS}; run "
                f"`geotlm-lm bench render`."
            )
    for _, rows, path in _figures(benches, folder):
        if not (path.exists() and _shows(path, rows)):
            raise StaleResults(
                f"{path}: is missing or shows other numbers than its record; run "
                f"`geotlm-lm bench render --figures`."
            )


def redraw_figures(benches: Sequence[Bench], folder: Path) -> None:
    """Draw every picture anew from the records; needs matplotlib."""
    for section, rows, path in _figures(benches, folder):
        section.figure(rows, path)


def _figures(benches: Sequence[Bench], folder: Path) -> Iterator[tuple[Section, list[Row], Path]]:
    """Yield each section with a picture, the recorded rows that shows, and where it lies."""
    for bench in benches:
        record = _record(folder, bench.name)
        for section in bench.sections if record else ():
            rows = rows_of(record, section.name)
            if section.figure is not None and rows:
                yield section, rows, folder / f"{bench.name}_{section.name}.png"


def _wanted(benches: Sequence[Bench], folder: Path, readme: Path) -> dict[Path, str]:
    """Return the text of every page and of the README by its path."""
    wanted, headlines = {}, {}
    for bench in benches:
        record = _record(folder, bench.name)
        if record is not None:
            wanted[folder / f"{bench.name}.md"] = page(bench, record)
        for section in bench.sections:
            if section.headline is not None:
                headlines[f"{bench.name}.{section.name}"] = record, section
    text = _read(readme)
    if text is None:
        raise StaleResults(f"{readme}: cannot be read; run from the checkout or give --readme.")
    parts, position = [], 0
    for begin in _BEGIN.finditer(text):
        name, closing = begin[1], f"<!-- end: {begin[1]} -->"
        end = text.find(closing, begin.end())
        if end < 0:
            raise StaleResults(f"block '{name}' is not closed; add the line {closing} below it.")
        if name not in headlines:
            raise StaleResults(
                f"block '{name}' is not known; expected one of {', '.join(headlines)}."
            )
        block = _block(name, *headlines[name])
        parts += [text[position : begin.end()], "\n\n", block, "\n\n"]
        position = end
    return wanted | {readme: "".join([*parts, text[position:]])}


def _block(name: str, record: RunRecord | None, section: Section) -> str:
    rows = [] if record is None else rows_of(record, section.name)
    if not rows:
        raise StaleResults(
            f"block '{name}' has no record; write it with `geotlm-lm bench {name.split('.')[0]} "
            f"--out docs/results`."
        )
    return f"{section.headline(rows)}\n\n{provenance(record, section.name)}"


def _shows(path: Path, rows: Sequence[Row]) -> bool:
    from PIL import Image

    with Image.open(path) as picture:
        return picture.info.get("Description") == _digest(rows)


def _record(folder: Path, name: str) -> RunRecord | None:
    path = folder / RECORDS / f"{name}.json"
    return RunRecord.load(path) if path.exists() else None


def _read(path: Path) -> str | None:
    return path.read_text(encoding="utf-8") if path.exists() else None
