"""Variants side by side on the same clips: what each named, how long it took, how they differ.

Knows no model: a variant is anything that names a motion for a clip.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.benchmarks.rows import Row
from geotlm_lm.benchmarks.statistics import milliseconds, paired_difference, share_row
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import DIRECTED, Motion, reverse
from geotlm_lm.core.numbers import mean_by_group
from geotlm_lm.core.twist import COMPONENT_OF, Component

NEAR = 0.005
"""Share of right answers up to which words are not below a rival."""

CLAIMED = (Component.TURN, Component.SLIDE)
"""Components with a direction in the image plane: where there is none, none may be claimed."""


@dataclass(frozen=True)
class Case:
    """One clip to be judged.

    Args:
        clip: The frames; None once it has been asked about.
        motion: The truth.
        object_id: What is touched: the unit of the macro average.
        family: Objects that are not independent of each other: the unit of resampling.
        tags: What the clip can be selected by afterwards, e.g. played="backwards".
    """

    clip: Clip | None
    motion: Motion
    object_id: str
    family: str
    tags: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Reply:
    """What a variant made of a clip.

    Args:
        motion: The motion it names; None when it names none.
        milliseconds: Everything the variant needed from the clip in memory to the motion.
        claims: Every way it says that a turn or a slide goes; None for that of `motion` alone.
    """

    motion: Motion | None
    milliseconds: float
    claims: tuple[Motion, ...] | None = None

    def claimed(self, component: Component) -> Motion | None:
        """Return which way it says that a component goes; None where it says none."""
        ways = (self.motion,) if self.claims is None else self.claims
        return next((way for way in ways if COMPONENT_OF.get(way) is component), None)


Variant = Callable[[Clip, tuple[Motion, ...]], Reply]
"""Takes a clip and the motions in question; a free-spoken variant may name another."""


@dataclass(frozen=True, eq=False)
class Replies:
    """Everything all variants said about the same cases.

    Args:
        cases: The cases, their clips no longer kept.
        replies: What each variant said, case by case.
    """

    cases: list[Case]
    replies: dict[str, list[Reply]]

    def __len__(self) -> int:
        return len(self.cases)

    def where(self, **tags: str) -> Replies:
        """Return the replies to the cases that carry all of `tags`."""
        asked = tags.items()
        kept = [i for i, case in enumerate(self.cases) if asked <= dict(case.tags).items()]
        return Replies(
            [self.cases[i] for i in kept],
            {name: [said[i] for i in kept] for name, said in self.replies.items()},
        )

    def right(self, variant: str) -> NDArray[np.bool_]:
        """Return, case by case, whether a variant named the truth."""
        pairs = zip(self.cases, self.replies[variant], strict=True)
        return np.array([case.motion == reply.motion for case, reply in pairs], dtype=bool)


def timed(name_motion: Callable[[Clip, tuple[Motion, ...]], Motion | None]) -> Variant:
    """Turn a plain function into a variant that says how long it took."""

    def variant(clip: Clip, among: tuple[Motion, ...]) -> Reply:
        started = time.perf_counter()
        motion = name_motion(clip, among)
        return Reply(motion, 1e3 * (time.perf_counter() - started))

    return variant


def ask_all(
    variants: Mapping[str, Variant],
    cases: Iterable[Case],
    among: Sequence[Motion],
    progress: Callable[[int], None] = lambda done: None,
) -> Replies:
    """Put every case to every variant; clips are read one at a time and not kept.

    Args:
        variants: The variants, by the name their row gets.
        cases: The clips and their truths.
        among: The motions in question.
        progress: Called with the number of cases done.
    """
    found = Replies([], {name: [] for name in variants})
    for done, case in enumerate(cases, start=1):
        for name, variant in variants.items():
            found.replies[name].append(variant(case.clip, tuple(among)))
        found.cases.append(replace(case, clip=None))
        progress(done)
    return found


def rows_of_replies(
    title: str,
    replies: Replies,
    words: str = "",
    rivals: Sequence[str] = (),
    *,
    seed: int = 0,
    facts: Mapping[str, Any] | None = None,
) -> list[Row]:
    """Return one row per variant: its error, its times, and how words compare with their rivals.

    Args:
        title: What the rows call these cases.
        replies: What was said; without a case there is no row.
        words: The variant that is held against the better of its rivals.
        rivals: The variants it may not be worse than.
        seed: Root of the resampling.
        facts: What is to be known of the cases beside; in the first row's detail.
    """
    rows, families = [], [case.family for case in replies.cases]
    for name in replies.replies if len(replies) else ():
        right, detail = replies.right(name), _detail(replies, name) | dict(facts or {})
        others = {rival: replies.right(rival) for rival in rivals if rival in replies.replies}
        if name == words and others:
            better = max(others, key=lambda rival: others[rival].mean())
            gain = paired_difference(right, others[better], families, seed=seed)
            detail["rival"] = {"name": better, "is_below": gain["difference"] < -NEAR} | gain
        ms = milliseconds([one.milliseconds for one in replies.replies[name]])
        rows.append(share_row(title, name, right, families, seed, detail=detail, **ms))
        facts = None
    return rows


def _detail(replies: Replies, name: str) -> dict[str, Any]:
    truths = [case.motion for case in replies.cases]
    right, said = replies.right(name), replies.replies[name]
    by_object = mean_by_group(right, [case.object_id for case in replies.cases])
    detail: dict[str, Any] = {
        "macro_by_object": float(np.mean(list(by_object.values()))),
        "recall": {str(motion): share for motion, share in mean_by_group(right, truths).items()},
        "unanswered": sum(reply.motion is None for reply in said),
    }
    undirected = [one for truth, one in zip(truths, said, strict=True) if truth not in DIRECTED]
    if undirected:
        detail["claims"] = {
            part.value: sum(one.claimed(part) is not None for one in undirected) / len(undirected)
            for part in CLAIMED
        }
    return detail


def claims_turned_round(
    forwards: Replies, backwards: Replies
) -> dict[str, dict[str, tuple[int, int]]]:
    """Return how many turns and slides each variant claimed, and of how many the opposite too.

    That a direction turns round with the clip speaks for a motion in it; one that a variant is
    merely inclined to claim stays as it is.

    Args:
        forwards: What was said of clips.
        backwards: What was said of the same clips in the same order, played backwards, perhaps
            asked in other words.
    """
    counts: dict[str, dict[str, tuple[int, int]]] = {}
    for name, said in forwards.replies.items():
        pairs = list(zip(said, backwards.replies[name], strict=True))
        for part in CLAIMED:
            ways = [(one.claimed(part), other.claimed(part)) for one, other in pairs]
            claimed = [(one, other) for one, other in ways if one is not None]
            turned = sum(other == reverse(one) for one, other in claimed)
            counts.setdefault(name, {})[part.value] = (len(claimed), turned)
    return counts
