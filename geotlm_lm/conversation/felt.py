"""What is believed of a clip, every component at once, and how probable a claim about it is.

A clip's state is the set of what holds of it: the ways of the components that count, or stillness
where none does, or that nothing touches. A claim is true of a state or not; its probability is that
of the states it is true of, so that a claim and its denial add up to 1.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import product

from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENT_OF, COMPONENTS, WAYS, Component

State = frozenset[Motion]
Claim = Callable[[State], bool]
AT_REST = frozenset({Motion.STILL, Motion.NONE})

BARELY = (0.02, 0.75)
"""Probability of counting between which a component that is asked about is told to move barely. Of
270 pairs of frames of real turns 239 are believed to count at 0.5 or more, every one the right way;
of 27 others at 0.02 or more 26 lean the true way. Of 90 real imprints without a touch and 75 held
still none counts at 0.5, and none leans one way in a turn at 0.9."""


def claim_of(motions: frozenset[Motion]) -> Claim:
    """Return the claim that names `motions`, any of which makes it true.

    A set with stillness in it is what is left where something is denied: all of the state lies
    within.
    """
    if Motion.STILL in motions:
        return lambda state: state <= motions
    return lambda state: bool(state & motions)


def subjects_of(motions: frozenset[Motion]) -> frozenset[Component]:
    """Return the components that a claim is about; none where it is about rest or contact."""
    named = frozenset(Motion) - motions if Motion.STILL in motions else motions
    found = frozenset(COMPONENT_OF[one] for one in named if one in COMPONENT_OF)
    return frozenset() if found == frozenset(COMPONENTS) else found


@dataclass(frozen=True)
class Felt:
    """The motion that is believed, as decisions read it and sentences tell it.

    Args:
        ways: Probability that a component counts and goes that way, of all eight ways.
        contact: Probability that something touches the gel.
        sizes: How far each component moves the imprint, pixels; the larger is told first.
        amounts: How far each goes, in words.
        unreadable: Components that count and whose amount the picture does not tell.
        aslant: The lesser way of a slide that goes between two; None where it hardly does.
    """

    ways: Mapping[Motion, float]
    contact: float
    sizes: Mapping[Component, float] = field(default_factory=dict)
    amounts: Mapping[Component, str] = field(default_factory=dict)
    unreadable: frozenset[Component] = frozenset()
    aslant: Motion | None = None

    def counts(self, component: Component) -> float:
        """Return the probability that a component counts."""
        return min(sum(self.ways.get(way, 0.0) for way in WAYS[component]), 1.0)

    def way(self, component: Component) -> Motion:
        """Return the likeliest way of a component, given that it counts."""
        return max(WAYS[component], key=lambda way: self.ways.get(way, 0.0))

    def share(self, component: Component) -> float:
        """Return how probable that way is, given that the component counts."""
        return self.ways.get(self.way(component), 0.0) / max(self.counts(component), 1e-12)

    def said(self, component: Component) -> float:
        """Return how probable what is said of a component is; a slide may go between two ways."""
        own = self.ways.get(self.way(component), 0.0)
        if component is not Component.SLIDE or self.aslant is None:
            return own
        return own + self.ways.get(self.aslant, 0.0)

    def is_barely(self, component: Component) -> bool:
        """Tell whether it is doubtful that a component counts."""
        low, high = BARELY
        return low <= self.counts(component) < high

    @property
    def components(self) -> tuple[Component, ...]:
        """The components that count, the larger first."""
        counting = [one for one in COMPONENTS if self.counts(one) >= 0.5]
        return tuple(sorted(counting, key=lambda one: -self.sizes.get(one, 0.0)))

    @property
    def state(self) -> State:
        """What is told: the likeliest of each component."""
        if self._touching < 0.5:
            return frozenset({Motion.NONE})
        return frozenset(map(self.way, self.components)) or frozenset({Motion.STILL})

    @property
    def main(self) -> Motion:
        """The larger motion that counts; stillness or absence where none does."""
        return self.way(self.components[0]) if self.components else next(iter(self.state))

    @property
    def words(self) -> dict[str, float]:
        """Probability of each motion by its word; several may hold at once."""
        found = {way.value: self.ways.get(way, 0.0) for ways in WAYS.values() for way in ways}
        rest = {one.value: self.probability(claim_of(frozenset({one}))) for one in AT_REST}
        return found | rest

    def probability(self, claim: Claim) -> float:
        """Return how probable a claim is."""
        return min(sum(share for state, share in self.states() if claim(state)), 1.0)

    def states(self) -> Iterator[tuple[State, float]]:
        """Yield every state and its probability; they sum to 1."""
        touching = self._touching
        yield frozenset({Motion.NONE}), 1.0 - touching
        if touching <= 0:
            return
        parts = []
        for component in COMPONENTS:
            odds = [(way, self.ways.get(way, 0.0) / touching) for way in WAYS[component]]
            parts.append([*odds, (None, max(1.0 - sum(odd for _, odd in odds), 0.0))])
        for chosen in product(*parts):
            share = touching
            for _, odd in chosen:
                share *= odd
            state = frozenset(way for way, _ in chosen if way is not None)
            yield state or frozenset({Motion.STILL}), share

    def seen(self, rename: Callable[[Motion], Motion]) -> Felt:
        """Return what is believed with each motion named as `rename` does, one to one."""
        ways = {rename(way): share for way, share in self.ways.items()}
        return replace(self, ways=ways, aslant=self.aslant and rename(self.aslant))

    def only(self, component: Component) -> Felt:
        """Return what is believed of one component alone, the others taken not to count."""
        ways = {way: share for way, share in self.ways.items() if way in WAYS[component]}
        return replace(self, ways=ways)

    @property
    def _touching(self) -> float:
        return min(max(self.contact, *map(self.counts, COMPONENTS)), 1.0)
