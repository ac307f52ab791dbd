"""Derive whether a thread tightens or loosens, and which turn would do either."""

from __future__ import annotations

from dataclasses import replace

from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.rule_answers import RuleAnswer, RuleInput
from geotlm_lm.conversation.wording import direction_clause, frame_phrase
from geotlm_lm.core.labels import ROTATIONS, SLIDES

_PHRASES = Phrases("thread_answers")
_MISSING = {
    "contact_side": "which side touches the gel (head, shank or side)",
    "thread": "whether the thread is right-hand or left-hand",
}
_WOULD = _PHRASES.pattern("WOULD")


def thread_answer(felt: RuleInput) -> RuleAnswer:
    """Answer whether a thread tightens, or which turn would tighten it; name missing facts."""
    frame = felt.frame
    wanted = _WOULD.search(felt.question.lower())
    if not wanted and felt.motion not in (*ROTATIONS, *SLIDES):
        return _neither(felt, direction_clause(felt.motion, frame))
    if frame.contact_side == "side":
        return _no_thread(felt, "gripped at its side, a turn shows as a slide")
    if not wanted and felt.motion in SLIDES:
        return _neither(felt, direction_clause(frame.tell(felt.motion), frame))
    if not wanted and frame.actor == "sensor":
        return _neither(felt, "the sensor moved, not the object")
    missing = " and ".join(_MISSING[fact] for fact in frame.missing_for_thread())
    if missing:
        return _no_thread(felt, f"tell me {missing}")
    seen = replace(frame, actor="object")
    if wanted:
        tightens = wanted[1] == "tight"
        turn = next(motion for motion in ROTATIONS if seen.tightens(motion) == tightens)
        told = seen.tell(turn)
        verb = "tightens" if tightens else "loosens"
        text = f"{told.value.capitalize()} {verb} it, {frame_phrase(seen)}."
        return RuleAnswer(text, told, seen, {verb: 1.0}, verb)
    tightens = bool(seen.tightens(felt.motion))
    options = {
        word: sum(felt.probabilities.get(m, 0.0) for m in ROTATIONS if seen.tightens(m) == is_tight)
        for word, is_tight in (("tightens", True), ("loosens", False))
    }
    verb = "tightens" if tightens else "loosens"
    told = seen.tell(felt.motion)
    facts = f"{frame.thread}-hand thread touched at its {frame.contact_side}"
    return RuleAnswer(
        f"It {verb}: {told.value} {frame_phrase(seen)}, {facts}.", told, seen, options, verb
    )


def _neither(felt: RuleInput, reason: str) -> RuleAnswer:
    share = sum(p for motion, p in felt.probabilities.items() if motion not in ROTATIONS)
    share = 1.0 if felt.frame.actor == "sensor" else share
    text = f"Neither tighter nor looser: {reason}."
    told = felt.frame.tell(felt.motion)
    return RuleAnswer(text, told, felt.frame, {"neither": share}, "neither")


def _no_thread(felt: RuleInput, reason: str) -> RuleAnswer:
    text = f"I cannot tell tightening from loosening: {reason}."
    return RuleAnswer(text, None, felt.frame, {}, "unknown", is_refusal=True)
