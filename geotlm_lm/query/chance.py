"""How probable a proposition is: of the states of a belief, of those that it is true of.

So it and its denial add up to 1, and a claim, a choice and an open question agree.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise, product
from statistics import NormalDist

from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENT_OF, COMPONENTS, WAYS
from geotlm_lm.motion.belief import Belief
from geotlm_lm.query.amounts import OF_ATOM, Missing, bell
from geotlm_lm.query.bounds import is_of_recording, measured, meets
from geotlm_lm.query.quantities import Quantity
from geotlm_lm.query.types import COMPONENT_ATOMS, WAY_ATOMS, Literal, Proposition

_COMPONENT = {"turn": "turn", "inward": "press"}
"""Component of what is measured; of all else the slide."""

QUANTILES, LEAST_QUANTILES = 81, 3
"""Steps in which the bells of all bounded amounts are taken together, and of each at least: of one
amount, chances beside its bound are right within 0.007."""

Limit = Callable[[str, Quantity], float]
"""(what is measured, what is said) -> the same in its base unit."""

Thread = Callable[[Motion], bool]
"""Whether a way of turning, as it is told, tightens."""

Happens = Callable[[Literal], tuple[float, bool, bool]]
"""Of what only a recording shows: a probability, whether it is so that probably, and otherwise."""


@dataclass(frozen=True)
class State:
    """One way it may be.

    Args:
        ways: Of the components that move.
        touches: Whether something does.
        amounts: Signed amounts that a proposition bounds, by name, in their base unit.
        events: Whether what only a recording shows is so, denied or not.
    """

    ways: frozenset[Motion]
    touches: bool
    amounts: Mapping[str, float] = field(default_factory=dict)
    events: Mapping[Literal, bool] = field(default_factory=dict)


@dataclass(frozen=True)
class Judge:
    """Tells the chance of propositions.

    Args:
        belief: As it is seen from the point of view asked about.
        limit: Converts what is said.
        tightens: Tells tightening; raises `Missing` where facts lack.
        happens: Tells how probable events are; raises `Missing` of a clip.
        aslant: Both ways of a slide that is told by two: each of them is so where either is.
    """

    belief: Belief
    limit: Limit
    tightens: Thread
    happens: Happens
    aslant: frozenset[Motion] = frozenset()

    def chance(self, proposition: Proposition) -> float:
        """Return how probable a proposition is.

        Raises:
            Missing: If it needs a fact that nobody told, or a whole recording.
        """
        return self.chances([proposition])[0]

    def chances(self, propositions: list[Proposition]) -> list[float]:
        """Return how probable each is, and as a last one that none of them is."""
        said = [each for one in propositions for each in one.literals]
        shown = {replace(one, denied=False) for one in said if is_of_recording(one)}
        bounded = {
            measured(one) for one in said if one.bound is not None and not is_of_recording(one)
        }
        branches = list(self._events(shown))
        sums = [0.0] * (len(propositions) + 1)
        for (state, share), (events, odds) in product(self._states(sorted(bounded)), branches):
            found = [self._holds(one, replace(state, events=events)) for one in propositions]
            for at, holds in enumerate([*found, not any(found)]):
                sums[at] += share * odds * holds
        return [min(one, 1.0) for one in sums]

    def _holds(self, proposition: Proposition, state: State) -> bool:
        found = [self._is(one, state) != one.denied for one in proposition.literals]
        return all(found) if proposition.joint == "and" else any(found)

    def _is(self, literal: Literal, state: State) -> bool:
        atom, ways = literal.atom, state.ways
        if is_of_recording(literal):
            key = replace(literal, denied=False)
            if key not in state.events and atom == "lost":
                return self._is_lost(state)
            return state.events.get(key, state.touches)
        if literal.bound is not None:
            return self._within(literal, state)
        if atom in WAY_ATOMS:
            return WAY_ATOMS[atom] in ways
        if atom in COMPONENT_ATOMS:
            return any(COMPONENT_OF[way] is COMPONENT_ATOMS[atom] for way in ways)
        if atom in ("tighten", "loosen"):
            turns = [way for way in ways if way in WAYS[COMPONENT_ATOMS["turn"]]]
            tightens = [self.tightens(way) for way in WAYS[COMPONENT_ATOMS["turn"]]]
            wanted = dict(zip(WAYS[COMPONENT_ATOMS["turn"]], tightens, strict=True))
            return any(wanted[way] == (atom == "tighten") for way in turns)
        return {
            "move": bool(ways),
            "still": state.touches and not ways,
            "touch": state.touches,
            "none": not state.touches,
            "x": bool(ways & {Motion.LEFT, Motion.RIGHT}),
            "y": bool(ways & {Motion.UP, Motion.DOWN}),
        }[atom]

    def _is_lost(self, state: State) -> bool:
        if self.belief.ways[Motion.RELEASE] >= 0.5:  # it lifts off: whether for good is seen later
            raise Missing("track")
        return not state.touches

    def _within(self, literal: Literal, state: State) -> bool:
        name, way = measured(literal), WAY_ATOMS.get(literal.atom)
        amount = state.amounts[name]
        # What goes the other way goes this way by no amount, not even by less than another.
        if way is not None and (way not in state.ways or amount * OF_ATOM[literal.atom][1] < 0):
            return False
        component = _COMPONENT.get(name, "slide")
        moves = any(COMPONENT_OF[one].value == component for one in state.ways)
        # What does not move goes no half degree either, however small that is.
        if not moves and literal.bound.relation != "less":
            return False
        return meets(literal, amount, partial(self.limit, name))

    def _events(self, shown: set[Literal]) -> Iterator[tuple[dict[Literal, bool], float]]:
        """Yield which of some things are so, and how probable that is.

        What is less probable happens only with what is more so: the same events show both.
        """
        found = {}
        for one in shown:
            try:
                found[one] = self.happens(one)
            except Missing:  # one clip shows as much of contact
                if one.bound is not None or one.atom not in ("made", "lost"):
                    raise
        for low, high in pairwise(sorted({0.0, 1.0, *(chance for chance, _, _ in found.values())})):
            yield (
                {
                    one: so if chance > low else otherwise
                    for one, (chance, so, otherwise) in found.items()
                },
                high - low,
            )

    def _states(self, bounded: list[str]) -> Iterator[tuple[State, float]]:
        """Yield every state and its probability; they sum to 1."""
        belief = self.belief
        touching = min(max(belief.contact, *map(belief.moves, COMPONENTS)), 1.0)
        if not belief.is_contact_known:
            touching = 1.0
        yield State(frozenset(), False, dict.fromkeys(bounded, 0.0)), 1.0 - touching
        if touching <= 0:
            return
        parts = []
        for component in COMPONENTS:
            odds = [(way, belief.ways[way] / touching) for way in WAYS[component]]
            parts.append([*odds, (None, max(1.0 - sum(odd for _, odd in odds), 0.0))])
        count = max(round(QUANTILES ** (1 / max(len(bounded), 1))), LEAST_QUANTILES)
        bells = [
            [(name, one) for one in _quantiles(*bell(belief, name), count)] for name in bounded
        ]
        for chosen in product(*parts):
            share = touching
            for _, odd in chosen:
                share *= odd
            if share <= 0:
                continue
            ways = frozenset(way for way, _ in chosen if way is not None)
            ways |= self.aslant if ways & self.aslant else frozenset()
            for amounts in product(*bells):
                yield State(ways, True, dict(amounts)), share / count ** len(bounded)


def _quantiles(mean: float, deviation: float, count: int) -> list[float]:
    curve = NormalDist(mean, max(deviation, 1e-9))
    return [curve.inv_cdf((k + 0.5) / count) for k in range(count)]
