"""What a table rests on, in words: its clips, what was left out of it, the thresholds behind it."""

from __future__ import annotations

import re
from typing import Any

from geotlm_lm.reports.markdown import markdown

SHARE_OF_A_TABLE = re.compile(r", (pairs, .*|\d+ fps|forwards|backwards|sensor .*)$")
"""Titles of tables that are parts of another one."""


def facts(table: dict[str, Any]) -> str:
    """Return the clips of a table by motion, and how many were left out why."""
    truths = ", ".join(f"{count} {motion}" for motion, count in table["truths"].items())
    told = f"{table['clips']} clips of {table['objects']} objects: {truths}"
    if table.get("unreadable_left_out"):
        told += f"; {table['unreadable_left_out']} left out, their images do not show the motion"
        if "unreadable_right" in table:
            told += f" (the language model's words name {table['unreadable_right']} of them)"
    if table.get("cut_off_left_out"):
        told += f"; {table['cut_off_left_out']} imprints left out, faint or cut off by the border"
    if table.get("too_short_left_out"):
        told += f"; {table['too_short_left_out']} recordings left out, shorter than a window"
    if table.get("rows_left_out"):
        left = ", ".join(f"{count} {word}" for word, count in table["rows_left_out"].items())
        told += f"; labels left out: {left}"
    return told + "." + _rule(table.get("pairs"))


def object_table(by_object: dict[str, dict[str, Any]]) -> str:
    """Return one row per object: its clips and what share of them each method got right."""
    methods = list(next(iter(by_object.values())))[1:]
    rows = [
        [name, str(own["clips"]), *(f"{own[method]:.3f}" for method in methods)]
        for name, own in by_object.items()
    ]
    return markdown(["object", "clips", *methods], rows)


def data_set_facts(name: str, about: dict[str, Any]) -> str:
    """Return what is to be known of a data set: files left out, backgrounds, swept thresholds."""
    left_out, parts = about["left_out"], [f"### {name}: files and thresholds"]
    told = f"{left_out['count']} trials or clips left out because their files cannot be used."
    parts.append(" ".join([told, *left_out["first"][:1]]))
    backgrounds = "; ".join(f"{what}: {_value(one)}" for what, one in about["backgrounds"].items())
    if backgrounds:
        parts.append(f"Backgrounds: {backgrounds}.")
    for task, rows in about["sweeps"].items():
        unit = "degrees" if task == "rotation" else "pixels"
        parts.append(f"Pairs of frames that count as {task}, by gap and least {unit}:")
        parts.append(_sweep_table(rows))
    return "\n\n".join(parts)


def _rule(pairs: dict[str, Any] | None) -> str:
    if pairs is None:
        return ""
    rule, share = pairs["rule"], pairs["paper_share"]
    return (
        f" Pairs {rule['gap_frames']} frames apart; a rotation turns by {rule['least_turn_deg']:g} "
        f"degrees or more and travels at most {rule['most_aside_px']:g} px, a slide travels "
        f"{rule['least_slide_px']:g} px or more, {rule['least_purity']:g} of it along its axis, "
        f"and turns by at most {rule['most_aside_deg']:g} degrees; at most "
        f"{rule['most_tilt_deg']:g} degrees of tilt and {rule['most_lift_mm']:g} mm of lift, at "
        f"least {rule['least_contact_px']} px of contact. {pairs['found']} pairs are such; the "
        f"paper, which gives no threshold, has {pairs['paper']} in all trials, of which "
        f"{share:.0%} are here."
    )


def _sweep_table(rows: list[dict[str, Any]]) -> str:
    least = list(dict.fromkeys(row["least"] for row in rows))
    counts = {(row["gap_frames"], row["least"]): row["pairs"] for row in rows}
    gaps = list(dict.fromkeys(row["gap_frames"] for row in rows))
    lines = [[f"{gap} frames", *(str(counts[gap, one]) for one in least)] for gap in gaps]
    return markdown(["gap", *(f"{one:g}" for one in least)], lines)


def _value(value: float) -> str:
    return f"{value:.1%}" if isinstance(value, float) else str(value)
