"""The record of the model's stability -> one table of outcomes, its numerics, and a figure."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from geotlm_lm.core.atomic import replacing
from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.tables import markdown, provenance

TITLE = "# The model under stress"

INTRO = """\
Every clip is asked for its motion. A row counts what became of that: right, wrong, abstained,
refused in a sentence, or crashed; `false direction` is how many of the wrong ones name a turn or a
slide, the others overlook one, as where a contact is too faint to see. `sure` is the mean
probability of the answers given, `wrong at` the highest of a wrong one. What is quoted is the
gravest case of the row: a crash before a wrong answer before a refusal. Damage rows ask about
simulated objects kept from training, all ten motions; where nothing can be told (a black image)
only an abstention or a refusal is right. A fifth of training's clips were damaged as well: by JPEG,
a dim or drifting camera, or a fainter touch."""

FLOOR_NOTE = """\
A unit field, pooled as the model pools it (float32). As written, Eq. 5 shrinks it under a faint
mask and gives 0 where there is none; the exposed mass tells which, and undoes the floor (`with the
mass`: times 1 + floor / summed mask). A half without contact makes a differenced region read as
large as a turn would: its own mass, that of the lighter half, is 0 and says so."""

GRADIENT_NOTE = """\
Norms of the gradient of the descriptor's sum, in float64. By the mask itself it grows as 1 / mask
down to the floor; by what the mask is the sigmoid of, which is what training changes, it stays
bounded and vanishes with the contact. `agrees` is the whole of DGR against central differences."""

PRECISION_NOTE = """\
Against the same parts in float64. The descriptor's error is the largest over clips and numbers, in
parts of the largest number. `geometry` is standardisation, DGR and probes alone."""

SCALE_NOTE = """\
Every token multiplied. With statistics that are scaled along nothing may change; with those of the
bundle the geometry saturates, as it must: the length of a token carries how far its patch moved."""

NAMED_ROWS = 12
"""Rows that the summary names at most."""


def stability_page(record: RunRecord) -> str:
    """Return the whole report as a page."""
    numbers = record.numbers
    parts = [
        TITLE,
        INTRO,
        summary(record),
        outcome_table(record),
        "## Mass floor of the regional means",
        _floor_table(numbers["mass_floor"]),
        FLOOR_NOTE,
        "## Gradients as contact vanishes",
        _gradient_table(numbers["gradients"]),
        GRADIENT_NOTE,
        "## Number formats",
        _precision_table(numbers["precision"]),
        PRECISION_NOTE,
        "## Feature scales",
        _scale_table(numbers["scales"]),
        SCALE_NOTE,
        provenance(record),
    ]
    return "\n\n".join(parts) + "\n"


def summary(record: RunRecord) -> str:
    """Return what fails, by name: crashes, and answers that are wrong at 0.9 or more."""
    rows = record.numbers["rows"]
    crashed = [_name(row) for row in rows if row["crashed"]]
    lines = [
        f"- crashed: {', '.join(crashed) or 'none'} of {len(rows)} rows",
        f"- a wrong direction at 0.9 or more: {_named(rows, 'confident_false_directions')}",
        f"- a touch or motion overlooked at 0.9 or more: {_named(rows, 'confident_oversights')}",
        f"- slowest answer: {max(row['slowest_s'] for row in rows):.1f} s",
        f"- {_falls_together(rows)}",
    ]
    return "\n".join(lines)


def _named(rows: list[dict[str, Any]], count: str) -> str:
    """Return the rows with most of what `count` counts, and how many of their clips that is."""
    found = [row for row in rows if row[count]]
    found.sort(key=lambda row: -row[count] / row["clips"])
    named = ", ".join(f"{_name(row)} {row[count]}/{row['clips']}" for row in found[:NAMED_ROWS])
    more = f", and {len(found) - NAMED_ROWS} rows more" if len(found) > NAMED_ROWS else ""
    return (named or "none") + more


def outcome_table(record: RunRecord) -> str:
    """Return one row per case: what became of its clips, how surely, and the gravest words."""
    rows = []
    for row in record.numbers["rows"]:
        rows.append(
            [
                _name(row),
                str(row["clips"]),
                *(_count(row[name]) for name in _OUTCOMES),
                _count(row["false_directions"]),
                _share(row["accuracy_of_answers"]),
                _share(row["confidence"]),
                _share(row["confidence_wrong"]),
                _plain(row["says"]) + (f" [{row['solver']}]" if "solver" in row else ""),
            ]
        )
    header = ["case", "clips", *_OUTCOMES, "false direction", "right of answers", "sure"]
    return markdown([*header, "wrong at", "gravest case"], rows)


_OUTCOMES = ("right", "wrong", "abstained", "refused", "crashed")


def draw_fall(record: RunRecord, path: Path) -> None:
    """Draw, for each kind of damage, accuracy and confidence over its levels.

    Args:
        record: From `model_stability`.
        path: The .png or .svg to write.
    """
    from matplotlib.figure import Figure

    kinds: dict[str, list[dict[str, Any]]] = {}
    for row in record.numbers["rows"]:
        if row["group"] == "damage":
            kinds.setdefault(row["case"], []).append(row)
    kinds = {name: rows for name, rows in kinds.items() if len(rows) > 1}
    columns = min(4, max(1, len(kinds)))
    lines = -(-len(kinds) // columns) or 1
    figure = Figure(figsize=(3.2 * columns, 2.4 * lines), layout="constrained")
    panels = figure.subplots(lines, columns, squeeze=False).flat
    for (name, rows), axes in zip(kinds.items(), panels, strict=False):
        levels = [row["level"] for row in rows]
        for key, title, mark in _CURVES:
            values = [_drawn(row, key) for row in rows]
            axes.plot(levels, values, mark, label=title)
        axes.set(title=name, xlabel=rows[0]["unit"], ylim=(-0.05, 1.05))
        axes.tick_params(axis="x", labelsize="small")
        axes.grid(alpha=0.3)
    for axes in list(panels):
        axes.set_axis_off()
    handles, titles = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, titles, loc="outside lower center", ncols=len(titles))
    with replacing(path) as stream:
        figure.savefig(stream, dpi=120, format=path.suffix.removeprefix("."))


_CURVES = (
    ("accuracy_of_answers", "right, of answers", "o-"),
    ("confidence", "mean probability", "s--"),
    ("unanswered", "refused or abstained", "x:"),
)


def _drawn(row: dict[str, Any], key: str) -> float:
    if key == "unanswered":
        return (row["refused"] + row["abstained"]) / row["clips"]
    return float("nan") if row[key] is None else row[key]


def _falls_together(rows: list[dict[str, Any]]) -> str:
    """Return how far accuracy and stated probability are apart where answers were given."""
    gaps = [
        (row["confidence"] - row["accuracy_of_answers"], _name(row))
        for row in rows
        if row["group"] == "damage" and row["accuracy_of_answers"] is not None
    ]
    if not gaps:
        return "no damaged clip was answered"
    mean = sum(gap for gap, _ in gaps) / len(gaps)
    worst, name = max(gaps)
    return (
        f"mean probability less share right, over the levels of damage: {mean:+.2f} on average, "
        f"{worst:+.2f} at worst ({name})"
    )


def _floor_table(rows: list[dict[str, Any]]) -> str:
    cells = [
        [
            f"{row['mask']:.0e}, {row['contact']}",
            f"{row['global']:.4f}",
            f"{row['mass']:.1e}",
            f"{row['recovered']:.4f}",
            f"{row['upper_minus_lower']:+.4f}",
            f"{row['mass_upper_minus_lower']:.1e}",
        ]
        for row in rows
    ]
    header = ["mask, where", "global, as written", "its mass", "with the mass"]
    return markdown([*header, "upper minus lower", "its mass"], cells)


def _gradient_table(rows: list[dict[str, Any]]) -> str:
    norms = ("by_field", "by_mask", "by_logit")
    cells = [
        [
            f"{row['mask']:.0e}",
            *(f"{row[name]:.1e}" for name in norms),
            "yes" if row["checked"] else "no",
        ]
        for row in rows
    ]
    return markdown(["mask", "by the field", "by the mask", "by its logit", "agrees"], cells)


def _precision_table(rows: list[dict[str, Any]]) -> str:
    cells = [
        [
            f"{row['precision']}: {row['parts']}",
            f"{row['descriptor_error']:.0e}",
            "yes" if row["is_finite"] else "no",
            f"{row['answers_changed']} of {row['clips']}",
            f"{row['confidence_change']:.1e}",
            f"{row['right']} of {row['clips']}",
        ]
        for row in rows
    ]
    header = ["format: of what", "descriptor error", "finite", "answers changed"]
    return markdown([*header, "largest change of probability", "right"], cells)


def _scale_table(rows: list[dict[str, Any]]) -> str:
    cells = [
        [
            f"{row['factor']:g}, statistics {row['statistics']}",
            f"{row['right']} of {row['clips']}",
            str(row["abstained"]),
            _share(row["confidence"]),
        ]
        for row in rows
    ]
    return markdown(["tokens times", "right", "abstained", "sure"], cells)


def _name(row: dict[str, Any]) -> str:
    level = "" if row["level"] == "-" else f", {row['level']} {row['unit']}".rstrip()
    prefix = "stiff scene: " if row["group"] == "stiff scene" else ""
    return f"{prefix}{row['case']}{level}"


def _count(value: int) -> str:
    return str(value) if value else "-"


def _share(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"


def _plain(text: str) -> str:
    return " ".join(text.replace("|", "/").split())
