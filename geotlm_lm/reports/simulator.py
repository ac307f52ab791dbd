"""Run records of the simulator -> tables and the figure of error against run time."""

from __future__ import annotations

from pathlib import Path
from statistics import median
from typing import Any

from geotlm_lm.core.atomic import replacing
from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.markdown import markdown
from geotlm_lm.reports.tables import provenance

MEASURES = {
    "height_um": "height, um RMS",
    "drift_share": "drift, relative L2",
    "image_grey": "image, grey RMS",
}
"""Keys of a row -> what the figure and the table call them."""


READINGS = {"exactly": "", "at least": ">= ", "about": "~ "}
"""How an expected order is to be read -> what the table puts before it."""

OMISSIONS_NOTE = """\
Median over the scenes, range in brackets. Both ways were run in turn, in one thread. Errors are of
leaving it out against doing it, over the whole view; shear that is not given counts as zero, which
is what asking for it would tell apart. `-` is what neither way gives."""

RATES_NOTE = """\
Data sets of pictures, labels and true fields, written to disk by one process per core; the clips
are random ones of the training shapes. Rates count from the first finished shard on, start-up is
apart; what the other process had begun by then counts too, up to 7 % with two of them and eight
shards each. Median over the runs, range in brackets; load is the machine's of the minute before,
which the runs before are part of."""

CLOSED_FORMS_NOTE = """\
The order is minus the slope of log |error| over log size. Rims are staircases of cells: `~` marks
radii, whose error scatters within half a cell, and `>=` forces and moments whose scatter from grid
to grid falls faster than the order, and rules the coarse grids. Thin layers and short increments
come to their order from below, as they are limits themselves. The half-space is taken without the
cross terms that its formulas leave out, and a disc is held against one as large as the cells it
touches. Residuals are the worst of all sizes and steps, in double precision; the record holds more
of them. One solution serves all quantities of a problem."""


def simulator_page(record: RunRecord) -> str:
    """Return error against run time, clips per second, and what omissions save, as one page."""
    parts = {
        "# Simulator: error against run time": error_table,
        "## Clips per second": rate_table,
        "## What each omission saves and costs": omission_table,
    }
    return "\n\n".join(_titled(title, table_of(record)) for title, table_of in parts.items()) + "\n"


def simulator_stability_page(record: RunRecord) -> str:
    """Return what became of stiff and extreme scenes, as one page."""
    return _titled("# Simulator: stiff and extreme scenes", stability_table(record)) + "\n"


def closed_forms_page(record: RunRecord) -> str:
    """Return the errors against closed forms and their orders, as one page."""
    title = "# Simulator: closed forms and orders of convergence"
    return _titled(title, closed_forms_table(record)) + "\n"


def error_table(record: RunRecord) -> str:
    """Return one row per variant: milliseconds, and each error's range over the scenes."""
    rows = []
    for variant, own in _by_variant(record).items():
        times = [median(row["ms"]) for row in own]
        converged = sum(row["is_converged"] for row in own)
        harder = sum(row["preset"] != row["asked"] for row in own)
        rows.append(
            [
                variant,
                f"{median(times):.1f} ({min(times):.1f}-{max(times):.1f})",
                *(_range([row[name] for row in own]) for name in MEASURES),
                f"{converged} of {len(own)}",
                f"{harder} of {len(own)}",
            ]
        )
    header = ["variant", "ms per clip, median (range)", *MEASURES.values()]
    header += ["converged", "escalated"]
    return markdown(header, rows) + "\n\n" + provenance(record)


def omission_table(record: RunRecord) -> str:
    """Return one row per thing left out: what it saves, and what it costs against the full way."""
    found: dict[str, list[dict[str, Any]]] = {}
    for row in record.numbers["omissions"]:
        found.setdefault(f"{row['omission']} ({row['timed']})", []).append(row)
    rows = []
    for name, own in found.items():
        saved = [
            median(full - lean for full, lean in zip(row["full_ms"], row["lean_ms"], strict=True))
            for row in own
        ]
        ratios = [median(row["full_ms"]) / median(row["lean_ms"]) for row in own]
        errors = [_range([row[key] for row in own]) for key in ("height_um", "shear_um")]
        pictures = _range([row["image_grey"] for row in own])
        scenes = "; ".join(row["scene"] for row in own)
        rows.append([name, scenes, _range(saved), _range(ratios), *errors, pictures])
    header = ["left out (of what the time is)", "scenes", "ms per clip saved", "full / lean time"]
    header += ["height, um RMS", "shear, um RMS", "image, grey RMS"]
    return "\n\n".join([markdown(header, rows), OMISSIONS_NOTE, provenance(record)])


def rate_table(record: RunRecord) -> str:
    """Return one row per kind of data set: clips a second, start-up and memory."""
    rows = [
        [
            row["kind"],
            str(row["workers"]),
            f"{len(row['clips_per_second'])} of {row['clips']}",
            _range(row["clips_per_second"]),
            _range(row["start_seconds"]),
            "-" if row["megabytes_per_worker"] is None else f"{row['megabytes_per_worker']:.0f}",
            _range(row["load"]),
        ]
        for row in record.numbers["rates"]
    ]
    header = ["preset", "workers", "runs of clips", "clips per second", "seconds to first shard"]
    header += ["peak MiB of a worker", "load before"]
    return "\n\n".join([markdown(header, rows), RATES_NOTE, provenance(record)])


def stability_table(record: RunRecord) -> str:
    """Return one row per case and precision."""
    rows = []
    for row in record.numbers["rows"]:
        if row["outcome"] == "refused":
            rows.append([row["case"], row["precision"], f"refused: {row['says']}", *("-",) * 5])
            continue
        rows.append(
            [
                row["case"],
                row["precision"],
                row["outcome"],
                f"{row['penetration_um']:.2g}",
                f"{row['gradient_share']:.1g}",
                f"{row['cone_excess']:.1g}",
                f"{row['normal_iterations']} / {row['friction_iterations']}",
                f"{row['milliseconds']:.0f}",
            ]
        )
    header = ["case", "precision", "outcome", "penetration um", "gradient share", "cone excess"]
    header += ["iterations, normal / friction", "ms"]
    return markdown(header, rows) + "\n\n" + provenance(record)


def closed_forms_table(record: RunRecord) -> str:
    """Return one row per quantity with a closed form, then one per law."""
    rows = []
    for row in record.numbers["rows"]:
        worst = row["residuals"]
        rows.append(
            [
                f"{row['problem']}: {row['quantity']}",
                row["source"],
                f"{', '.join(map(str, row['sizes']))} {row['unit']}",
                ", ".join(f"{error:.1e}" for error in row["errors"]),
                f"{row['order']:.2f}",
                f"{READINGS[row['reading']]}{row['expected_order']:g}",
                f"{worst['penetration_um']:.0e} / {worst['gradient_share']:.0e}",
                f"{sum(row['ms']):.0f}",
            ]
        )
    header = ["problem: quantity", "formula", "sizes", "relative error at each", "order"]
    header += ["expected", "residual: penetration um / gradient share", "ms, all sizes"]
    laws = [[name, f"{deviation:.0e}"] for name, deviation in record.numbers["laws"].items()]
    parts = [markdown(header, rows), markdown(["law", "relative deviation"], laws)]
    return "\n\n".join([*parts, CLOSED_FORMS_NOTE, provenance(record)])


def draw_error(record: RunRecord, path: Path) -> None:
    """Draw each error against run time, one panel per measure, both axes logarithmic.

    Args:
        record: From `simulator_error`.
        path: The .png or .svg to write.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12, 4), layout="constrained")
    variants = _by_variant(record)
    for axes, (name, title) in zip(
        figure.subplots(1, len(MEASURES)), MEASURES.items(), strict=True
    ):
        for number, (variant, rows) in enumerate(variants.items()):
            points = [(median(row["ms"]), row[name]) for row in rows if row[name]]
            if points:
                axes.loglog(*zip(*points, strict=True), "o", color=f"C{number}", label=variant)
        axes.set(xlabel="ms per clip of four frames", ylabel=f"error in {title}")
        axes.grid(alpha=0.3)
    axes.legend(fontsize="small", loc="center left", bbox_to_anchor=(1, 0.5))
    with replacing(path) as stream:
        figure.savefig(stream, dpi=120, format=path.suffix.removeprefix("."))


def _by_variant(record: RunRecord) -> dict[str, list[dict[str, Any]]]:
    found: dict[str, list[dict[str, Any]]] = {}
    for row in record.numbers["rows"]:
        found.setdefault(row["variant"], []).append(row)
    return found


def _range(values: list[float | None]) -> str:
    known = [value for value in values if value is not None]
    if not known:
        return "-"
    ends = "-".join(_rounded(end, 2) for end in (min(known), max(known)))
    return f"{_rounded(median(known), 3)} ({ends})"


def _rounded(value: float, digits: int) -> str:
    return f"{value:.0f}" if value >= 100 else f"{value:.{digits}g}"


def _titled(title: str, text: str) -> str:
    return f"{title}\n\n{text}"
