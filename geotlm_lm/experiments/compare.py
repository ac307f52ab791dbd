"""Methods side by side on the same clips: what each said, how long it took, how they differ.

Knows no model: a method is anything that names a motion for a clip.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import DIRECTED, Motion, reverse
from geotlm_lm.evaluation.answers import false_claim_rate, tally
from geotlm_lm.evaluation.scores import (
    accuracy,
    balanced_accuracy,
    confusion,
    correctness,
    macro_accuracy,
    mean_by_group,
    recall_per_class,
)
from geotlm_lm.evaluation.uncertainty import clustered_interval, paired_difference


@dataclass(frozen=True)
class Case:
    """One clip to be judged.

    Args:
        clip: The frames.
        motion: The truth.
        object_id: What is touched: the unit of the macro average.
        family: Objects that are not independent of each other: the unit of resampling.
        tags: What the clip can be selected by afterwards, e.g. played="backwards".
    """

    clip: Clip
    motion: Motion
    object_id: str
    family: str
    tags: Mapping[str, str]


@dataclass(frozen=True)
class Reply:
    """What a method made of a clip.

    Args:
        motion: The motion it names; None when it names none.
        milliseconds: Everything the method needed from the clip in memory to the motion.
    """

    motion: Motion | None
    milliseconds: float


Method = Callable[[Clip, tuple[Motion, ...]], Reply]
"""Takes a clip and the motions in question; a free-spoken method may name another."""


@dataclass(frozen=True, eq=False)
class Replies:
    """Everything all methods said about the same cases.

    Args:
        truths: The motion of each case.
        objects: The object of each case.
        families: The family of each case.
        tags: The tags of each case.
        motions: What each method said, case by case.
        milliseconds: How long each took, case by case.
    """

    truths: list[Motion]
    objects: list[str]
    families: list[str]
    tags: list[Mapping[str, str]]
    motions: dict[str, list[Motion | None]]
    milliseconds: dict[str, list[float]]

    def __len__(self) -> int:
        return len(self.truths)

    def where(self, **tags: str) -> Replies:
        """Return the replies to the cases that carry all of `tags`."""
        return self._rows(lambda own: tags.items() <= own.items())

    def without(self, **tags: str) -> Replies:
        """Return the replies to the cases that lack one of `tags` or more."""
        return self._rows(lambda own: not tags.items() <= own.items())

    def _rows(self, wanted: Callable[[dict[str, str]], bool]) -> Replies:
        rows = [i for i, own in enumerate(self.tags) if wanted(dict(own))]

        def pick(values: list) -> list:
            return [values[row] for row in rows]

        return Replies(
            pick(self.truths),
            pick(self.objects),
            pick(self.families),
            pick(self.tags),
            {name: pick(said) for name, said in self.motions.items()},
            {name: pick(took) for name, took in self.milliseconds.items()},
        )

    def right(self, method: str) -> NDArray[np.bool_]:
        """Return, case by case, whether `method` named the truth."""
        return correctness(self.truths, self.motions[method])


def timed(name_motion: Callable[[Clip, tuple[Motion, ...]], Motion | None]) -> Method:
    """Turn a plain function into a method that says how long it took."""

    def method(clip: Clip, among: tuple[Motion, ...]) -> Reply:
        started = time.perf_counter()
        motion = name_motion(clip, among)
        return Reply(motion, 1e3 * (time.perf_counter() - started))

    return method


def ask_all(
    methods: Mapping[str, Method],
    cases: Iterable[Case],
    among: Sequence[Motion],
    progress: Callable[[int], None] = lambda done: None,
) -> Replies:
    """Put every case to every method; cases are read one at a time and not kept.

    Args:
        methods: The methods, by the name their row gets.
        cases: The clips and their truths.
        among: The motions in question.
        progress: Called with the number of cases done.
    """
    replies = Replies([], [], [], [], {m: [] for m in methods}, {m: [] for m in methods})
    for done, case in enumerate(cases, start=1):
        replies.truths.append(case.motion)
        replies.objects.append(case.object_id)
        replies.families.append(case.family)
        replies.tags.append(case.tags)
        for name, method in methods.items():
            reply = method(case.clip, tuple(among))
            replies.motions[name].append(reply.motion)
            replies.milliseconds[name].append(reply.milliseconds)
        progress(done)
    return replies


def summarise(
    replies: Replies, contrasts: Sequence[tuple[str, str]] = (), *, seed: int = 0
) -> dict[str, Any]:
    """Return the scores of every method, and of the pairs in `contrasts`, as plain JSON values.

    Args:
        replies: What was said; at least one case.
        contrasts: Pairs (first, second): accuracy of the first less that of the second.
        seed: Root of the resampling.

    Raises:
        ValueError: If there is no case.
    """
    if not len(replies):
        raise ValueError("no case to score")
    return {
        "clips": len(replies),
        "objects": len(set(replies.objects)),
        "families": len(set(replies.families)),
        "truths": {str(m): replies.truths.count(m) for m in Motion if m in replies.truths},
        "methods": {name: _scores(replies, name, seed) for name in replies.motions},
        "differences": [
            {"first": first, "second": second}
            | asdict(
                paired_difference(
                    replies.right(first), replies.right(second), replies.families, seed=seed
                )
            )
            for first, second in contrasts
        ],
    }


def per_object(replies: Replies, methods: Sequence[str]) -> dict[str, Any]:
    """Return, object by object, how many clips there are and what share each method got right."""
    objects = sorted(set(replies.objects))
    counts = {one: replies.objects.count(one) for one in objects}
    rights = {name: mean_by_group(replies.right(name), replies.objects) for name in methods}
    return {
        one: {"clips": counts[one]} | {name: right[one] for name, right in rights.items()}
        for one in objects
    }


def claims(forwards: Replies, backwards: Replies) -> dict[str, dict[str, int]]:
    """Return how many directions each method claimed, and of how many it claimed the opposite too.

    That a direction turns round with the clip speaks for a motion in it; one that a method is
    merely inclined to claim stays as it is.

    Args:
        forwards: What was said of clips.
        backwards: What was said of the same clips in the same order, played backwards, perhaps
            asked in other words.
    """
    counts = {}
    for name, answers in forwards.motions.items():
        pairs = list(zip(answers, backwards.motions[name], strict=True))
        claimed = [(one, other) for one, other in pairs if one in DIRECTED]
        turned = sum(other == reverse(one) for one, other in claimed)
        counts[name] = {"directions": len(claimed), "turned_round": turned}
    return counts


def compare(
    methods: Mapping[str, Method],
    cases: Iterable[Case],
    among: Sequence[Motion],
    contrasts: Sequence[tuple[str, str]] = (),
    *,
    seed: int = 0,
) -> dict[str, Any]:
    """Put every case to every method and score them; arguments as above."""
    return summarise(ask_all(methods, cases, among), contrasts, seed=seed)


def _scores(replies: Replies, method: str, seed: int) -> dict[str, Any]:
    truths, answers = replies.truths, replies.motions[method]
    low, high = clustered_interval(replies.right(method), replies.families, seed=seed)
    milliseconds = np.array(replies.milliseconds[method])
    present = [motion for motion in Motion if motion in truths or motion in answers]
    return {
        "accuracy": accuracy(truths, answers),
        "interval": [low, high],
        "balanced_accuracy": balanced_accuracy(truths, answers),
        "macro_by_object": macro_accuracy(truths, answers, replies.objects),
        "recall": {str(motion): r for motion, r in recall_per_class(truths, answers).items()},
        "verdicts": tally(truths, answers),
        "false_claim_rate": false_claim_rate(truths, answers),
        "confusion": {
            "labels": [str(motion) for motion in present],
            "counts": confusion(truths, answers, present).tolist(),
        },
        "ms_median": float(np.median(milliseconds)),
        "ms_p95": float(np.quantile(milliseconds, 0.95)),
    }
