"""Evaluation records as Markdown tables; knows the record's layout, not how it was measured."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from geotlm_lm.core.record import RunRecord

COLUMNS = (
    "method",
    "accuracy",
    "95 % interval",
    "macro by object",
    "lowest recall",
    "no answer",
    "ms, median",
    "ms, p95",
)


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


def evaluation_tables(record: RunRecord) -> str:
    """Return every table of an evaluation, each with its clips and paired differences."""
    parts = []
    for name, table in record.numbers["tables"].items():
        parts += [f"### {name}", "", _facts(table), "", method_table(table), ""]
        parts += [difference_line(one) for one in table["differences"]] + [""]
    return "\n".join(parts).rstrip() + "\n"


def method_table(table: dict[str, Any]) -> str:
    """Return one row per method."""
    rows = []
    for name, scores in table["methods"].items():
        low, high = scores["interval"]
        worst = min(scores["recall"], key=scores["recall"].get)
        rows.append(
            [
                name,
                f"{scores['accuracy']:.3f}",
                f"{low:.3f}-{high:.3f}",
                f"{scores['macro_by_object']:.3f}",
                f"{scores['recall'][worst]:.3f} ({worst})",
                str(scores["verdicts"]["unparsable"]),
                f"{scores['ms_median']:.1f}",
                f"{scores['ms_p95']:.1f}",
            ]
        )
    return markdown(COLUMNS, rows)


def difference_line(difference: dict[str, Any]) -> str:
    """Return one paired difference as a line of text."""
    return (
        f"- {difference['first']} less {difference['second']}: {difference['difference']:+.3f} "
        f"({difference['low']:+.3f} to {difference['high']:+.3f}), p = {difference['p_value']:.3f} "
        f"by object, {difference['mcnemar_p']:.3f} by clip"
    )


def evaluation_page(record: RunRecord) -> str:
    """Return the whole evaluation as a page of its own."""
    intro = """# Answers against truth, method by method

Rows of *all motions* and *words* choose among ten; words are free, any sentence may come, and one
that does not parse counts as wrong. The other rows choose among the motions of the task. Intervals
and p-values are clustered by object; simulated and real clips are never pooled."""
    return f"{intro}\n\n{evaluation_tables(record)}\n{provenance(record)}\n"


def answer_example(record: RunRecord) -> str:
    """Return a question, its answer as people and as programs get it, and the cold start."""
    numbers = record.numbers
    answer = numbers["answer"]
    region = answer["evidence"]["regions"]["upper_minus_lower"]
    kept = {name: answer[name] for name in ("text", "direction", "confidence", "abstained")}
    kept["frame"] = answer["frame"]["sentence"]
    kept["evidence"] = {"upper_minus_lower": region}
    seconds = numbers["cold_s"]
    median = seconds[len(seconds) // 2]
    lines = [
        "```console",
        f"$ {numbers['shown']}",
        answer["text"],
        "```",
        "",
        "With `--json` the last line holds, among others,",
        "",
        "```json",
        json.dumps(kept, indent=1),
        "```",
        "",
        f"A cold answer, interpreter start included, takes {median:.1f} s (median of "
        f"{len(seconds)}, {seconds[0]:.1f}-{seconds[-1]:.1f} s).",
        "",
        provenance(record),
    ]
    return "\n".join(lines)


def training_overview(record: RunRecord) -> str:
    """Return what a training run scored: each task, and each question type."""
    numbers = record.numbers
    tasks = [
        [
            task,
            str(numbers[task]["clips"]),
            *(f"{numbers[task][name]:.3f}" for name in TRAINING_COLUMNS),
        ]
        for task in ("rotation", "sliding")
    ]
    types = [
        [name.removesuffix(" seen"), f"{value:.3f}", f"{numbers['by_type'][held_out]:.3f}"]
        for name, value in numbers["by_type"].items()
        if (held_out := name.replace(" seen", " held_out")) != name
    ]
    modes = ", ".join(
        f"{mode} {value:.3f}" for mode, value in record.config["dgr_validation_accuracy"].items()
    )
    return "\n\n".join(
        [
            markdown(["simulated everyday objects", "clips", *TRAINING_COLUMNS.values()], tasks),
            f"A direction is claimed of {100 * numbers['false_directions']:.1f} % of the clips "
            f"that have none. The probe's mean accuracy on turns and slides of objects kept from "
            f"training, for the two ways to train DGR: {modes}.",
            markdown(["question type", "seen wordings", "held-out wordings"], types),
            provenance(record),
        ]
    )


TRAINING_COLUMNS = {
    "generated": "generated",
    "generated_held_out_wordings": "held-out wordings",
    "probe": "probe on z",
    "global_probe": "probe on c, no DGR",
}
"""Keys of a task's scores -> column titles."""


def provenance(record: RunRecord) -> str:
    """Return the line that says how to get the numbers again."""
    machine = record.machine
    return (
        f"`{record.command}` at commit {record.commit or 'unknown'}, seed {record.seed}, "
        f"{record.seconds / 60:.1f} min on {machine['cores']} cores of {machine['processor']}, "
        f"{record.made_utc[:10]}."
    )


def _facts(table: dict[str, Any]) -> str:
    truths = ", ".join(f"{count} {motion}" for motion, count in table["truths"].items())
    facts = f"{table['clips']} clips of {table['objects']} objects: {truths}"
    if table.get("unreadable_left_out"):
        facts += f"; {table['unreadable_left_out']} left out, their images do not show the motion"
        if "unreadable_right" in table:
            facts += f" (the language model's words name {table['unreadable_right']} of them)"
    if table.get("cut_off_left_out"):
        facts += f"; {table['cut_off_left_out']} imprints left out, faint or cut off by the border"
    if table.get("rows_left_out"):
        left = ", ".join(f"{count} {word}" for word, count in table["rows_left_out"].items())
        facts += f"; labels left out: {left}"
    return facts + "."
