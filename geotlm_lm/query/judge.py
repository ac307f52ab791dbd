"""A motion that was told beside the true one, component by component, in words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from geotlm_lm.core.labels import Motion
from geotlm_lm.core.tolerance import TOLERANCES, within_tolerance
from geotlm_lm.core.twist import COMPONENTS, Component, Twist
from geotlm_lm.query.phrases import amount_phrase, joined, way_phrase
from geotlm_lm.query.values import Measure, Moved, Movement, Value

_DID = {
    Component.TURN: "turned",
    Component.SLIDE: "slid",
    Motion.PRESS: "pressed in",
    Motion.RELEASE: "lifted off",
}
_UNITS = {Component.TURN: "deg", Component.SLIDE: "px", Component.PRESS: "mm"}


@dataclass(frozen=True)
class Judgement:
    """Whether what was told of a motion is right, and what is right or wrong about it."""

    is_right: bool
    text: str


def judge_motion(
    value: Value,
    twist: Twist,
    moves: Mapping[Component, bool | None],
    is_visible: Mapping[Component, bool],
    *,
    touches: bool,
) -> Judgement:
    """Compare all that was told of a clip's motion with the truth.

    Right is what names every component that visibly moves, its way and, where one is told, its
    amount within the tolerance, and none that rests.

    Args:
        value: Answer to an open question, lengths in pixels of the 224-pixel image; one that is no
            `Moved` is withheld.
        twist: The true motion.
        moves: Whether each component moves; None where that is too little to be graded.
        is_visible: Whether the picture shows it.
        touches: Whether anything touches the gel.
    """
    if not isinstance(value, Moved):
        own, rest = {}, None
    else:
        own, rest = {move.component: move for move in value.movements}, value.rest
    if not touches:
        is_right = isinstance(value, Moved) and rest is Motion.NONE and not own
        return Judgement(is_right, f"{'correct' if is_right else 'wrong'}: nothing touched the gel")
    right, wrong, unseen = {}, ["touched the gel"] * (rest is Motion.NONE), []
    for component in COMPONENTS:
        move, true = own.get(component), true_movement(twist, component)
        did = f"{_did(true)} {amount_phrase(true.amount)}"
        if move is None and moves[component]:
            (wrong if is_visible[component] else unseen).append("also " * bool(own) + did)
        elif move is not None and moves[component] is False:
            wrong.append(f"did not {component}")
        elif move is not None and (fault := _fault(move, true)):
            wrong.append(f"{did}, not {fault}")
        elif move is not None:
            right[component] = did
    if not isinstance(value, Moved):
        return Judgement(False, f"not told: it {joined([*wrong, *unseen] or ['did not move'])}")
    if wrong:
        sound = f"correct about {joined([f'the {part}' for part in right])};" if right else "wrong:"
        return Judgement(False, f"{sound} {'; '.join(f'it {each}' for each in wrong)}")
    hidden = f"; it {joined(unseen)}, which does not show" if unseen else ""
    gone = joined([*right.values()] or ["did not move" + " visibly" * bool(unseen)])
    return Judgement(True, f"correct: it {gone}{hidden}")


def true_movement(twist: Twist, component: Component) -> Movement:
    """Return a component of a true motion as it would be told."""
    sizes = abs(twist.turn_deg), twist.slide_px, abs(twist.inward_mm)
    far, unit = dict(zip(COMPONENTS, sizes, strict=True))[component], _UNITS[component]
    amount = Measure(component.value, far, 0.0, unit, TOLERANCES[unit])
    is_slide = component is Component.SLIDE
    aslant, is_diagonal = twist.lesser_way() if is_slide else (None, False)
    way = twist.way(component)
    return Movement(way, aslant, amount, 1.0, barely=False, is_diagonal=is_diagonal)


def _did(move: Movement) -> str:
    """Return what a component did: "turned clockwise", "lifted off"."""
    if move.component is Component.PRESS:
        return _DID[move.way]
    return f"{_DID[move.component]} {way_phrase(move)}"


def _fault(move: Movement, true: Movement) -> str:
    """Return what is wrong about a movement, in the words it was told; empty if nothing is."""
    if not _goes_alike(move, true):
        return _did(move) if move.component is Component.PRESS else way_phrase(move)
    far = move.amount
    if far is None or within_tolerance(abs(far.value), true.amount.mean, far.unit):
        return ""
    return amount_phrase(far)


def _goes_alike(move: Movement, true: Movement) -> bool:
    """Tell whether two ways are one in words; between two ways neither need be the greater."""
    is_same, is_diagonal = move.way is true.way, move.is_diagonal or true.is_diagonal
    if {move.way, move.aslant} == {true.way, true.aslant}:
        return is_same or is_diagonal
    return is_same and not is_diagonal and None in (move.aslant, true.aslant)
