"""Which of the language model's own sentences says a decision, and whether it would write it.

Of a plain question in the camera image the model is asked in a wording it was trained on; its
sentence is told where one pass over it shows that it would write just that.
"""

from __future__ import annotations

from geotlm_lm.answering.belief_of_clip import reading
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.edit import Edit
from geotlm_lm.core.labels import Motion, MotionClass
from geotlm_lm.core.twist import Component
from geotlm_lm.language.parse_answer import Slots
from geotlm_lm.query import types as t
from geotlm_lm.query.decision import Decision

EVIDENCE_QUESTION = "Which half moves which way?"

_OPEN = {
    None: "Which way is it moving?",
    "turn": "Which way is it turning?",
    "slide": "Which way is it sliding?",
}
_CLAIMED = {
    "cw": "Is it turning clockwise?",
    "ccw": "Is it turning counterclockwise?",
    "left": "Is it sliding left?",
    "right": "Is it sliding right?",
    "up": "Is it sliding up?",
    "down": "Is it sliding down?",
    "in": "Is it pressing in?",
    "out": "Is it lifting off?",
}
_KINDS = {Component.TURN: MotionClass.ROTATION, Component.SLIDE: MotionClass.SLIDE}


def own_words(bundle: Bundle, encoded: Encoded, decision: Decision) -> str | None:
    """Return the model's sentence for a decision; None where it has none, or would not write it."""
    asked = _asked(decision)
    if asked is None:
        return None
    question, slots = asked
    parse = bundle.grammar.parse
    found = [one for one in bundle.grammar.options_for(slots.kind) if parse(one) == slots]
    writes, reads = bundle.speaker.would_write, reading(encoded)
    return next((one for one in found if writes(reads, question, one)), None)


def own_evidence(bundle: Bundle, encoded: Encoded, ways: frozenset[Motion]) -> str | None:
    """Return the model's sentences of evidence that conclude one of some ways; None without any."""
    parse, options = bundle.grammar.parse, bundle.grammar.options_for("evidence")
    writes, reads = bundle.speaker.would_write, reading(encoded)
    found = (one for one in options if parse(one).direction in ways)
    return next((one for one in found if writes(reads, EVIDENCE_QUESTION, one)), None)


def _asked(decision: Decision) -> tuple[str, Slots] | None:
    """Return how the model is asked and what it has to say; None where it is not asked."""
    part, ask = decision.part, decision.part.ask
    is_plain = decision.edit == Edit() and part.subject == t.Subject() and not decision.missing
    moves = decision.movements
    is_one = len(moves) == 1 and not (moves[0].aslant or moves[0].barely or moves[0].times)
    if not is_plain or decision.denied or decision.limits or decision.happenings:
        return None
    if ask.kind == "way" and ask.of in _OPEN and (is_one or (not moves and ask.of is None)):
        motion = moves[0].way if moves else decision.rest
        return _OPEN[ask.of], Slots("direction", direction=motion)
    if ask.kind == "kind" and is_one and moves[0].component in _KINDS:
        kind = _KINDS[moves[0].component]
        return "What kind of motion is it?", Slots("class", motion_class=kind)
    if ask.kind == "claim" and len(ask.proposition.literals) == 1:
        return _claimed(decision, ask.proposition.literals[0], is_one=is_one)
    return None


def _claimed(decision: Decision, literal: t.Literal, *, is_one: bool) -> tuple[str, Slots] | None:
    if literal.denied or literal.bound is not None:
        return None
    if literal.atom == "touch":
        return "Is anything touching the gel?", Slots("contact", verdict=decision.verdict)
    if literal.atom == "move" and decision.rest is not Motion.NONE:
        return "Is it moving?", Slots("moving", verdict=decision.verdict)
    if literal.atom in _CLAIMED and is_one:
        way = decision.movements[0].way
        slots = Slots("verify", direction=way, verdict=decision.verdict)
        return _CLAIMED[literal.atom], slots
    return None
