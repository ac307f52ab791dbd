"""Derive whether a thread tightens or loosens, and which turn would do either."""

from __future__ import annotations

from dataclasses import replace

from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.rule_answers import RuleAnswer, RuleInput
from geotlm_lm.conversation.telling import tell
from geotlm_lm.conversation.wording import frame_phrase
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import ROTATIONS
from geotlm_lm.core.twist import Component

_PHRASES = Phrases("thread_answers")
_MISSING = {
    "contact_side": "which side touches the gel (head, shank or side)",
    "thread": "whether the thread is right-hand or left-hand",
}
_WOULD = _PHRASES.pattern("WOULD")


def thread_answer(asked: RuleInput) -> RuleAnswer:
    """Answer whether a thread tightens, or which turn would tighten it; name missing facts."""
    frame, felt = asked.frame, asked.felt
    wanted = _WOULD.search(asked.question.lower())
    turns, slides = (one in felt.components for one in (Component.TURN, Component.SLIDE))
    if not wanted and not turns and not slides:
        return _neither(asked)
    if frame.contact_side == "side":
        return _no_thread(asked, "gripped at its side, a turn shows as a slide")
    if not wanted and not turns:
        return _neither(asked)
    if not wanted and frame.actor == "sensor":
        return _neither(asked, "the sensor moved, not the object")
    missing = " and ".join(_MISSING[fact] for fact in frame.missing_for_thread())
    if missing:
        return _no_thread(asked, f"tell me {missing}")
    seen = replace(frame, actor="object")
    if wanted:
        return _would(seen, tightens=wanted[1] == "tight")
    turn = felt.way(Component.TURN)
    options = {
        word: sum(felt.ways.get(way, 0.0) for way in ROTATIONS if seen.tightens(way) == is_tight)
        for word, is_tight in (("tightens", True), ("loosens", False))
    }
    verb, told = "tightens" if seen.tightens(turn) else "loosens", seen.tell(turn)
    facts = f"{frame.thread}-hand thread touched at its {frame.contact_side}"
    text = f"It {verb}: {told.value} {frame_phrase(seen)}, {facts}."
    return RuleAnswer(text, told, seen, options, verb, options[verb], component=Component.TURN)


def _would(frame: FrameSpec, *, tightens: bool) -> RuleAnswer:
    """Tell which turn would tighten, or loosen, a thread."""
    told = frame.tell(next(turn for turn in ROTATIONS if frame.tightens(turn) == tightens))
    verb = "tightens" if tightens else "loosens"
    text = f"{told.value.capitalize()} {verb} it, {frame_phrase(frame)}."
    return RuleAnswer(text, told, frame, {verb: 1.0}, verb, 1.0)


def _neither(asked: RuleInput, reason: str | None = None) -> RuleAnswer:
    felt = asked.felt.seen(asked.frame.tell)
    told = tell(felt, asked.frame, (Component.TURN,))
    share = 1.0 - felt.counts(Component.TURN)
    if reason is not None:
        share, told = 1.0, replace(told, text=reason, confidence=1.0)
    text, sure = f"Neither tighter nor looser: {told.text}.", min(share, told.confidence)
    direction = felt.main if told.is_doubtful else told.direction
    return RuleAnswer(text, direction, asked.frame, {"neither": share}, "neither", sure)


def _no_thread(asked: RuleInput, reason: str) -> RuleAnswer:
    text = f"I cannot tell tightening from loosening: {reason}."
    return RuleAnswer(text, None, asked.frame, {}, "unknown", 0.0, is_refusal=True)
