"""Which method to take: what nothing else beats, and one pick for each way the model is used."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import mean
from typing import Any

LOOP_MS = 40.0
"""A frame of a camera of 25 frames a second."""

NEARLY = 0.01
"""Errors this far apart count as the same."""

SPEAKING = ("LM generated", "LM generated, --why")
"""Methods that answer any question in words; the start of their rows' names."""


@dataclass(frozen=True)
class Pick:
    """One use and what to take for it.

    Args:
        use: What it is for.
        rule: How it was picked.
        method: The method; None where none fulfils the rule.
        error: Its mean error over the sources of four frames.
        cost: What it costs, in words.
    """

    use: str
    rule: str
    method: str | None
    error: float | None
    cost: str


def is_on_front(row: Mapping[str, Any], rows: Sequence[Mapping[str, Any]]) -> bool:
    """Tell whether no other row has a smaller error and median time, one of them at least less."""
    own = (row["error"], row["ms_median"])
    return not any(
        other["error"] <= own[0]
        and other["ms_median"] <= own[1]
        and (other["error"], other["ms_median"]) != own
        for other in rows
    )


def picks(numbers: Mapping[str, Any]) -> list[Pick]:
    """Return the picks for a robot's loop, a batch job and a chat.

    Only methods that were asked about every source of four frames count: one that tells turns alone
    is no choice where a slide may come.
    """
    methods = _whole_methods(numbers["methods"])
    return [_loop(methods), _batch(methods, numbers["batches"]), _chat(methods)]


def _whole_methods(rows: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, float]]:
    four = [row for row in rows if row["frames"] > 2]
    sources = {row["source"] for row in four}
    found = {}
    for name in dict.fromkeys(row["method"] for row in four):
        own = [row for row in four if row["method"] == name]
        if {row["source"] for row in own} == sources:
            found[name] = {
                "error": mean(row["error"] for row in own),
                "ms_median": mean(row["ms_median"] for row in own),
                "ms_p95": max(row["ms_p95"] for row in own),
            }
    return found


def _loop(methods: Mapping[str, Mapping[str, float]]) -> Pick:
    rule = f"least error of those with a p95 below {LOOP_MS:g} ms, then the fastest"
    in_time = {name: own for name, own in methods.items() if own["ms_p95"] < LOOP_MS}
    return _picked("a robot's loop", rule, in_time)


def _chat(methods: Mapping[str, Mapping[str, float]]) -> Pick:
    rule = "least error of those that answer any question in words, then the fastest"
    speaking = {name: own for name, own in methods.items() if name.startswith(SPEAKING)}
    return _picked("a chat", rule, speaking)


def _picked(use: str, rule: str, methods: Mapping[str, Mapping[str, float]]) -> Pick:
    if not methods:
        return Pick(use, rule, None, None, "-")
    least = min(own["error"] for own in methods.values())
    near = {name: own for name, own in methods.items() if own["error"] <= least + NEARLY}
    name = min(near, key=lambda one: near[one]["ms_median"])
    own = near[name]
    cost = f"{own['ms_median']:.1f} ms a clip, p95 {own['ms_p95']:.1f}"
    return Pick(use, rule, name, own["error"], cost)


def _batch(
    methods: Mapping[str, Mapping[str, float]], batches: Sequence[Mapping[str, Any]]
) -> Pick:
    rule = f"most clips a second within {NEARLY:g} of the least error that a batch has"
    timed = {}
    for row in batches:
        suffix = "" if row["precision"] == "float32" else f", {row['precision']}"
        if (name := row["work"] + suffix) in methods:
            best = timed.get(name)
            timed[name] = row if best is None or row["ms_median"] < best["ms_median"] else best
    if not timed:
        return Pick("a batch job", rule, None, None, "-")
    least = min(methods[name]["error"] for name in timed)
    near = [name for name in timed if methods[name]["error"] <= least + NEARLY]
    name = min(near, key=lambda one: timed[one]["ms_median"])
    row = timed[name]
    cost = (
        f"{1e3 / row['ms_median']:.0f} clips a second in batches of {row['batch']}, "
        f"{row['threads']} thread{'s' * (row['threads'] > 1)}"
    )
    return Pick("a batch job", rule, name, methods[name]["error"], cost)
