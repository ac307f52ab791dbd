"""Variants side by side on the same clips: rows of shares, times, and how far off these could be.

Knows no model: a variant is anything that names a motion for a clip. Clips of one object hang
together, so objects are resampled as wholes; a reply of None is wrong, never left out.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.benchmarks.harness import Row
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import DIRECTED, Motion
from geotlm_lm.core.numbers import Labels, group_codes, mean_by_group
from geotlm_lm.core.twist import COMPONENT_OF, Component

DRAWS = 4000
"""Bootstrap resamples; a 2.5 % quantile then has a relative error of its rank of about 10 %."""

NORMAL_95 = 1.959963984540054
"""97.5 % quantile of the normal distribution."""

NEAR = 0.005
"""Share of right answers up to which what is held against a rival is not below it; at least the
share of one clip."""

CLAIMED = (Component.TURN, Component.SLIDE)
"""Components with a direction in the image plane: where there is none, none may be claimed."""


@dataclass(frozen=True)
class Case:
    """A clip (None once it has been asked about), its true motion and how far that goes.

    `family` names the objects that are resampled as a whole. Afterwards it can be selected by
    `tags`, e.g. played="backwards".
    """

    clip: Clip | None
    motion: Motion
    family: str
    tags: Mapping[str, str] = field(default_factory=dict)
    amount: float | None = None  # degrees, or pixels of the clip's own frames


@dataclass(frozen=True)
class Reply:
    """The motion that a variant names, or None, and its time from the clip in memory to it.

    `claims` is every way it says that a turn or a slide goes; None for that of `motion` alone.
    """

    motion: Motion | None
    milliseconds: float
    claims: tuple[Motion, ...] | None = None
    weights: Mapping[str, float] = field(default_factory=dict)  # of what it was fused from

    def claims_a(self, component: Component) -> bool:
        """Whether it says that a component moves."""
        ways = (self.motion,) if self.claims is None else self.claims
        return any(COMPONENT_OF.get(way) is component for way in ways)

    def is_wrong_way(self, truth: Motion) -> bool:
        """Whether it names the component that moves, and another way of it."""
        component = COMPONENT_OF.get(truth)
        return COMPONENT_OF.get(self.motion, "") is component and self.motion != truth


Variant = Callable[[Clip, tuple[Motion, ...]], Reply]
"""Takes a clip and the motions in question; a free-spoken variant may name another."""


@dataclass(frozen=True, eq=False)
class Replies:
    """The same cases, their clips no longer kept, and the replies of each variant to them."""

    cases: list[Case]
    replies: dict[str, list[Reply]]

    def where(self, **tags: str) -> Replies:
        """Return the replies to the cases that carry all of `tags`."""
        kept = [i for i, case in enumerate(self.cases) if tags.items() <= dict(case.tags).items()]
        return Replies(
            [self.cases[i] for i in kept],
            {name: [own[i] for i in kept] for name, own in self.replies.items()},
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
    """Put every case to every variant; clips are read one at a time and not kept."""
    asked = Replies([], {name: [] for name in variants})
    for done, case in enumerate(cases, start=1):
        for name, variant in variants.items():
            asked.replies[name].append(variant(case.clip, tuple(among)))
        asked.cases.append(replace(case, clip=None))
        progress(done)
    return asked


def rows_of_replies(
    title: str,
    replies: Replies,
    held: str = "",
    rivals: Sequence[str] = (),
    *,
    seed: int = 0,
    facts: Mapping[str, Any] | None = None,
) -> list[Row]:
    """Return one row per variant: its error, its times, and how one compares with its rivals.

    `held` is held against the better of its `rivals`; `facts` about the cases go into the first
    row's detail. Without a case there is no row.
    """
    rows, families = [], [case.family for case in replies.cases]
    for name in replies.replies if replies.cases else ():
        right, detail = replies.right(name), _detail(replies, name) | dict(facts or {})
        others = {rival: replies.right(rival) for rival in rivals if rival in replies.replies}
        if name == held and others:
            better = max(others, key=lambda rival: others[rival].mean())
            gain = paired_difference(right, others[better], families, seed=seed)
            detail["rival"] = {
                "name": better,
                "is_below": is_below(gain["difference"], len(right)),
            } | gain
        ms = milliseconds([reply.milliseconds for reply in replies.replies[name]])
        rows.append(share_row(title, name, right, families, seed, detail=detail, **ms))
        facts = None
    return rows


def is_below(difference: float, count: int) -> bool:
    """Tell whether a share of so many clips lies below another by more than is near."""
    return difference < -max(NEAR, 1 / count) - 1e-9


def _detail(replies: Replies, name: str) -> dict[str, Any]:
    truths = [case.motion for case in replies.cases]
    right, own = replies.right(name), replies.replies[name]
    detail: dict[str, Any] = {
        "recall": {str(motion): share for motion, share in mean_by_group(right, truths).items()},
        "wrong_way": sum(map(Reply.is_wrong_way, own, truths)) / len(own),
    }
    if own[0].weights:
        names = own[0].weights
        detail["weights"] = {n: float(np.mean([r.weights[n] for r in own])) for n in names}
    undirected = [r for truth, r in zip(truths, own, strict=True) if truth not in DIRECTED]
    if undirected:
        detail["claims"] = {
            part.value: sum(reply.claims_a(part) for reply in undirected) / len(undirected)
            for part in CLAIMED
        }
    return detail


def share_row(
    case: str,
    variant: str,
    right: Sequence[bool] | NDArray[np.bool_],
    families: Labels,
    seed: int = 0,
    **fields: Any,
) -> Row:
    """Return a row of the share of wrong answers and its 95 % interval.

    `families` says, per answer, what is resampled as a whole; `fields` are further ones of the row.
    """
    right = np.asarray(right)
    low, high = clustered_interval(right, families, seed=seed)
    error, interval = 1 - float(right.mean()), (1 - high, 1 - low)
    return Row(case, variant, len(right), error, interval=interval, **fields)


Graded = tuple[str, str, bool, str]
"""Case, variant, whether its answer is right, and the family that is resampled as a whole."""


def share_rows(graded: Iterable[Graded], seed: int) -> list[Row]:
    """Return the shares of wrong answers by case and variant, in order of appearance."""
    answers: dict[tuple[str, str], list[tuple[bool, str]]] = {}
    for case, variant, is_right, family in graded:
        answers.setdefault((case, variant), []).append((is_right, family))
    return [share_row(*key, *zip(*own, strict=True), seed) for key, own in answers.items()]


def clustered_interval(
    values: NDArray[Any], objects: Labels, *, seed: int = 0
) -> tuple[float, float]:
    """Return the 95 % interval of an accuracy, resampling whole objects.

    Resampling cannot show doubt where objects agree, and not at all with one object; the interval
    is therefore never narrower, at either end, than Wilson's for as many independent clips.
    """
    values = np.asarray(values, dtype=float)
    low, high = np.quantile(_resampled_means(values, objects, seed), [0.025, 0.975])
    share, count, z2 = float(values.mean()), len(values), NORMAL_95**2
    centre = (share + z2 / (2 * count)) / (1 + z2 / count)
    half = NORMAL_95 / (1 + z2 / count)
    half *= np.sqrt(share * (1 - share) / count + z2 / (4 * count**2))
    wilson_low, wilson_high = max(float(centre - half), 0.0), min(float(centre + half), 1.0)
    return min(float(low), wilson_low), max(float(high), wilson_high)


def paired_difference(
    first: NDArray[Any], second: NDArray[Any], objects: Labels, *, seed: int = 0
) -> dict[str, float]:
    """Return the difference of two accuracies with its 95 % interval, objects kept whole."""
    gain = np.asarray(first, dtype=float) - np.asarray(second, dtype=float)
    if len(set(objects)) == 1:  # a single object says nothing of others
        return {"difference": float(gain.mean()), "low": -1.0, "high": 1.0}
    low, high = np.quantile(_resampled_means(gain, objects, seed), [0.025, 0.975])
    return {"difference": float(gain.mean()), "low": float(low), "high": float(high)}


def milliseconds(values: Sequence[float]) -> dict[str, float]:
    """Return the median and the 95th percentile, by the names of a row's fields."""
    return {"ms_p50": float(np.median(values)), "ms_p95": float(np.quantile(values, 0.95))}


def _resampled_means(values: NDArray[Any], objects: Labels, seed: int) -> NDArray[np.float64]:
    codes, names = group_codes(objects)
    sums = np.bincount(codes, weights=values, minlength=len(names))
    sizes = np.bincount(codes, minlength=len(names))
    chance = np.full(len(names), 1 / len(names))
    counts = np.random.default_rng(seed).multinomial(len(names), chance, size=DRAWS)
    return (counts @ sums) / (counts @ sizes)
