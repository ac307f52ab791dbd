"""From rows and groups to numbers: plain JSON values, intervals clustered by object."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from geotlm_lm.evaluation.calibration import expected_calibration_error
from geotlm_lm.evaluation.scores import mean_by_group
from geotlm_lm.evaluation.selective import (
    area_under_risk_coverage,
    brier_score,
    coverage_at,
    risk_coverage,
)
from geotlm_lm.evaluation.uncertainty import clustered_interval, paired_difference
from geotlm_lm.experiments.language_asking import METHODS, WORDS, Row
from geotlm_lm.experiments.language_groups import Group
from geotlm_lm.odometry.odometer import UNITS

DIRECTIONS = ("T1", "T2", "T3", "T4", "T11", "T12", "T14", "T15", "T18", "T21")
"""Types whose answer names a direction."""

REFUSAL = "T17"

CURVE_POINTS = 20
"""Coverages of the risk-coverage curve that are kept."""


def summarise_talk(rows: Sequence[Row], groups: Sequence[Group], seed: int) -> dict[str, Any]:
    """Return every score of one set of clips.

    Args:
        rows: One per question; at least one.
        groups: Of the same clips.
        seed: Root of the resampling.
    """
    by_type = {one: [row for row in rows if row.type_id == one] for one in _types(rows)}
    directions = [row for row in rows if row.type_id in DIRECTIONS]
    return {
        "clips": len({row.clip for row in rows}),
        "families": len({row.family for row in rows}),
        "types": {one: type_scores(own, seed) for one, own in by_type.items()},
        "pooled": {
            "all directions": type_scores(directions, seed),
            "all types": type_scores(rows, seed),
        },
        "differences": {
            "all directions": differences(directions, seed),
            "all types": differences(rows, seed),
        },
        "faults": _faults(rows),
        "yes": _yes(rows),
        "unanswerable": _unanswerable(rows),
        "confidence": {
            "all types": confidence_scores(rows),
            "open question": confidence_scores(by_type.get("T1", [])),
        },
        "amounts": {unit: amount_scores(rows, unit) for unit in UNITS},
        "evidence": {
            "with the true field": _claims([row.claims for row in rows]),
            "with what the model read": _claims([row.own_claims for row in rows]),
        },
        "groups": {
            name: group_scores([one for one in groups if one.name == name], seed)
            for name in dict.fromkeys(group.name for group in groups)
        },
    }


def _types(rows: Sequence[Row]) -> list[str]:
    found = {row.type_id for row in rows}
    return sorted(found, key=lambda type_id: int(type_id.removeprefix("T")))


def type_scores(rows: Sequence[Row], seed: int) -> dict[str, Any]:
    """Return the accuracy of every method on some rows, and what a constant answer would get."""
    if not rows:
        return {"questions": 0, "methods": {}}
    methods = {}
    for name in METHODS:
        own = [row for row in rows if name in row.right]
        if own:
            right = np.array([row.right[name] for row in own])
            low, high = clustered_interval(right, [row.family for row in own], seed=seed)
            methods[name] = {
                "questions": len(own),
                "accuracy": float(right.mean()),
                "interval": [low, high],
                "by_answer": balanced_accuracy_of(own, name),
            }
    truths = Counter(row.truth for row in rows)
    return {
        "questions": len(rows),
        "commonest": truths.most_common(1)[0][1] / len(rows),
        "told_by_model": float(np.mean([row.told_by == "model" for row in rows])),
        "recall": {
            truth: float(np.mean([row.right[WORDS] for row in rows if row.truth == truth]))
            for truth in sorted(truths)
        },
        "faults": dict(Counter(row.fault for row in rows if row.fault)),
        "methods": methods,
    }


def balanced_accuracy_of(rows: Sequence[Row], method: str) -> float:
    """Return the mean over right answers of how often each is given: a constant one gets 1 / k."""
    by_truth = mean_by_group(np.array([row.right[method] for row in rows]), [r.truth for r in rows])
    return float(np.mean(list(by_truth.values())))


def differences(rows: Sequence[Row], seed: int) -> list[dict[str, Any]]:
    """Return the accuracy of the words less that of every other method, paired by question.

    Objects are resampled and flipped as wholes.
    """
    found = []
    for name in METHODS:
        own = [row for row in rows if name in row.right]
        if name == WORDS or not own:
            continue
        first, second = (np.array([row.right[one] for row in own]) for one in (WORDS, name))
        difference = paired_difference(first, second, [row.family for row in own], seed=seed)
        found.append({"first": WORDS, "second": name, "questions": len(own)} | asdict(difference))
    return found


def confidence_scores(rows: Sequence[Row]) -> dict[str, Any] | None:
    """Return calibration and selection scores; None where nothing was answered.

    Questions that are rightly declined, or always are, state no confidence and stay out. An answer
    that is withheld counts as wrong, at confidence 0, wherever coverage is counted.
    """
    asked = [row for row in rows if row.truth != "declined" and (row.said or row.fault)]
    answered = [row for row in asked if row.said is not None]
    if not answered:
        return None
    confidence, right = _confidence(answered)
    all_confidence, all_right = _confidence(asked)
    coverage, risk = risk_coverage(all_confidence, all_right)
    at = np.unique(np.linspace(0, len(coverage) - 1, CURVE_POINTS).round().astype(int))
    return {
        "answered": len(answered),
        "asked": len(asked),
        "calibration_error": expected_calibration_error(confidence, right),
        "brier": brier_score(confidence, right),
        "mean_confidence": float(confidence.mean()),
        "accuracy": float(right.mean()),
        "area_under_risk_coverage": area_under_risk_coverage(all_confidence, all_right),
        "coverage_at_99": coverage_at(all_confidence, all_right, 0.99),
        "coverage_at_90": coverage_at(all_confidence, all_right, 0.90),
        "curve": [[float(coverage[i]), float(risk[i])] for i in at],
    }


def _confidence(rows: Sequence[Row]) -> tuple[np.ndarray, np.ndarray]:
    return (
        np.array([row.confidence for row in rows]),
        np.array([row.right[WORDS] for row in rows]),
    )


def amount_scores(rows: Sequence[Row], unit: str) -> dict[str, Any]:
    """Return how far stated amounts of one unit are off, relative to the true ones."""
    of_unit = [row for row in rows if row.unit == unit and row.truth != "declined"]
    errors = [row.amount_error for row in of_unit if row.amount_error is not None]
    return {
        "asked": len(of_unit),
        "stated": len(errors),
        "median_relative_error": float(np.median(errors)) if errors else None,
        "in_tolerance": float(np.mean([row.right[WORDS] for row in of_unit])) if of_unit else None,
    }


def group_scores(groups: Sequence[Group], seed: int) -> dict[str, Any]:
    """Return how often all of a group is right, each place alone, and the answers differ."""
    whole = np.array([all(group.right) for group in groups])
    low, high = clustered_interval(whole, [group.family for group in groups], seed=seed)
    places = {len(group.right) for group in groups}
    by_place = np.mean([group.right for group in groups], axis=0) if len(places) == 1 else []
    return {
        "groups": len(groups),
        "all_right": float(whole.mean()),
        "interval": [low, high],
        "one_right": float(np.mean([right for group in groups for right in group.right])),
        "by_place": [float(value) for value in by_place],
        "differing": float(np.mean([len(set(group.said)) > 1 for group in groups])),
    }


def _faults(rows: Sequence[Row]) -> dict[str, float]:
    found = Counter(row.fault for row in rows if row.fault)
    return {fault: count / len(rows) for fault, count in sorted(found.items())}


def _yes(rows: Sequence[Row]) -> dict[str, Any]:
    verify = [row for row in rows if row.type_id == "T2"]
    said = [row.said for row in verify if row.said in ("yes", "no")]
    return {
        "questions": len(verify),
        "said": said.count("yes") / len(said) if said else None,
        "true": sum(row.truth == "yes" for row in verify) / len(verify) if verify else None,
    }


def _unanswerable(rows: Sequence[Row]) -> dict[str, Any]:
    asked = [row.right[WORDS] for row in rows if row.type_id == REFUSAL]
    others = [row.fault == "refused" for row in rows if row.type_id != REFUSAL]
    return {
        "recall": float(np.mean(asked)) if asked else None,
        "false_refusals": float(np.mean(others)) if others else None,
    }


def _claims(claims: Sequence[tuple[bool, ...]]) -> dict[str, Any]:
    stated = [one for one in claims if one]
    every = [right for one in stated for right in one]
    return {
        "answers": len(stated),
        "claims": len(every),
        "claims_right": float(np.mean(every)) if every else None,
        "all_right": float(np.mean([all(one) for one in stated])) if stated else None,
    }
