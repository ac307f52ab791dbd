"""Bounds on amounts, counts and durations: what a literal bounds, and what meets it."""

from __future__ import annotations

from collections.abc import Callable

from geotlm_lm.core.tolerance import RELATIVE_TOLERANCE, TOLERANCES
from geotlm_lm.query.amounts import BASES, OF_ATOM, Missing, atom_of
from geotlm_lm.query.quantities import Quantity, sharing_units
from geotlm_lm.query.types import EVENT_ATOMS, OTHER_ATOMS, UNITS, Ask, Bound, Literal
from geotlm_lm.track.events import TOGETHER_S

COUNTED_ATOMS = (*EVENT_ATOMS, "touch", "none", "still")
"""What has no amount: a number without a unit is how often it happens."""


def measured(said: Literal) -> str:
    """Return what a literal with a bound is measured by: a name of `OF_ATOM`.

    Raises:
        Missing: If it has no amount.
    """
    atom = "turn" if said.atom == "reverses" else said.atom
    if atom == "move":
        atom = atom_of(_ends(said.bound)[-1].unit)
    if atom not in OF_ATOM:
        raise Missing("unit")
    return OF_ATOM[atom][0]


def timed_as(said: Literal) -> str | None:
    """Return the ask that tells what a literal bounds: "how-often", "how-long"; else None."""
    if said.bound is None:
        return None
    unit = _ends(said.bound)[-1].unit
    if unit in UNITS["time"]:
        # "starts within 2 s" is no duration.
        return None if said.atom in ("starts", "stops") else "how-long"
    return "how-often" if not unit and said.atom in COUNTED_ATOMS else None


def timings(ask: Ask) -> list[tuple[str, str]]:
    """Return each ask and atom that tells what a claim or a choice bounds, once, in their order."""
    found = ((timed_as(one), one.atom) for one in judged_literals(ask))
    return list(dict.fromkeys(one for one in found if one[0] is not None))


def judged_literals(ask: Ask) -> list[Literal]:
    """Return what a claim or a choice is about; of another ask nothing."""
    said = [one.proposition for one in ask.options]
    said += [ask.proposition] if ask.kind == "claim" else []
    return [each for one in said for each in one.literals if each.atom not in OTHER_ATOMS]


def is_of_recording(said: Literal) -> bool:
    """Tell whether a literal is of what only a whole recording shows."""
    return said.atom in EVENT_ATOMS or timed_as(said) is not None


def meets(said: Literal, amount: float, in_base: Callable[[Quantity], float]) -> bool:
    """Tell whether an amount is as a literal's bound says.

    Args:
        said: The literal; an amount that goes its way counts as positive.
        amount: Signed, in the base unit of what the literal is measured by.
        in_base: Converts what is said to that unit.
    """
    bound, sign = said.bound, OF_ATOM.get(said.atom, ("", 0))[1]
    low, high = _in_order(bound, in_base)
    # "-20 degrees" goes against the way that is positive: what it denies is the sign.
    amount = amount * sign if sign else amount if low < 0 else abs(amount)
    far = max(TOLERANCES[BASES[measured(said)]], RELATIVE_TOLERANCE * abs(low))
    return _lies(bound.relation, amount, low, high, far)


def meets_timed(said: Literal, value: float, in_base: Callable[[Quantity], float]) -> bool:
    """Tell whether a count, exactly, or a duration, seconds, is as a literal's bound says.

    Args:
        said: Of which `timed_as` tells the ask.
        value: What is told.
        in_base: Converts what is said to a count or to seconds.
    """
    low, high = _in_order(said.bound, in_base)
    is_count = timed_as(said) == "how-often"
    far = 0.0 if is_count else max(TOGETHER_S, RELATIVE_TOLERANCE * abs(low))
    return _lies(said.bound.relation, value, low, high, far)


def _lies(relation: str, value: float, low: float, high: float, far: float) -> bool:
    if relation in ("less", "more"):
        return value < high if relation == "less" else value > low
    far = far if relation == "about" else 0.0
    return low - far <= value <= high + far


def _in_order(bound: Bound, in_base: Callable[[Quantity], float]) -> tuple[float, float]:
    ends = _ends(bound)
    low, high = sorted((in_base(ends[0]), in_base(ends[-1])))
    return low, high


def _ends(bound: Bound) -> tuple[Quantity, ...]:
    return sharing_units([end for end in (bound.low, bound.high) if end is not None])
