"""Evaluation records as Markdown tables; knows the record's layout, not how it was measured."""

from __future__ import annotations

import json
from typing import Any

from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.confusions import confusion_pictures
from geotlm_lm.reports.facts import data_set_facts, facts, object_table
from geotlm_lm.reports.markdown import markdown

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

CONFUSIONS = """## Who is taken for whom

A row is a truth, a column an answer, a number the clips; blue is right, orange is wrong, and the
stronger the colour, the larger the share of the row."""

NO_ANSWER = COLUMNS.index("no answer")

CLAIMED = "direction claimed where none is"


def evaluation_tables(record: RunRecord) -> str:
    """Return every table of an evaluation, each with its clips and paired differences."""
    parts = []
    for name, table in record.numbers["tables"].items():
        parts += [f"### {name}", "", facts(table), "", method_table(table), ""]
        parts += [difference_line(one) for one in table["differences"]] + [""]
        if "by_object" in table:
            parts += ["Object by object:", "", object_table(table["by_object"]), ""]
    for name, about in record.numbers.get("data_sets", {}).items():
        parts += [data_set_facts(name, about), ""]
    return "\n".join(parts).rstrip() + "\n"


def method_table(table: dict[str, Any]) -> str:
    """Return one row per method; where clips have no direction, also how often one is claimed."""
    rows, columns = [], list(COLUMNS)
    has_undirected = any(own["false_claim_rate"] is not None for own in table["methods"].values())
    if has_undirected:
        columns.insert(NO_ANSWER, CLAIMED)
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
        if has_undirected:
            rows[-1].insert(NO_ANSWER, f"{scores['false_claim_rate']:.3f}")
    return markdown(columns, rows)


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
    pictures = [f"![{title}]({path})" for title, path in confusion_pictures(record).items()]
    shown = "\n\n".join([CONFUSIONS, *pictures]) + "\n\n" if pictures else ""
    return f"{intro}\n\n{evaluation_tables(record)}\n{shown}{provenance(record)}\n"


EXAMPLE_FIELDS: dict[str, Any] = {
    **dict.fromkeys(("text", "direction", "confidence", "abstained")),
    "frame": {"sentence": None},
    "evidence": {"regions": {"upper_minus_lower": None}},
}
"""Fields of an answer that the example shows, each where a program finds it; None is all of it."""


def answer_example(record: RunRecord) -> str:
    """Return a question, its answer as people and as programs get it, and the cold start."""
    numbers = record.numbers
    answer = numbers["answer"]
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
        json.dumps(_kept(answer, EXAMPLE_FIELDS), indent=1),
        "```",
        "",
        f"A cold answer, interpreter start included, takes {median:.1f} s (median of "
        f"{len(seconds)}, {seconds[0]:.1f}-{seconds[-1]:.1f} s).",
        "",
        provenance(record),
    ]
    return "\n".join(lines)


def _kept(value: Any, fields: dict[str, Any] | None) -> Any:
    """Return `value` with the other fields left out, and none moved."""
    if fields is None:
        return value
    return {name: _kept(value[name], inner) for name, inner in fields.items()}


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
