"""What a query asks of two clips: how they differ, and of which something is so."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from statistics import NormalDist

from geotlm_lm.core.edit import MIRRORED, opposite
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from geotlm_lm.query import types as t
from geotlm_lm.query.amounts import Measure, Missing, Recording
from geotlm_lm.query.decision import Decision, Evidence

Decide = Callable[[t.Part, Evidence, FrameSpec], Decision]

_NAMES = {
    "same": lambda motion: motion,
    "different": lambda motion: motion,
    "opposite": opposite,
    "mirrored": MIRRORED.of_way,
}


def decide_on_two(part: t.Part, evidence: Evidence, frame: FrameSpec, decide: Decide) -> Decision:
    """Return what a part on two clips is answered by.

    Args:
        part: The part.
        evidence: Of both.
        frame: In which the recordings' facts hold.
        decide: Answers a part on one clip.

    Raises:
        Missing: If something is compared that cannot be.
    """
    if evidence.second is None:
        raise Missing("second")

    def each_of(asked: t.Ask) -> tuple[Decision, Decision]:
        return _each(replace(part, ask=asked), evidence, frame, decide)

    if part.ask.kind == "compare":
        is_amount = part.ask.of == "amount" or part.ask.relation in _OF_AMOUNTS
        if not is_amount:
            return _compared(part, frame, part.ask, each_of)
        recordings = (evidence.recording, evidence.second.recording)
        return _compared_amounts(part, frame, recordings, each_of)
    is_which = part.ask.kind == "which-clip"
    ask = t.Ask("claim", part.ask.proposition) if is_which else part.ask
    first, second = each = each_of(ask)
    both = Decision(part, frame, amounts=first.amounts + second.amounts, each=each)
    sure = min(first.probability, second.probability)
    if is_which:
        so = tuple(at for at, one in enumerate(each) if one.verdict)
        return replace(both, verdict=None, options=so, probability=sure)
    if first.verdict is None or second.verdict is None:
        return replace(both, probability=sure)
    count = first.verdict + second.verdict
    verdict = {"both": count == 2, "each": count == 2, "either": count > 0}
    verdict |= {"neither": count == 0, "only-one": count == 1}
    return replace(both, verdict=verdict[part.subject.clip], probability=sure)


def _each(
    part: t.Part, evidence: Evidence, frame: FrameSpec, decide: Decide
) -> tuple[Decision, Decision]:
    plain = replace(part, subject=replace(part.subject, clip=None))
    clips = (replace(evidence, second=None), evidence.second)
    first, second = (replace(decide(plain, one, frame), recording=one.recording) for one in clips)
    for one in (first, second):
        if one.missing is not None:
            raise Missing(one.missing)
    return first, second


_OF_AMOUNTS = ("more", "less", "which-more", "which-less")
EachOf = Callable[[t.Ask], tuple[Decision, Decision]]


def _compared(part: t.Part, frame: FrameSpec, ask: t.Ask, each_of: EachOf) -> Decision:
    asked = t.Ask("way", of=ask.of if ask.of in t.COMPONENT_ATOMS else None)
    each = each_of(asked)
    motions = [_motion(one) for one in each]
    sure = min(one.probability for one in each)
    if ask.relation is None:
        return Decision(part, frame, probability=sure, each=each)
    expected = _NAMES[ask.relation](motions[0])
    # What rests is no opposite of itself.
    is_so = motions[1] == expected and (ask.relation != "opposite" or motions[0] != expected)
    if ask.of == "kind":
        is_so = _kinds(each[0]) == _kinds(each[1])
    verdict = is_so != (ask.relation == "different")
    return Decision(part, frame, verdict=verdict, probability=sure, each=each)


def _compared_amounts(
    part: t.Part, frame: FrameSpec, recordings: tuple[Recording, Recording], each_of: EachOf
) -> Decision:
    ask = part.ask
    of = ask.of if ask.of in t.COMPONENT_ATOMS else None
    asked = t.Ask("amount", of=of, per="per-s" if ask.is_speed else None)
    each = each_of(asked)
    sure = min(one.probability for one in each)
    if of is not None and not all(one.amounts for one in each):
        # What does not go a way at all goes less far than what does.
        goes = [bool(one.amounts) for one in each]
        return _which_goes(part, frame, each, goes, sure)
    if any(not one.amounts for one in each) or len({one.amounts[0].unit for one in each}) > 1:
        raise Missing("comparable")
    amounts = tuple(one.amounts[0] for one in each)
    sizes = {(one.rows, one.columns) for one in recordings}
    if len(sizes) > 1 and amounts[0].unit.startswith("px"):
        raise Missing("comparable")
    farther = _chances_farther(*amounts)
    alike = abs(amounts[0].mean - amounts[1].mean) <= max(one.tolerance for one in amounts)
    is_first = amounts[0].mean > amounts[1].mean
    goes = [not alike and is_first, not alike and not is_first]
    goes_at_all = min(move.chance for one in each for move in one.movements)
    sure = goes_at_all * (1 - sum(farther) if alike else farther[goes.index(True)])
    return replace(_which_goes(part, frame, each, goes, sure), amounts=amounts)


def _chances_farther(first: Measure, second: Measure) -> tuple[float, float]:
    """Return the probability of each amount being the larger by more than the tolerance."""
    spread = max(math.hypot(first.deviation, second.deviation), 1e-9)
    bell = NormalDist(first.mean - second.mean, spread)
    tolerance = max(first.tolerance, second.tolerance)
    return 1 - bell.cdf(tolerance), bell.cdf(-tolerance)


def _which_goes(
    part: t.Part, frame: FrameSpec, each: tuple[Decision, Decision], goes: list[bool], sure: float
) -> Decision:
    """Return what a comparison of amounts comes to; `goes` tells which clip goes farther."""
    first, second = goes
    relation, alike = part.ask.relation, first == second
    farther = () if alike else (int(second),)
    found: dict[str, object] = {}
    if relation in ("which-more", "which-less"):
        less = tuple(1 - at for at in farther)
        found = {"options": farther if relation == "which-more" else less}
    elif relation in ("more", "less"):
        found = {"verdict": not alike and first == (relation == "more")}
    elif relation is not None:
        found = {"verdict": alike == (relation == "same")}
    return Decision(part, frame, probability=sure, each=each, **found)


def _motion(decision: Decision) -> Motion:
    return decision.movements[0].way if decision.movements else decision.rest or Motion.STILL


def _kinds(decision: Decision) -> set[object]:
    return {one.component for one in decision.movements} or {decision.rest}
