"""Results about two or more clips, computed from the answer about each clip."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from geotlm_lm.answering.abstention import LEAST_SURE, tentative_text
from geotlm_lm.answering.amounts import Amount
from geotlm_lm.answering.answer import Answer
from geotlm_lm.conversation.felt import Felt
from geotlm_lm.conversation.motion_answers import asked_components
from geotlm_lm.conversation.motion_claims import presumed_class
from geotlm_lm.conversation.wording import direction_clause, frame_phrase, motion_phrase
from geotlm_lm.core.labels import DIRECTED, Motion, MotionClass, motion_class, reverse
from geotlm_lm.core.twist import COMPONENT_OF

Relation = Literal["same", "opposite", "different", "first", "second", "similar", "unknown"]

SIMILAR = 0.2
"""Amounts that differ by at most this share of the greater count as similar: a fifth, as in their
tolerance."""

_MORE = ("further", "farther", "more", "larger", "furthest", "farthest", "largest")
_LESS = ("less", "smaller", "smallest")
_FASTER = ("faster", "quicker", "fastest", "quickest")
_SLOWER = ("slower", "slowest")

_ROUGHLY = re.compile(r"\bmore or less\b(?!.*\bthan\b)")
"""Asks for no amount: "more or less the same way", but not "more or less than the other"."""


@dataclass(frozen=True)
class Comparison:
    """How two clips relate.

    Args:
        text: The sentence.
        relation: Of their directions (same, opposite, different), or which one is asked for;
            unknown where there is none.
        confidence: Probability of the relation of directions; of amounts, that both are right
            within their tolerance; of one clip's own answer, that of the answer. In [0, 1]; 0 when
            withheld.
        abstained: Whether the model declines to say.
        first: Which way the first clip goes.
        second: Which way the second one goes.
        decided: The word a program reads: "yes" or "no" where that is asked, "first", "second",
            "both" or "neither" where it is asked which, else what relates them; None when nothing
            was decided.
    """

    text: str
    relation: Relation
    confidence: float
    abstained: bool
    first: Answer
    second: Answer
    decided: str | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values."""
        return {
            "text": self.text,
            "relation": self.relation,
            "decided": self.decided,
            "confidence": round(self.confidence, 4),
            "abstained": self.abstained,
            "first": self.first.to_dict(),
            "second": self.second.to_dict(),
        }


@dataclass(frozen=True)
class Order:
    """The motions of several clips, in the order of time.

    Args:
        text: The sentence.
        motions: One per clip, as the frame tells it; empty when withheld.
        confidence: Probability that all of them are right, in [0, 1]; 0 when withheld.
        abstained: Whether the model declines to say.
        answers: The answer about each clip.
    """

    text: str
    motions: tuple[Motion, ...]
    confidence: float
    abstained: bool
    answers: tuple[Answer, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values."""
        return {
            "text": self.text,
            "motions": [motion.value for motion in self.motions],
            "confidence": round(self.confidence, 4),
            "abstained": self.abstained,
            "answers": [answer.to_dict() for answer in self.answers],
        }


def asks_amount(question: str) -> bool:
    """Tell whether a comparison asks which goes further or faster, not which way."""
    return bool({*_MORE, *_LESS, *_FASTER, *_SLOWER} & _words(question))


def compare_directions(first: Answer, second: Answer) -> Comparison:
    """Compare two answers to an open question, told in the same frame.

    Two answers may each be sure enough to be told and their relation not.
    """

    def told(text: str, relation: Relation, confidence: float) -> Comparison:
        if confidence < LEAST_SURE:
            return Comparison(tentative_text(text, confidence), "unknown", 0.0, True, first, second)
        return Comparison(text, relation, confidence, False, first, second, relation)

    if (unsure := why_not_comparable((first, second))) is not None:
        return Comparison(unsure, "unknown", 0.0, True, first, second)
    frame, one, other = first.frame, first.direction, second.direction
    pairs = pair_probabilities((first, second))
    same = sum(p for (a, b), p in pairs.items() if a == b)
    opposite = sum(p for (a, b), p in pairs.items() if a != b and a in DIRECTED and b == reverse(a))
    if one == other:
        return told(f"The same: of both clips, {direction_clause(one, frame)}.", "same", same)
    both = both_directions((first, second))
    if one in DIRECTED and other == reverse(one):
        return told(f"Opposite: {both}", "opposite", opposite)
    rest = max(0.0, 1.0 - same - opposite)
    return told(f"Different: {both}", "different", rest)


def compare_amounts(
    question: str,
    found: Sequence[Amount | None],
    seconds: Sequence[float | None],
    answers: Sequence[Answer],
    *,
    is_same_size: bool = True,
    is_speed: bool = False,
) -> Comparison:
    """Tell which of two clips goes further, or faster, by the likeliest amount of each.

    Told however unsure the amounts are, as they are themselves.

    Args:
        question: Holds the word that says which one is asked for.
        found: How far each goes; None where it goes no way.
        seconds: Time of each clip; None where it is unknown.
        answers: Which way each goes.
        is_same_size: Whether their frames have the same size: a pixel of one is else not one of
            the other.
        is_speed: Whether speeds are compared, whatever the question's words.
    """

    def refuse(text: str) -> Comparison:
        return Comparison(text, "unknown", 0.0, True, *answers)

    if (unsure := why_not_comparable(answers)) is not None:
        return refuse(unsure)
    if (verb := _unmet_presumption(question, answers)) is not None:
        return refuse(f"Neither {verb}: {both_directions(answers)}")
    if any(one is None for one in found):
        return refuse("I cannot compare them: not both of them turn or slide.")
    if found[0].unit != found[1].unit:
        return refuse("I cannot compare them: they move in different ways.")
    if found[0].unit != "deg" and not is_same_size:
        return refuse("I cannot compare how far they slide: their frames differ in size.")
    amounts, unit = [one.value for one in found], found[0].unit
    if is_speed or {*_FASTER, *_SLOWER} & _words(question):
        if not all(seconds):
            return refuse("I cannot tell which is faster: not both clips have a frame rate.")
        amounts = [amount / time for amount, time in zip(amounts, seconds, strict=True)]
        unit = f"{unit}/s"
    confidence = found[0].probability * found[1].probability
    sizes = f"about {amounts[0]:.3g} and {amounts[1]:.3g} {unit}"
    if abs(amounts[0] - amounts[1]) <= SIMILAR * max(amounts):
        text = f"Neither: they are similar, {sizes}."
        return Comparison(text, "similar", confidence, False, *answers, "similar")
    is_first = (amounts[0] > amounts[1]) != bool({*_LESS, *_SLOWER} & _words(question))
    which: Relation = "first" if is_first else "second"
    return Comparison(f"The {which}: {sizes}.", which, confidence, False, *answers, which)


def of_one_component(answer: Answer, felt: Felt, question: str) -> Answer:
    """Return an open answer as one motion alone: of the component that a question is about.

    Where it asks of none the larger motion is compared. Its options then exclude each other.

    Args:
        answer: To the open question.
        felt: What is believed, as the answer's frame names it.
        question: About two clips.
    """
    if answer.direction is None:
        return answer
    asked = [one for one in asked_components(question) if one in felt.components]
    main = felt.way(asked[0]) if asked else felt.main
    only = felt if main not in COMPONENT_OF else felt.only(COMPONENT_OF[main])
    total = sum(only.words.values())
    options = {word: share / total for word, share in only.words.items()}
    return replace(answer, direction=main, options=options)


def answer_about_one(which: int, answer: Answer, answers: Sequence[Answer]) -> Comparison:
    """Word the answer about one of two clips, 0 or 1.

    Args:
        which: The clip that is asked about.
        answer: The answer about it.
        answers: Which way each goes.
    """
    asked: Relation = ("first", "second")[which]
    relation = "unknown" if answer.abstained else asked
    text = f"Of the {asked}: {answer.text}"
    return Comparison(text, relation, answer.confidence, answer.abstained, *answers, answer.decided)


def answer_about_each(told: Sequence[Answer], answers: Sequence[Answer]) -> Comparison:
    """Word an answer about each of two clips.

    Args:
        told: The answers about them.
        answers: Which way each goes.
    """
    text = f"Of the first: {told[0].text} Of the second: {told[1].text}"
    confidence = told[0].confidence * told[1].confidence
    return Comparison(text, "unknown", confidence, any(one.abstained for one in told), *answers)


def order_of_motions(answers: Sequence[Answer]) -> Order:
    """Name the motions of several clips one after another, from the answers about each."""
    if (unsure := _withheld(answers)) is not None:
        text = f"I cannot tell the order; of clip {unsure[0] + 1}: {unsure[1].text}"
        return Order(text, (), 0.0, True, tuple(answers))
    motions = tuple(answer.direction for answer in answers)
    told = ", then ".join(_going(motion) for motion in motions)
    where = f", {frame_phrase(answers[0].frame)}" if set(motions) & set(DIRECTED) else ""
    confidence = 1.0
    for answer in answers:
        confidence *= answer.confidence
    text = f"First {told}{where}."
    if confidence < LEAST_SURE:
        return Order(tentative_text(text, confidence), (), 0.0, True, tuple(answers))
    return Order(text, motions, confidence, False, tuple(answers))


def pair_probabilities(answers: Sequence[Answer]) -> dict[tuple[Motion, Motion], float]:
    """Return the probability of each pair of motions, of two clips."""
    one, other = (answer.options.items() for answer in answers)
    return {(Motion(a), Motion(b)): p * q for a, p in one for b, q in other}


def why_not_comparable(answers: Sequence[Answer]) -> str | None:
    """Return why two clips cannot be compared, where the motion of one is withheld; else None."""
    unsure = _withheld(answers)
    which = unsure and ("first", "second")[unsure[0]]
    return unsure and f"I cannot compare them; of the {which}: {unsure[1].text}"


def _withheld(answers: Sequence[Answer]) -> tuple[int, Answer] | None:
    """Return the first answer that names no motion, and its place."""
    return next(((i, a) for i, a in enumerate(answers) if a.direction is None), None)


def _unmet_presumption(question: str, answers: Sequence[Answer]) -> str | None:
    """Return the verb of the motion that a question takes for granted and neither clip shows."""
    presumed = presumed_class(question)
    if presumed is None or any(motion_class(one.direction) is presumed for one in answers):
        return None
    return "turns" if presumed is MotionClass.ROTATION else "slides"


def both_directions(answers: Sequence[Answer], beginning: str = "") -> str:
    """Word the direction of each: "the first is going left, the second pressing in.".

    Args:
        answers: About each clip.
        beginning: The clip that was named just before, "first" or "second", which comes first.
    """
    motions = [answer.direction for answer in answers]
    where = f", {frame_phrase(answers[0].frame)}" if set(motions) & set(DIRECTED) else ""
    one, other = map(_going, motions)
    if one == other:
        return f"both are {one}{where}."
    if beginning == "second":
        return f"it is {other}, the first {one}{where}."
    return f"{'it' if beginning else 'the first'} is {one}, the second {other}{where}."


def _going(motion: Motion) -> str:
    return f"going {motion_phrase(motion)}" if motion in DIRECTED else motion_phrase(motion)


def _words(question: str) -> set[str]:
    """Return the words of a question, without a "more or less" that only means "roughly"."""
    text = _ROUGHLY.sub(" ", question.lower())
    return set(text.replace("?", " ").replace(",", " ").replace(".", " ").split())
