"""What follows from a query and what is believed: decisions, exact and without words.

Total: every well-formed, filled query gets a decision for each of its parts; what cannot be told
carries the reason instead.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from statistics import NormalDist

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENT_OF, COMPONENTS, WAYS, Component
from geotlm_lm.query import types as t
from geotlm_lm.query.amounts import OF_ATOM, Missing, bell, component_of
from geotlm_lm.query.bounds import timed_as
from geotlm_lm.query.decision import ContactArea, Decision, Evidence, Movement
from geotlm_lm.query.facts import with_facts
from geotlm_lm.query.happenings import Happening
from geotlm_lm.query.paths import peak
from geotlm_lm.query.scene import Scene
from geotlm_lm.query.track import part_of
from geotlm_lm.query.two_clips import decide_on_two
from geotlm_lm.track.events import TOGETHER_S, EventKind


def execute(query: t.Query, evidence: Evidence, frame: FrameSpec) -> tuple[Decision, ...]:
    """Return what each part of a query is answered by.

    Args:
        query: Filled: its slots hold quantities.
        evidence: What is believed.
        frame: What held before; the query's own facts are added.
    """
    try:
        frame = with_facts(frame, query.facts, evidence.recording.columns)
    except UsageError:  # no camera has such pixels
        return tuple(Decision(part, frame, missing="pixel") for part in query.parts)
    evidence = evidence.at_rate(frame.rate_hz)
    return tuple(decide(part, evidence, frame) for part in query.parts)


def decide(part: t.Part, evidence: Evidence, frame: FrameSpec) -> Decision:
    """Return what one part is answered by."""
    if part.ask.kind in _UNTOUCHED:  # the same of either clip
        return Decision(replace(part, subject=replace(part.subject, clip=None)), frame)
    try:
        if part.ask.kind in ("compare", "which-clip") or part.subject.clip in t.OF_SEVERAL:
            return decide_on_two(part, evidence, frame, decide)
        return _of_one(part, _evidence_of(part.subject, evidence), frame)
    except Missing as lacks:
        return Decision(part, frame, missing=str(lacks))


def _evidence_of(subject: t.Subject, evidence: Evidence) -> Evidence:
    if subject.half is not None:
        raise Missing("half")
    if subject.clip == "second" or (subject.clip == "previous" and evidence.second is not None):
        if evidence.second is None:
            raise Missing("second")
        evidence = evidence.second
    if subject.span is None:
        return evidence
    part, belief = part_of(evidence.track, evidence.belief, subject.span, evidence.recording)
    return replace(evidence, belief=belief, track=part)


def _of_one(part: t.Part, evidence: Evidence, frame: FrameSpec) -> Decision:
    kind = part.ask.kind
    if kind == "recording":
        return Decision(part, frame, recording=evidence.recording)
    scene = Scene(part, evidence, frame)
    if kind in ("when", "how-long", "how-often", "order"):
        return _timed(scene, part.ask)
    return _DECIDES[kind](scene, part.ask)


_UNTOUCHED = ("setup", "help", "talk", "unanswerable", "not-understood", "again")
"""Answered by the frame or by nothing; "again" is resolved before."""


def _timed(scene: Scene, ask: t.Ask) -> Decision:
    if ask == t.Ask("order") and scene.track is None:  # "what happens?" of a clip
        way = t.Ask("way")
        return replace(_way(scene, way), part=replace(scene.part, ask=way))
    found = scene.timed(ask)
    return scene.decision(
        verdict=found.verdict,
        happenings=found.happenings,
        times=found.times,
        probability=found.probability,
    )


def _way(scene: Scene, ask: t.Ask) -> Decision:
    if ask.of == "thread":
        turn = t.COMPONENT_ATOMS["turn"]
        if scene.belief.moves(turn) < 0.5 and scene.frame.contact_side != "side":
            return scene.decision(**scene.telling((turn,)))  # neither tightens nor loosens
        options = tuple(t.Option(t.Proposition((t.Literal(one),))) for one in t.THREAD_ATOMS)
        return _choice(scene, t.Ask("choice", options=options))
    if ask.of in _AXIS_WAYS:
        return scene.decision(**_along(scene, ask.of))
    of = "turn" if ask.of == "sign" else ask.of
    asked = () if of is None else (t.COMPONENT_ATOMS[of],)
    story = _story(scene) if ask.of is None else ()
    return scene.decision(**scene.telling(asked), happenings=story)


def _story(scene: Scene) -> tuple[Happening, ...]:
    """Return the events of a recording with motions one after another: its sum alone hides them."""
    if scene.track is None or scene.edit.undo:
        return ()
    found = scene.timed(t.Ask("order")).happenings
    moving = [one for one in found if one.kind in (EventKind.TURN, EventKind.SLIDE)]
    is_over = min((one.end_s for one in moving), default=0.0) - TOGETHER_S
    return found if any(one.begin_s >= is_over for one in moving) else ()


def _along(scene: Scene, axis: str) -> dict[str, object]:
    """Return what is told of a slide's part along one axis of the image."""
    slide = t.COMPONENT_ATOMS["slide"]
    found = scene.telling((slide,))
    if found.get("rest") or slide in found["denied"]:
        return found
    moving = scene.judge.chance(t.Proposition((t.Literal(axis),)))
    if moving < 0.5:
        return found | {"still_axis": axis, "probability": min(found["probability"], 1 - moving)}
    part = scene.amount(axis)
    mean, deviation = bell(scene.belief, axis)
    way = _AXIS_WAYS[axis][mean > 0]
    sure = NormalDist(abs(mean), max(deviation, 1e-6))
    chance = scene.belief.moves(slide) * (1 - sure.cdf(0.0))
    move = Movement(way, None, part, chance, barely=False)
    return found | {"movements": (move,), "probability": chance}


_AXIS_WAYS = {"x": (Motion.LEFT, Motion.RIGHT), "y": (Motion.UP, Motion.DOWN)}


def _kind(scene: Scene, _: t.Ask) -> Decision:
    return scene.decision(**scene.telling())


def _claim(scene: Scene, ask: t.Ask) -> Decision:
    scene.require_visible(ask.proposition)
    chance = scene.judge.chance(ask.proposition)
    verdict = chance >= 0.5
    found = scene.telling(_subjects(ask.proposition))
    amounts = []
    for literal in ask.proposition.literals:
        is_amount = literal.bound is not None and timed_as(literal) is None
        if is_amount and literal.atom in t.COMPONENT_ATOMS | t.WAY_ATOMS.keys():
            amounts.append(scene.amount(literal.atom))
    probability = max(chance, 1 - chance)
    found |= {"verdict": verdict, "amounts": tuple(amounts), "probability": probability}
    return scene.decision(**scene.with_counts(found, ask))


def _subjects(proposition: t.Proposition) -> tuple[Component, ...]:
    named = set()
    for literal in proposition.literals:
        atom = literal.atom
        if atom in t.WAY_ATOMS:
            named.add(COMPONENT_OF[t.WAY_ATOMS[atom]])
        elif atom in t.COMPONENT_ATOMS:
            named.add(t.COMPONENT_ATOMS[atom])
        elif atom in ("x", "y"):
            named.add(Component.SLIDE)
        elif atom in t.THREAD_ATOMS:
            named.add(Component.TURN)
    return tuple(one for one in COMPONENTS if one in named)


def _choice(scene: Scene, ask: t.Ask) -> Decision:
    whole = t.OTHER_ATOMS
    named = [one for one in ask.options if one.proposition.literals[0].atom not in whole]
    *sums, none = scene.judge.chances([one.proposition for one in named])
    shares = dict(zip(map(id, named), sums, strict=True))
    rest = {"other": none, "unknown": 0.0}
    chances = tuple(
        shares[id(one)] if id(one) in shares else rest[one.proposition.literals[0].atom]
        for one in ask.options
    )
    subjects = {one for option in named for one in _subjects(option.proposition)}
    found = scene.telling([one for one in COMPONENTS if one in subjects])
    order = sorted(range(len(chances)), key=lambda at: -chances[at])
    if ask.denied:
        out = tuple(at for at in order if chances[at] < 0.5)
        probability = min((1 - chances[at] for at in out), default=0.0)
    else:
        out = tuple(at for at in order if chances[at] >= 0.5) or tuple(order[:1])
        out = () if chances[out[0]] < 0.5 and none >= 0.5 else out
        probability = min((chances[at] for at in out), default=none)
    found |= {"options": out, "chances": chances, "probability": probability}
    return scene.decision(**scene.with_counts(found, ask))


def _amount(scene: Scene, ask: t.Ask) -> Decision:
    if ask.of == "touch":
        return _share(scene)
    if ask.measure is not None:
        return _extreme(scene, ask)
    atoms = {None: [], "xy": ["x", "y"]}.get(ask.of, [ask.of])
    subjects = _subjects(t.Proposition(tuple(t.Literal(one) for one in atoms or ["move"])))
    is_axis = ask.of in _AXIS_WAYS
    found = _along(scene, ask.of) if is_axis else scene.telling(subjects)
    counting = [one.component for one in found.get("movements", ())]
    if not atoms:
        atoms = [one.value for one in counting] or ([] if ask.unit is None else ["turn"])
        atoms = [one for one in atoms if _fits(one, ask.unit)] or atoms[:1]
        found["denied"] = ()
    elif found["denied"]:
        return scene.decision(**found)
    unseen = [one for one in counting if not scene.belief.readable[one]]
    if unseen and len(unseen) == len(counting):
        raise Missing("unreadable")
    amounts = tuple(scene.amount(one, ask.unit, ask.per) for one in atoms)
    sure = min([found["probability"], *(one.probability for one in amounts)])
    return scene.decision(**found | {"amounts": amounts, "probability": sure})


def _share(scene: Scene) -> Decision:
    area = scene.area()
    if area is None:
        raise Missing("share")
    return scene.decision(area=area, probability=scene.belief.contact)


def _extreme(scene: Scene, ask: t.Ask) -> Decision:
    """Tell a whole way, there and back, or the greatest way or speed."""
    subjects = _subjects(t.Proposition((t.Literal(ask.of or "move"),)))
    found = scene.telling(subjects)
    if not found.get("movements") or found["denied"]:
        return scene.decision(**found)
    atom = ask.of if ask.of in OF_ATOM else found["movements"][0].component.value
    if ask.measure == "path":
        if scene.track is None:
            return _amount(scene, replace(ask, measure=None))
        far, times = scene.track.path(component_of(OF_ATOM[atom][0])), ()
        amount = scene.as_told(atom, far.mean, far.deviation, unit=ask.unit)
    else:
        mean, deviation, *times = peak(scene.track, scene.edit, atom, is_speed=ask.per is not None)
        if mean <= 0:
            return scene.decision(**found)  # it never goes that way
        unit_s = scene.recording.unit_s(ask.per) if ask.per else 1.0
        amount = scene.as_told(atom, mean * unit_s, deviation * unit_s, unit=ask.unit)
        per = f"/{ask.per.removeprefix('per-')}" if ask.per else ""
        amount = replace(amount, unit=amount.unit + per)
    found["probability"] = min(found["probability"], amount.probability)
    return scene.decision(**found | {"amounts": (amount,), "times": tuple(times)})


def _fits(atom: str, unit: str | None) -> bool:
    return unit is None or (unit in t.UNITS["angle"]) == (atom == "turn")


def _how_sure(scene: Scene, ask: t.Ask) -> Decision:
    found = scene.telling()
    if ask.proposition is None:
        return scene.decision(**found)
    chance = scene.judge.chance(ask.proposition)
    return scene.decision(**found | {"chances": (chance,), "probability": chance})


def _alternatives(scene: Scene, _: t.Ask) -> Decision:
    found = scene.telling()
    ways = [way for ways in WAYS.values() for way in ways]
    chances = tuple(scene.belief.ways[way] for way in ways)
    return scene.decision(**found | {"chances": chances})


def _why(scene: Scene, ask: t.Ask) -> Decision:
    found = scene.telling(_subjects(ask.proposition) if ask.proposition else ())
    return scene.decision(**found, reasons=scene.evidence.reasons)


def _place(scene: Scene, ask: t.Ask) -> Decision:
    area = scene.area()
    if area is None:
        raise Missing("place")
    verdict = None if ask.half is None else _lies_in(area, ask.half)
    return scene.decision(area=area, verdict=verdict, probability=scene.belief.contact)


def _lies_in(area: ContactArea, half: str) -> bool:
    return {
        "upper": area.down < 0.5,
        "lower": area.down > 0.5,
        "left": area.across < 0.5,
        "right": area.across > 0.5,
    }[half]


_DECIDES: dict[str, Callable[[Scene, t.Ask], Decision]] = {
    "way": _way,
    "kind": _kind,
    "claim": _claim,
    "choice": _choice,
    "amount": _amount,
    "how-sure": _how_sure,
    "alternatives": _alternatives,
    "why": _why,
    "place": _place,
}
