"""Score a finished bundle on fused tokens: what the model card reports and calibration reads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from torch import Tensor

from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.labels import DIRECTED, ROTATIONS, SLIDES, Motion, MotionLabel
from geotlm_lm.core.seeding import generator_for
from geotlm_lm.data.questions import QuestionAnswer, questions_for

OPEN_QUESTION = "T1"


@dataclass(frozen=True, eq=False)
class ClipSet:
    """Perceived clips with their truth.

    Args:
        fused_tokens: z, shape (n, d).
        global_tokens: c, shape (n, d).
        contact_share: Mean contact mask, shape (n,).
        labels: The truth of each clip.
        objects: Name of the touched object of each clip.
    """

    fused_tokens: Tensor
    global_tokens: Tensor
    contact_share: NDArray[np.floating]
    labels: Sequence[MotionLabel]
    objects: Sequence[str]

    def readable(self) -> list[int]:
        """Return the rows whose motion leaves a trace in the image."""
        return [row for row, label in enumerate(self.labels) if label.is_readable]


def true_option_likelihoods(
    bundle: Bundle, clips: ClipSet, seed: int
) -> tuple[NDArray[np.floating], NDArray[np.integer]]:
    """Return the likelihood of every answer to an open question, and which is true.

    Returns:
        Log-likelihoods, shape (n, options), and the index of the true option, shape (n,).
    """
    rows, truths = [], []
    for row in clips.readable():
        asked = _asked(clips.labels[row], seed, row, "seen", (OPEN_QUESTION,))[0]
        scores = bundle.speaker.score(clips.fused_tokens[row], asked.question, asked.options)
        rows.append(scores)
        truths.append(asked.options.index(asked.answer))
    return np.array(rows), np.array(truths)


def score_bundle(bundle: Bundle, clips: ClipSet, seed: int) -> dict[str, Any]:
    """Return accuracies on objects no weight has seen.

    Generated answers are free: any sentence may come, and one that is none of the answers counts as
    wrong. The probes choose among the motions of the task.
    """
    readable = clips.readable()
    scores: dict[str, Any] = {
        "clips": len(clips.labels),
        "unreadable_clips": len(clips.labels) - len(readable),
    }
    for task, motions in (("rotation", ROTATIONS), ("sliding", SLIDES)):
        rows = [row for row in readable if clips.labels[row].motion in motions]
        truths = [clips.labels[row].motion for row in rows]
        scores[task] = {
            "clips": len(rows),
            "generated": _generated_accuracy(bundle, clips, rows, "seen", seed),
            "generated_held_out_wordings": _generated_accuracy(
                bundle, clips, rows, "held_out", seed
            ),
            "probe": _share(bundle.model.probe.predict(clips.fused_tokens[rows], motions), truths),
            "global_probe": _share(
                bundle.model.global_probe.predict(clips.global_tokens[rows], motions), truths
            ),
        }
    scores["by_type"] = {
        f"{type_id} {wordings}": accuracy
        for wordings in ("seen", "held_out")
        for type_id, accuracy in _accuracy_by_type(bundle, clips, wordings, seed).items()
    }
    scores["false_directions"] = _false_directions(bundle, clips, seed)
    return scores


def _generated_accuracy(bundle, clips: ClipSet, rows: list[int], wordings: str, seed: int) -> float:
    asked = [_asked(clips.labels[row], seed, row, wordings, (OPEN_QUESTION,))[0] for row in rows]
    texts = bundle.speaker.generate(clips.fused_tokens[rows], [one.question for one in asked])
    return _share(texts, [one.answer for one in asked])


def _accuracy_by_type(bundle, clips: ClipSet, wordings: str, seed: int) -> dict[str, float]:
    by_type: dict[str, list[tuple[int, QuestionAnswer]]] = {}
    for row in clips.readable():
        for one in _asked(clips.labels[row], seed, row, wordings, None):
            by_type.setdefault(one.type_id, []).append((row, one))
    accuracies = {}
    for type_id, asked in by_type.items():
        rows = [row for row, _ in asked]
        texts = bundle.speaker.generate(clips.fused_tokens[rows], [q.question for _, q in asked])
        accuracies[type_id] = _share(texts, [one.answer for _, one in asked])
    return accuracies


def _false_directions(bundle, clips: ClipSet, seed: int) -> float:
    """Return how often a direction is claimed of clips that have none."""
    rows = [row for row in clips.readable() if clips.labels[row].motion not in DIRECTED]
    asked = [_asked(clips.labels[row], seed, row, "seen", (OPEN_QUESTION,))[0] for row in rows]
    texts = bundle.speaker.generate(clips.fused_tokens[rows], [one.question for one in asked])
    parsed = [bundle.grammar.parse(text) for text in texts]
    claims = [slots is not None and slots.direction in DIRECTED for slots in parsed]
    return float(np.mean(claims)) if claims else 0.0


def _asked(
    label: MotionLabel, seed: int, row: int, wordings: str, types: tuple[str, ...] | None
) -> list[QuestionAnswer]:
    rng = generator_for(seed, "scoring", wordings, row)
    return questions_for(label, rng, types=types, wordings=wordings)


def _share(found: Sequence[str | Motion], expected: Sequence[str | Motion]) -> float:
    if not expected:
        return float("nan")
    return float(np.mean([a == b for a, b in zip(found, expected, strict=True)]))
