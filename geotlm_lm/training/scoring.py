"""Score a finished bundle on fused tokens: what the model card reports and calibration reads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn.functional import pad

from geotlm_lm.checkpoint import Bundle, reading_of
from geotlm_lm.core.labels import DIRECTED, ROTATIONS, SLIDES, Motion, MotionLabel
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.data.questions import WORDINGS, QuestionAnswer, questions_for
from geotlm_lm.motion.measured import Measured
from geotlm_lm.motion.network import BELIEF_NUMBERS
from geotlm_lm.probe.linear import LinearProbe
from geotlm_lm.training.calibration_error import expected_calibration_error
from geotlm_lm.training.felt import UNASKED, felt_words

OPEN_TYPE = "T1"


@dataclass(frozen=True, eq=False)
class ClipSet:
    """Perceived clips with their truth.

    Args:
        fused_tokens: z, shape (n, d).
        global_tokens: c, shape (n, d).
        contact_share: Mean contact mask, shape (n,).
        measured: What is measured of each clip's motion.
        labels: The truth of each clip.
        objects: Name of the touched object of each clip.
    """

    fused_tokens: Tensor
    global_tokens: Tensor
    contact_share: NDArray[np.floating]
    measured: Measured
    labels: Sequence[MotionLabel]
    objects: Sequence[str]

    def readable(self) -> list[int]:
        """Return the rows whose motion leaves a trace in the image."""
        return [row for row, label in enumerate(self.labels) if label.is_readable]

    def readings(self, bundle: Bundle) -> Tensor:
        """Return what the language model of `bundle` reads of each clip, (n, width)."""
        return reading_of(self.fused_tokens, bundle.motion(self.measured))

    def only(self, rows: Sequence[int]) -> ClipSet:
        """Return the clips of `rows`, in that order."""
        return ClipSet(
            fused_tokens=self.fused_tokens[rows],
            global_tokens=self.global_tokens[rows],
            contact_share=self.contact_share[rows],
            measured=self.measured.only(rows),
            labels=[self.labels[row] for row in rows],
            objects=[self.objects[row] for row in rows],
        )


def true_option_likelihoods(
    bundle: Bundle, clips: ClipSet, seed: int
) -> tuple[NDArray[np.floating], NDArray[np.integer]]:
    """Return the likelihood of every answer to an open question, and which is true.

    Returns:
        Log-likelihoods, shape (n, options), and the index of the true option, shape (n,).
    """
    rows, truths = [], []
    readings = clips.readings(bundle)
    for row in clips.readable():
        asked = _asked(clips.labels[row], seed, row, "seen", (OPEN_TYPE,))[0]
        scores = bundle.speaker.score(readings[row], asked.question, asked.options)
        rows.append(scores)
        truths.append(asked.options.index(asked.answer))
    return np.array(rows), np.array(truths)


def felt_likelihoods(
    bundle: Bundle, clips: ClipSet
) -> tuple[NDArray[np.floating], NDArray[np.integer]]:
    """Return the likelihoods of the words at all slots of which something is asked, and the truth.

    Slots have different numbers of words: what a slot lacks has likelihood 0.

    Returns:
        Log-likelihoods, shape (n, words), and the index of the true word, shape (n,).
    """
    felt, wanted = bundle.speaker.feel(clips.readings(bundle)), felt_words(clips.labels)
    most = max(logits.shape[1] for logits in felt.values())
    rows, truths = [], []
    for place, logits in enumerate(felt.values()):
        asked = wanted[:, place] != UNASKED
        lacking = (0, most - logits.shape[1])
        rows.append(pad(logits[asked], lacking, value=-torch.inf).double().numpy())
        truths.append(wanted[asked, place].numpy())
    return np.concatenate(rows), np.concatenate(truths)


def felt_scores(bundle: Bundle, clips: ClipSet, *, is_silent: bool = False) -> dict[str, float]:
    """Return the share of right words at each slot, of those of which something is asked.

    Args:
        bundle: The model.
        clips: Perceived clips.
        is_silent: Whether the model reads the fused token alone.
    """
    readings = clips.readings(bundle)
    if is_silent:
        readings[:, -BELIEF_NUMBERS:] = bundle.speaker.model.projector.mean[-BELIEF_NUMBERS:]
    felt, wanted = bundle.speaker.feel(readings), felt_words(clips.labels)
    scores = {}
    for place, (slot, logits) in enumerate(felt.items()):
        asked = wanted[:, place] != UNASKED
        scores[slot] = _share((logits.argmax(dim=1) == wanted[:, place])[asked].tolist())
    return scores


def score_bundle(bundle: Bundle, clips: ClipSet, seed: int) -> dict[str, Any]:
    """Return accuracies on objects no weight has seen.

    Answers are free: any sentence may come, and one that is none of the answers counts as wrong, as
    does one withheld for want of contact. The probes choose among the motions of the task.
    """
    readable = clips.readable()
    said = {wordings: _ask_all(bundle, clips, wordings, seed) for wordings in ("seen", "held_out")}
    scores: dict[str, Any] = {
        "clips": len(clips.labels),
        "unreadable_clips": len(clips.labels) - len(readable),
    }
    for task, motions in (("rotation", ROTATIONS), ("sliding", SLIDES)):
        rows = [row for row in readable if clips.labels[row].motion in motions]
        scores[task] = {
            "clips": len(rows),
            "generated": _open_accuracy(said["seen"], rows),
            "generated_held_out_wordings": _open_accuracy(said["held_out"], rows),
            "probe": _probe_accuracy(bundle.model.probe, clips.fused_tokens, clips, rows, motions),
            "global_probe": _probe_accuracy(
                bundle.model.global_probe, clips.global_tokens, clips, rows, motions
            ),
        }
    scores["by_type"] = {
        f"{type_id} {wordings}": _share([one.is_right for one in replies if one.type_id == type_id])
        for wordings, replies in said.items()
        for type_id in dict.fromkeys(one.type_id for one in replies)
    }
    scores["false_directions"] = _false_directions(clips, said["seen"])
    return scores | _scored(bundle, clips, seed)


@dataclass(frozen=True)
class _Reply:
    """What the model said to one question; `claim` is the motion it names, None if none."""

    row: int
    type_id: str
    is_right: bool
    claim: Motion | None


def _ask_all(bundle: Bundle, clips: ClipSet, wordings: WORDINGS, seed: int) -> list[_Reply]:
    """Ask one question of every type about every readable clip."""
    asked = [
        (row, one)
        for row in clips.readable()
        for one in _asked(clips.labels[row], seed, row, wordings, None)
    ]
    # Questions of one type are of like length: the padding of a batch stays short.
    asked.sort(key=lambda pair: int(pair[1].type_id.removeprefix("T")))
    rows = [row for row, _ in asked]
    texts = bundle.speaker.generate(
        clips.readings(bundle)[rows], [one.question for _, one in asked]
    )
    replies = []
    for (row, one), text in zip(asked, texts, strict=True):
        slots = bundle.grammar.parse(text)
        claim = slots.direction if slots else None
        is_withheld = bundle.calibration.withholds(claim, float(clips.contact_share[row]))
        is_right = text == one.answer and not is_withheld
        replies.append(_Reply(row, one.type_id, is_right, None if is_withheld else claim))
    return replies


def _scored(bundle: Bundle, clips: ClipSet, seed: int) -> dict[str, float]:
    """Return how the most likely answer to an open question fares, and its stated probability."""
    likelihoods, truths = true_option_likelihoods(bundle, clips, seed)
    is_right = likelihoods.argmax(axis=1) == truths
    confidence = bundle.calibration.probabilities(likelihoods).max(axis=1)
    return {
        "scored": _share(is_right.tolist()),
        "calibration_error": expected_calibration_error(confidence, is_right),
    }


def _open_accuracy(replies: Sequence[_Reply], rows: Sequence[int]) -> float:
    wanted = set(rows)
    return _share([r.is_right for r in replies if r.type_id == OPEN_TYPE and r.row in wanted])


def _probe_accuracy(
    probe: LinearProbe, tokens: Tensor, clips: ClipSet, rows: list[int], motions: tuple[Motion, ...]
) -> float:
    said = probe.predict(tokens[rows], motions)
    return _share([one == clips.labels[row].motion for one, row in zip(said, rows, strict=True)])


def _false_directions(clips: ClipSet, replies: Sequence[_Reply]) -> float:
    """Return how often an open question about a clip without direction is answered with one."""
    return _share(
        [
            one.claim in DIRECTED
            for one in replies
            if one.type_id == OPEN_TYPE and clips.labels[one.row].motion not in DIRECTED
        ]
    )


def _asked(
    label: MotionLabel, seed: int, row: int, wordings: WORDINGS, types: tuple[str, ...] | None
) -> list[QuestionAnswer]:
    rng = generator_for(seed, "scoring", wordings, row)
    return questions_for(label, rng, types=types, wordings=wordings)


def _share(hits: Sequence[bool]) -> float:
    """Return the share of hits; 0 where there is nothing to count, since JSON knows no NaN."""
    return float(np.mean(hits)) if hits else 0.0
