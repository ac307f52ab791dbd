"""The record of an evaluation of language as Markdown: types, groups, doubt and evidence.

Knows the record's layout, not how it was measured.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.tables import difference_line, markdown, provenance

TITLES = {
    "T1": "direction",
    "T2": "yes or no",
    "T3": "choice",
    "T4": "negation",
    "T5": "kind of motion",
    "T6": "contact",
    "T7": "how far",
    "T8": "how fast",
    "T9": "comparison, one clip",
    "T10": "evidence",
    "T11": "viewpoint",
    "T12": "who moves",
    "T13": "thread",
    "T14": "mirrored",
    "T15": "backwards",
    "T16": "moving at all",
    "T17": "unanswerable",
    "T18": "false premise",
    "T19": "confidence",
    "T21": "undo",
    "T22": "order, one clip",
}
"""Question types in words."""

COLUMNS = (
    "words",
    "unseen wordings",
    "scored",
    "probe",
    "flow",
    "blind",
    "shuffled clips",
)
"""Methods, in the order of the table's columns."""

INTRO = """# Language: every question type, and groups of questions

Each clip is asked one question of every type through the same door a user takes. *Words* are graded
by what they decide and claim, in the frame they are told in; words that are none of the answers,
refusals of what can be answered, and answers of a type the model was not trained on count as wrong.
*Scored* is the likeliest of the options, *probe* and *flow* the linear probe's and optical flow's
choice among all ten motions, turned into an answer by the exact rules of the type; *blind* is the
same model shown the mean of all clips, *shuffled* shown a clip of another object. *Commonest* is
what always giving the commonest answer would get, *by answer* the mean of how often each right
answer is given, of which a constant one gets its share alone. *Told by* says whose sentence it is:
the model's, or a rule's that follows from what the model read. Intervals and p-values keep objects
whole.

A dash stands where a method has no answer of that type: no probe says how far, and what is rightly
declined is declined whatever the clip. Evidence told by rule says where the halves go and not which
motion that is, so that it is right where every claim has the sign of the true field (on real clips:
where the whole goes the way of the motion)."""


def language_page(record: RunRecord) -> str:
    """Return the whole evaluation as a page of its own."""
    return f"{INTRO}\n\n{language_tables(record)}\n{provenance(record)}\n"


def language_headline(record: RunRecord) -> str:
    """Return what all types together came to, a row per set of clips, for the README."""
    header = ["clips", "types", "questions", "words", "95 %", *COLUMNS[1:], "groups all right"]
    rows = []
    for title, scores in record.numbers["sets"].items():
        groups = [one["all_right"] for one in scores["groups"].values()]
        for name, own in scores["pooled"].items():
            _, questions, _, _, words, interval, _, *others, _ = _type_row(name, own)
            whole = f"{min(groups):.3f}-{max(groups):.3f}" if groups else "-"
            rows.append([title, name, questions, words, interval, *others, whole])
    return f"{markdown(header, rows)}\n\n{provenance(record)}"


def language_tables(record: RunRecord) -> str:
    """Return the tables of every set of clips, simulated and real apart."""
    parts = []
    for title, scores in record.numbers["sets"].items():
        parts += [
            f"## {title}",
            f"{scores['clips']} clips of {scores['families']} objects or families of objects.",
            type_table(scores),
            "\n".join(
                f"- {name}: {difference_line(one)[2:]}"
                for name, pairs in scores["differences"].items()
                for one in pairs
            ),
            group_table(scores["groups"]),
            "\n".join(f"- {line}" for line in facts(scores)),
        ]
    return "\n\n".join(parts) + "\n"


def type_table(scores: Mapping[str, Any]) -> str:
    """Return one row per question type and per pool of types."""
    header = [
        "type",
        "n",
        "told by",
        "commonest",
        "words",
        "95 %",
        "by answer",
        *COLUMNS[1:],
        "why wrong",
    ]
    types = scores["types"]  # in the order of the titles, whatever a file made of it
    named = {f"{one} {title}": types[one] for one, title in TITLES.items() if one in types}
    return markdown(header, [_type_row(n, x) for n, x in (named | scores["pooled"]).items()])


def group_table(groups: Mapping[str, Any]) -> str:
    """Return one row per sort of group."""
    header = ["group", "n", "all right", "95 %", "one alone", "answers differ"]
    rows = [
        [
            name,
            str(one["groups"]),
            f"{one['all_right']:.3f}",
            "{:.3f}-{:.3f}".format(*one["interval"]),
            f"{one['one_right']:.3f}",
            f"{one['differing']:.3f}",
        ]
        for name, one in groups.items()
    ]
    return markdown(header, rows)


def facts(scores: Mapping[str, Any]) -> list[str]:
    """Return what stated doubt, refusals, amounts and evidence are worth, one line each."""
    yes, declined = scores["yes"], scores["unanswerable"]
    lines = [
        f"yes is said to {_share(yes['said'])} of the claims it gave a verdict on, and is right for"
        f" {_share(yes['true'])} of {yes['questions']};",
        f"what touch cannot tell is declined in {_share(declined['recall'])} of the cases, and what"
        f" it can in {_share(declined['false_refusals'])};",
        "wrong answers by cause, of all questions: "
        + (", ".join(f"{name} {_share(x)}" for name, x in scores["faults"].items()) or "none")
        + ";",
    ]
    lines += [_doubt(name, one) for name, one in scores["confidence"].items() if one]
    lines += [_amount(unit, one) for unit, one in scores["amounts"].items() if one["asked"]]
    lines += [
        f"stated evidence, {name}: {_share(one['claims_right'])} of {one['claims']} claims agree, "
        f"every claim in {_share(one['all_right'])} of {one['answers']} answers;"
        for name, one in scores["evidence"].items()
        if one["answers"]
    ]
    return [*lines[:-1], lines[-1].rstrip(";") + "."]


def _type_row(name: str, own: Mapping[str, Any]) -> list[str]:
    methods = own["methods"]
    words = methods.get("words")
    interval = "-" if words is None else "{:.3f}-{:.3f}".format(*words["interval"])
    faults = ", ".join(f"{count} {fault}" for fault, count in own.get("faults", {}).items())
    return [
        name,
        str(own["questions"]),
        _told_by(own.get("told_by_model", 0.0)),
        f"{own.get('commonest', 0.0):.2f}",
        _accuracy(words),
        interval,
        "-" if words is None else f"{words['by_answer']:.3f}",
        *(_accuracy(methods.get(column)) for column in COLUMNS[1:]),
        faults or "-",
    ]


def _told_by(share: float) -> str:
    return {1.0: "model", 0.0: "rule"}.get(share, f"model {share:.0%}")


def _accuracy(method: Mapping[str, Any] | None) -> str:
    return "-" if method is None else f"{method['accuracy']:.3f}"


def _share(value: float | None) -> str:
    return "-" if value is None else f"{100 * value:.1f} %"


def _doubt(name: str, one: Mapping[str, Any]) -> str:
    return (
        f"confidence, {name}: calibration error {one['calibration_error']:.3f}, Brier "
        f"{one['brier']:.3f}, mean {one['mean_confidence']:.3f} at accuracy {one['accuracy']:.3f} "
        f"of {one['answered']} answers; area under risk against coverage "
        f"{one['area_under_risk_coverage']:.4f}, 99 % right at a coverage of "
        f"{_share(one['coverage_at_99'])}, 90 % at {_share(one['coverage_at_90'])};"
    )


def _amount(unit: str, one: Mapping[str, Any]) -> str:
    error = one["median_relative_error"]
    off = "none was" if error is None else f"they are off by {_share(error)} (median)"
    return (
        f"amounts in {unit}: {one['stated']} of {one['asked']} stated, {off}"
        + (" stated" if error is None else "")
        + f", {_share(one['in_tolerance'])} within tolerance;"
    )
