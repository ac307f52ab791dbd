"""What is believed, seen from the point of view of one part of a query."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import SLIDES, Motion, reverse
from geotlm_lm.core.twist import COMPONENTS, Component
from geotlm_lm.query import types as t
from geotlm_lm.query.amounts import Measure, Missing, limit, measure
from geotlm_lm.query.chance import Judge
from geotlm_lm.query.decision import Decision, Evidence, Movement
from geotlm_lm.query.quantities import Quantity

ASLANT = 0.4
"""Share of a slide's lesser travel in its greater from which on both ways are told."""

BARELY = (0.05, 0.75)
"""Chance of counting between which a component that is asked about is told to move barely."""


class Scene:
    """What is believed, seen from the point of view of one part."""

    def __init__(self, part: t.Part, evidence: Evidence, frame: FrameSpec) -> None:
        self.part, self.frame = part, frame
        self.edit = part.edit.within(frame)
        self.belief = self.edit.of_belief(evidence.belief)
        is_turned = self.edit.rotation[0] == 0  # columns are rows then
        sides = (evidence.recording.rows, evidence.recording.columns)
        columns, rows = sides if is_turned else sides[::-1]
        self.recording = replace(evidence.recording, columns=columns, rows=rows)
        self.judge = Judge(self.belief, self._limit, self._tightens)

    def _limit(self, name: str, said: Quantity) -> float:
        return limit(name, said, self.frame, self.recording, self.belief)

    def _tightens(self, told: Motion) -> bool:
        lacking = self.frame.missing_for_thread()
        if lacking or self.frame.contact_side == "side":
            raise Missing("thread" if lacking else "side")
        # A mirror that is only supposed would make another thread; who looks from where does not.
        supposed = replace(self.part.edit, behind=False, sensor=False)
        supposed = replace(supposed, rotation=self.part.edit.image)
        recorded = self.edit.inverse().of_way(told)
        return bool(self.frame.tightens(supposed.of_way(recorded)))

    def decision(self, **found: object) -> Decision:
        """Return a decision on this part."""
        return Decision(self.part, self.frame, **found)

    def movement(self, component: Component) -> Movement:
        """Return a component as it is told."""
        belief, way = self.belief, self.belief.way(component)
        low, high = BARELY
        return Movement(
            way,
            self._aslant(way) if component is Component.SLIDE else None,
            self.amount(component.value) if belief.readable[component] else None,
            belief.ways[way],
            low <= belief.counts(component) < high,
        )

    def amount(self, atom: str) -> Measure:
        """Return how far something goes, in its usual unit."""
        return measure(atom, self.belief, self.frame, self.recording)

    def _aslant(self, way: Motion) -> Motion | None:
        main = abs(self.belief.mean.along(way) or 0.0)
        other = max((one for one in SLIDES if one not in (way, reverse(way))), key=self._along)
        return other if main > 0 and ASLANT * main <= self._along(other) else None

    def _along(self, way: Motion) -> float:
        return self.belief.mean.along(way) or 0.0

    def telling(self, asked: Sequence[Component] = ()) -> dict[str, object]:
        """Return what counts of what is asked, what of it does not, and what is so instead."""
        belief = self.belief
        touching = max(belief.contact, *map(belief.counts, COMPONENTS))
        if touching < 0.5:
            return {"rest": Motion.NONE, "denied": tuple(asked), "probability": 1 - touching}
        counting = belief.by_size()
        told = [one for one in counting if one in asked] if asked else counting
        denied = tuple(one for one in asked if one not in counting)
        moves = tuple(self.movement(one) for one in (told or counting))
        sure = [1 - belief.counts(one) for one in denied] + [one.chance for one in moves]
        if not moves:
            rest = self.judge.chance(t.Proposition((t.Literal("still"),)))
            return {"rest": Motion.STILL, "denied": denied, "probability": rest}
        return {"movements": moves, "denied": denied, "probability": min(sure)}
