"""What is believed, seen from the point of view of one part of a query."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from geotlm_lm.core.edit import opposite
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import SLIDES, Motion
from geotlm_lm.core.twist import COMPONENTS, Component
from geotlm_lm.query import types as t
from geotlm_lm.query.amounts import (
    OF_ATOM,
    Measure,
    Missing,
    Recording,
    bell,
    component_of,
    factor,
    limit,
    measure,
    sized,
)
from geotlm_lm.query.amounts import usual_unit as unit_of
from geotlm_lm.query.bounds import is_of_recording, judged_literals, measured, timed_as, timings
from geotlm_lm.query.chance import Judge
from geotlm_lm.query.decision import ContactArea, Decision, Evidence, Limit, Movement
from geotlm_lm.query.happenings import happens
from geotlm_lm.query.quantities import Quantity
from geotlm_lm.query.track import Timed, judged, on_track
from geotlm_lm.track.events import Event
from geotlm_lm.track.track import together_s

ASLANT = 1 / 3
"""Share of a slide's lesser travel in its greater from which on both ways are told."""

UNSURE = 0.5
"""Probability of a component's way below which it is not told beside one that is surer."""

LONGER = 1.25
"""How many times as long as the net way the whole one is where that is told as well."""


class Scene:
    """What is believed, seen from the point of view of one part."""

    def __init__(self, part: t.Part, evidence: Evidence, frame: FrameSpec) -> None:
        self.part, self.frame, self.evidence = part, frame, evidence
        self.edit = part.edit.within(frame.edit)
        self.belief = evidence.belief.seen(self.edit)
        self.track = evidence.track
        is_turned = self.edit.rotation[0] == 0  # columns are rows then
        self.recording = replace(evidence.recording, is_turned=is_turned)
        way = self.belief.way(Component.SLIDE)
        aslant = self._aslant(way)
        both = frozenset({way, aslant}) if aslant else frozenset()
        self.judge = Judge(self.belief, self.limit, self._tightens, self._happens, both)

    def limit(self, name: str, said: Quantity, lasts_s: float | None = None) -> float:
        """Return an amount that is said in the base unit of what it is compared with.

        Of a speed it is how far that goes while what moves does so, or in `lasts_s`.
        """
        recording = self.recording_of(name)
        if lasts_s is not None:
            recording = replace(recording, moving_s=lasts_s)
        return limit(name, said, self.frame, recording, self.belief)

    def recording_of(self, name: str) -> Recording:
        """Return the file with the time in which what is measured, a name of `OF_ATOM`, moves."""
        if self.track is None:
            return self.recording
        events = [one for one in self.track.of(component_of(name)) if one.begin_s < one.end_s]
        return replace(self.recording, moving_s=together_s(events) or self.track.seconds)

    def timed(self, ask: t.Ask) -> Timed:
        """Return what a recording answers to when, how long, how often or in which order.

        Raises:
            Missing: If no recording was followed, or it does not tell.
        """
        return on_track(ask, self.edit, self.track, self.sized, self.limit)

    def _counted(self, kind: str, atom: str) -> Timed:
        return self.timed(t.Ask(kind, t.Proposition((t.Literal(atom),))))

    def _happens(self, said: t.Literal) -> tuple[float, bool, bool]:
        if self.track is None:
            raise Missing("track")
        if (kind := timed_as(said)) is not None:
            return judged(said, self._counted(kind, said.atom), self.track, self.recording)
        return happens(said, self.edit, self.track, self.sized, self.limit), True, False

    def with_counts(self, found: dict[str, object], ask: t.Ask) -> dict[str, object]:
        """Return what is told with each count and duration that a claim or a choice bounds."""
        counted = [self._counted(*one) for one in timings(ask)]
        if not counted:
            return found
        sure = min(found["probability"], *(one.probability for one in counted))
        found = found | {"times": tuple(one.times[0] for one in counted), "probability": sure}
        if all(map(timed_as, judged_literals(ask))):
            # Only what is counted is told then, no sum of its motions.
            events = counted[0].happenings if len(counted) == 1 else ()
            found |= {"movements": (), "happenings": events}
        return found

    def _tightens(self, told: Motion) -> bool:
        if self.belief.moves(Component.TURN) < 0.5 and self.frame.contact_side != "side":
            return told is Motion.CLOCKWISE  # it hardly turns: neither is probable, whatever thread
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
        is_known = self.belief.is_contact_known
        return Decision(self.part, self.frame, is_contact_known=is_known, **found)

    def _goes(self, component: Component) -> float:
        """Return how probable it is that a component moves and goes the way that is told."""
        way = self.belief.way(component)
        aslant = self._aslant(way) if component is Component.SLIDE else None
        return self.belief.ways[way] + (self.belief.ways[aslant] if aslant else 0.0)

    def movement(self, component: Component) -> Movement:
        """Return a component as it is told."""
        belief, way = self.belief, self.belief.way(component)
        aslant = self._aslant(way) if component is Component.SLIDE else None
        sure = self._goes(component)
        return Movement(
            way,
            aslant,
            self.amount(component.value) if belief.readable[component] else None,
            min(sure, 1.0),
            belief.is_barely(component),
            self._times(component),
            self._back_and_forth(component),
        )

    def amount(self, atom: str, unit: str | None = None, per: str | None = None) -> Measure:
        """Return how far, or how fast, something goes; in its usual unit unless one is given."""
        recording = self.recording_of(OF_ATOM[atom][0])
        return measure(atom, self.belief, self.frame, recording, unit, per)

    def sized(self, event: Event, atom: str, unit: str | None = None) -> Measure:
        """Return how far an event goes."""
        return self.as_told(atom, abs(event.amount.mean), event.amount.deviation, event, unit)

    def as_told(
        self,
        atom: str,
        mean: float,
        deviation: float,
        event: Event | None = None,
        unit: str | None = None,
    ) -> Measure:
        """Return an amount in the base unit of an atom as it is told."""
        belief = self.belief
        if event is not None:
            belief = replace(belief, mean=self.edit.of_twist(event.twist))
        unit = unit or unit_of(atom, self.frame)
        scale = factor(OF_ATOM[atom][0], unit, self.frame, self.recording, belief)
        return sized(atom, mean, deviation, unit, scale)

    def area(self) -> ContactArea | None:
        """Return where it is touched, from this point of view."""
        area = self.evidence.area
        if area is None:
            return None
        a, b, c, d = self.edit.rotation
        x, y = area.across - 0.5, area.down - 0.5
        return ContactArea(a * x + b * y + 0.5, c * x + d * y + 0.5, area.share)

    def _times(self, component: Component) -> tuple[float, float] | None:
        events = () if self.track is None else self.track.of(component)
        events = [one for one in events if one.component is component]
        if not events:
            return None
        begin, end = min(one.begin_s for one in events), max(one.end_s for one in events)
        if self.edit.backwards:
            total = float(self.track.times_s[0] + self.track.times_s[-1])
            begin, end = total - end, total - begin
        return begin, end

    def _back_and_forth(self, component: Component) -> Measure | None:
        if self.track is None or component is Component.PRESS:
            return None
        way, net = self.track.path(component), abs(self.track.net(component).mean)
        if way.mean < LONGER * net or len(self.track.of(component)) < 2:
            return None
        return self.as_told(component.value, way.mean, way.deviation)

    def _aslant(self, way: Motion) -> Motion | None:
        main = abs(self.belief.mean.along(way) or 0.0)
        other = max((one for one in SLIDES if one not in (way, opposite(way))), key=self._along)
        return other if main > 0 and ASLANT * main <= self._along(other) else None

    def _along(self, way: Motion) -> float:
        return self.belief.mean.along(way) or 0.0

    def telling(self, asked: Sequence[Component] = ()) -> dict[str, object]:
        """Return what moves of what is asked, what of it does not, and what is so instead.

        Where nothing is asked for by name, what moves barely is left out beside what does more, and
        what goes none of its ways more probably than not beside what does.
        """
        belief = self.belief
        touching = max(belief.contact, *map(belief.moves, COMPONENTS))
        if not belief.is_contact_known:  # then nothing tells that nothing touches, nor a press
            touching, asked = 1.0, [each for each in asked if each is not Component.PRESS]
        if touching < 0.5:
            return {"rest": Motion.NONE, "denied": tuple(asked), "probability": 1 - touching}
        moving = belief.by_size()
        main = [each for each in moving if not belief.is_barely(each)] or moving
        main = [each for each in main if self._goes(each) >= UNSURE] or main
        named = [each for each in moving if each in asked] or main
        denied = tuple(each for each in asked if each not in moving)
        moves = tuple(self.movement(each) for each in named)
        sure = [1 - belief.moves(each) for each in denied] + [each.chance for each in moves]
        unmoved = {"denied": denied, "limits": self._limits(denied, is_at_rest=not moves)}
        if not moves:
            rest = self.judge.chance(t.Proposition((t.Literal("still"),)))
            return unmoved | {"rest": Motion.STILL, "probability": rest}
        return unmoved | {"movements": moves, "probability": min(sure)}

    def require_visible(self, proposition: t.Proposition) -> None:
        """Refuse bounds below the limit of what is not seen to move: it may go so far, or not.

        Raises:
            Missing: If there is such a bound.
        """
        belief, seen = self.belief, self.belief.at_limit
        for literal in proposition.literals:
            is_amount = literal.bound is not None and timed_as(literal) is None
            if not is_amount or is_of_recording(literal):
                continue
            name = measured(literal)
            component = component_of(name)
            if component not in belief.limits or belief.moves(component) >= 0.5:
                continue
            unseen = bell(seen, "slide" if component is Component.SLIDE else name)[0]
            if abs(self.limit(name, literal.bound.low)) < abs(unseen):
                raise Missing("unseen")

    def _limits(self, denied: Sequence[Component], *, is_at_rest: bool) -> tuple[Limit, ...]:
        """Return how far what does not move would have to go to be seen."""
        belief = self.belief
        if not belief.limits:
            return ()
        # What the picture does not tell, an edge's travel along itself, has no limit.
        seen, slide = belief.at_limit, Component.SLIDE
        both = [part for part in (slide, Component.TURN) if belief.readable[part]]
        denied = [part for part in denied if belief.readable[part]]
        if is_at_rest and slide not in denied and slide in both:
            # Neither turns nor slides: the larger path stands for both.
            path = max(belief.limits[part] for part in both)
            seen = replace(seen, mean=replace(seen.mean, right_px=path))
            denied = [*denied, slide]
        is_scaled = self.frame.mm_per_px is not None
        units = {each: ("px", "mm") if each is slide and is_scaled else (None,) for each in denied}
        return tuple(
            (each, tuple(measure(each.value, seen, self.frame, self.recording, u) for u in own))
            for each, own in units.items()
        )
