"""Bounds on amounts: what a bounded literal is measured by, and whether an amount meets it."""

from __future__ import annotations

from collections.abc import Callable

from geotlm_lm.core.tolerance import RELATIVE_TOLERANCE, TOLERANCES
from geotlm_lm.query.amounts import BASES, OF_ATOM, Missing, atom_of
from geotlm_lm.query.quantities import Quantity, sharing_units
from geotlm_lm.query.types import Literal


def measured(said: Literal) -> str:
    """Return what a literal with a bound is measured by: a name of `OF_ATOM`.

    Raises:
        Missing: If it has no amount.
    """
    atom = said.atom
    if atom == "move":
        ends = [one for one in (said.bound.low, said.bound.high) if one is not None]
        atom = atom_of(sharing_units(ends)[-1].unit)
    if atom not in OF_ATOM:
        raise Missing("unit")
    return OF_ATOM[atom][0]


def meets(said: Literal, amount: float, in_base: Callable[[Quantity], float]) -> bool:
    """Tell whether an amount is as a literal's bound says.

    Args:
        said: The literal; an amount that goes its way counts as positive.
        amount: Signed, in the base unit of what the literal is measured by.
        in_base: Converts what is said to that unit.
    """
    bound, sign = said.bound, OF_ATOM.get(said.atom, ("", 0))[1]
    ends = sharing_units([end for end in (bound.low, bound.high) if end is not None])
    low, high = sorted((in_base(ends[0]), in_base(ends[-1])))
    # "-20 degrees" goes against the way that is positive: what it denies is the sign.
    amount = amount * sign if sign else amount if low < 0 else abs(amount)
    if bound.relation in ("less", "more"):
        return amount < high if bound.relation == "less" else amount > low
    far = max(TOLERANCES[BASES[measured(said)]], RELATIVE_TOLERANCE * abs(low))
    far = far if bound.relation == "about" else 0.0
    return low - far <= amount <= high + far
