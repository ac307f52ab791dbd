"""The record of real and simulated images -> tables; knows its layout, not how it was measured."""

from __future__ import annotations

from typing import Any

from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.markdown import markdown
from geotlm_lm.reports.tables import provenance

HEADER = ("unit", "real, median (spread)", "simulated, median (spread)", "simulated median is",
          "simulated inside", "real covered")  # fmt: skip

READING = """\
Statistics of images brought to 224 x 224 pixels, the same code for real and simulated ones. A
spread runs from the {low:.0f}th to the {high:.0f}th percentile over recordings, or over touched
frames where a contact is measured; each real source weighs the same. *simulated inside*: share of
simulated clips inside the real spread; *real covered*: share of real ones inside the simulated one.

- The real videos are lossy (MPEG-4): between two frames stored whole their noise stands still, so
  their noise between frames is the codec's, not the camera's. It is held against that of the
  simulated clips that come out of a video too, frame after frame; the simulated camera's own noise
  has no real counterpart here. Only the fine residual beside the contact is also measured on
  stills.
- Where the object touches is found from what changed, real and simulated alike. Shapes and depths
  differ between the two, so that a contact's strength and sharpness are the object's as well; the
  balls at the end are the same bodies on both sides, pressed to depths nobody measured.
- A median can be inside although many real values are not covered: read the last column as well.
- The mean of a contact and the direction of each light are measured on imprints wholly in view,
  where shading cancels in the mean and the depth term is left, less what steep flanks lose."""

BALLS = """\
Smooth balls of {sizes} mm diameter. The cap is the part of the ball below the plane of the
touched region, known from the region's area: the real pixel size is the sensor's nominal one."""


def optics_report(record: RunRecord) -> str:
    """Return everything the record says, as Markdown."""
    low, high = (100 * quantile for quantile in record.config["spread"])
    parts = [
        "# Simulator: its images beside real ones",
        verdict(record),
        READING.format(low=low, high=high),
    ]
    for group in dict.fromkeys(row["group"] for row in record.numbers["rows"]):
        rows = [row for row in record.numbers["rows"] if row["group"] == group]
        parts += [f"## {group.capitalize()}", comparison_table(rows, group)]
    if record.numbers["balls"]:
        sizes = " and ".join(f"{size:g}" for size in record.config["balls_mm"])
        table = comparison_table(record.numbers["balls"], "contact of balls")
        parts += ["## Balls", BALLS.format(sizes=sizes), table]
    parts += ["## Real medians by source", source_table(record), provenance(record)]
    return "\n\n".join(parts) + "\n"


def verdict(record: RunRecord) -> str:
    """Return how many simulated medians are inside the real spread, and which are outside."""
    parts = [_held("simulated", record.numbers["rows"])]
    if record.numbers["balls"]:
        parts.append(_held("simulated balls'", record.numbers["balls"]))
    return " ".join(parts)


def _held(whose: str, rows: list[dict[str, Any]]) -> str:
    both = [row for row in rows if "outside" in row]
    outside = [row["title"] for row in both if row["outside"]]
    missing = [row["title"] for row in rows if "outside" not in row]
    text = f"{len(both) - len(outside)} of {len(both)} {whose} medians lie inside the real spread"
    if outside:
        text += f"; outside: {_listed(outside)}"
    return text + "." + (f" Not measured on both sides: {_listed(missing)}." if missing else "")


def comparison_table(rows: list[dict[str, Any]], name: str) -> str:
    """Return one line per row, under the name of what they are of."""
    lines = [
        [
            row["title"],
            row["unit"],
            _spread(row["real"]),
            _spread(row["simulated"]),
            _side(row),
            _share(row.get("share_inside")),
            _share(row.get("share_covered")),
        ]
        for row in rows
    ]
    return markdown([name, *HEADER], lines)


def source_table(record: RunRecord) -> str:
    """Return the median of every statistic in each real source, and what each source holds."""
    touches = record.numbers["touches"]
    rows = record.numbers["rows"]
    sources = sorted({name for row in rows for name in row["sources"]})
    counts = [
        [what, *(str(touches[name][key]) for name in sources)]
        for what, key in (
            ("recordings", "recordings"),
            ("touched frames", "touches"),
            ("of these too faint or small to measure", "faint"),
        )
    ]
    medians = [
        [row["title"], *(_median(row["sources"].get(name)) for name in sources)] for row in rows
    ]
    return markdown(["median", *sources], counts + medians)


def _listed(titles: list[str]) -> str:
    """Return titles in one line, the colours of one statistic put together."""
    colours: dict[str, list[str]] = {}
    for title in titles:
        what, comma, colour = title.rpartition(", ")
        is_colour = comma and len(colour) == 1
        colours.setdefault(what if is_colour else title, []).extend([colour] * bool(is_colour))
    return "; ".join(f"{what} ({', '.join(c)})" if c else what for what, c in colours.items())


def _side(row: dict[str, Any]) -> str:
    if "outside" not in row:
        return "not measured"
    if row["outside"] == 0:
        return "inside"
    return f"{_number(abs(row['outside']))} {'above' if row['outside'] > 0 else 'below'}"


def _spread(summary: dict[str, Any] | None) -> str:
    if summary is None:
        return "-"
    low, high = (_number(summary[end]) for end in ("low", "high"))
    return f"{_number(summary['median'])} ({low} to {high})"


def _median(summary: dict[str, Any] | None) -> str:
    return "-" if summary is None else _number(summary["median"])


def _share(share: float | None) -> str:
    return "-" if share is None else f"{100 * share:.0f} %"


def _number(value: float) -> str:
    return f"{value:.2f}" if abs(value) < 9.995 else f"{value:.1f}"
