"""The record of a transcript as Markdown; knows the record's layout, not how it was made."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.tables import provenance

INTRO = """# Questions that nobody wrote a template for

Each is asked in a conversation of its own about one of the example clips. An answer is *odd* where
it lacks what a person would take for right, which is written down beside the question; what is odd
is explained."""


def transcript_page(record: RunRecord) -> str:
    """Return the whole transcript as a page of its own."""
    numbers = record.numbers
    parts = [INTRO, f"{numbers['as_wanted']} of {numbers['questions']} answers are as wanted."]
    for clip in dict.fromkeys(turn["clip"] for turn in numbers["turns"]):
        parts.append(f"## {clip.replace('_', ' ')}")
        parts += [told(turn) for turn in numbers["turns"] if turn["clip"] == clip]
    return "\n\n".join([*parts, provenance(record)]) + "\n"


def told(turn: Mapping[str, Any]) -> str:
    """Return one question, its answer and, if that is odd, what was wanted and why."""
    lines = [f"> {question}  \n{answer}  " for question, answer in turn["before"]]
    sure = f"{turn['confidence']:.0%}" if turn["confidence"] else "-"
    teller = {"model": "in the model's words", "rule": "by rule"}.get(turn["told_by"], "by rule")
    lines.append(f"> {turn['question']}  \n**{turn['answer']}** ({sure}, {teller})")
    if not turn["as_wanted"]:
        found = {name: turn["found"][name] for name in turn["wanted"]}
        lines[-1] += f"  \n*Odd*: wanted {_fields(turn['wanted'])}, found {_fields(found)}."
        lines[-1] += f" {turn['note']}" if turn["note"] else ""
    return "\n\n".join(lines)


def _fields(values: Mapping[str, Any]) -> str:
    words = {True: "yes", False: "no", None: "none"}
    told = [f"{name} {words.get(value, value)}" for name, value in values.items()]
    return ", ".join(told)
