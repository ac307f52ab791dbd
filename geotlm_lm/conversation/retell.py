"""The motion a model felt, in the camera image -> what the question asked for, in its frame.

Why rules: seen from the other side, told for the sensor, mirrored, played backwards, undone and
tightened are exact functions of the motion in the camera image and of the frame. A network could
only learn them approximately, would need the frame in its prompt, and every new fact would double
its questions. So the model says two things, which sort of question this is and which motion it
felt, both in one closed sentence ("Mirror image of: left in the camera image."), and what is told
is derived here. The same rules serve a model that was trained on open questions alone: whoever asks
it supplies the sort of question.

A yes or no depends on the frame through the claim in the question. In the camera image the model's
own verdict stands unless it denies the motion told with it; in any other frame the claim is read
from the question by rule, and where that fails the direction is told without a verdict.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from geotlm_lm.conversation.claims import claimed, offered_options
from geotlm_lm.conversation.doubts import doubted
from geotlm_lm.conversation.wording import KIND_SENTENCES, clause, level, name, place, sentence
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import (
    DIRECTED,
    ROTATIONS,
    SLIDES,
    Motion,
    mirror,
    motion_class,
    reverse,
)

CAMERA = FrameSpec()


@dataclass(frozen=True)
class Felt:
    """What is known when a question is to be answered by rule.

    Args:
        kind: The sort of question.
        motion: What the model felt, in the camera image.
        question: As it was asked, without facts about the frame.
        frame: In which to answer.
        probabilities: Of every motion, in the camera image.
        verdict: What the model itself said of a claim; None where it was not asked.
    """

    kind: str
    motion: Motion
    question: str
    frame: FrameSpec
    probabilities: Mapping[Motion, float]
    verdict: bool | None = None


@dataclass(frozen=True)
class Told:
    """What is answered.

    Args:
        text: One sentence.
        direction: The motion it claims, in `frame`; None if it claims none.
        frame: The frame of reference it is told in.
        options: Probability of each possible answer, by its deciding word.
        decided: The deciding word of this one.
        is_refusal: Whether it declines to say.
    """

    text: str
    direction: Motion | None
    frame: FrameSpec
    options: dict[str, float]
    decided: str
    is_refusal: bool = False


def retell(felt: Felt) -> Told:
    """Return the answer to `felt.question` that follows from the motion and the frame.

    Raises:
        KeyError: If no rule answers this kind of question.
    """
    return _RULES[felt.kind](felt)


def _directed(
    felt: Felt, frame: FrameSpec, text: Callable[[Motion], str], change: Callable = lambda m: m
) -> Told:
    """Return an answer that names one motion: `change` of the felt one, as `frame` tells it."""

    def tell(motion: Motion) -> Motion:
        return frame.tell(change(motion))

    told = tell(felt.motion)
    options: dict[str, float] = {}
    for motion, probability in felt.probabilities.items():
        word = tell(motion).value
        options[word] = options.get(word, 0.0) + probability
    return Told(text(told), told, frame, options, told.value)


def _open(felt: Felt) -> Told:
    return _directed(felt, felt.frame, lambda told: sentence(told, felt.frame))


def _viewpoint(felt: Felt) -> Told:
    frame = replace(felt.frame, viewpoint="object")
    return _directed(felt, frame, lambda told: sentence(told, frame))


def _actor(felt: Felt) -> Told:
    frame = replace(felt.frame, actor="sensor")
    return _directed(felt, frame, lambda told: sentence(told, frame))


def _mirrored(felt: Felt) -> Told:
    def text(told: Motion) -> str:
        return f"{sentence(told, felt.frame)[:-1]}, if the clip is mirrored."

    return _directed(felt, felt.frame, text, mirror)


def _reversed(felt: Felt) -> Told:
    def text(told: Motion) -> str:
        return f"{sentence(told, felt.frame)[:-1]}, played backwards."

    return _directed(felt, felt.frame, text, reverse)


def _undo(felt: Felt) -> Told:
    def text(told: Motion) -> str:
        if told in (Motion.STILL, Motion.NONE):
            return f"There is nothing to undo: {clause(told, felt.frame)}."
        if told not in DIRECTED:
            return f"{name(told).capitalize()} undoes it."
        who = "Moving the sensor" if felt.frame.actor == "sensor" else "Moving"
        return f"{who} {told.value} undoes it, {place(felt.frame)}."

    return _directed(felt, felt.frame, text, reverse)


_MISSING = {
    "contact_side": "which side touches the gel (head, shank or side)",
    "thread": "whether the thread is right-hand or left-hand",
}
_WOULD = re.compile(
    r"\b(?:what|which|how)\b(?:.*\b(?:would|will|must|should|do (?:i|you|we)|can i)\b.*|.*\bto"
    r"| (?:way|direction|turn|motion|rotation)) \b(tight|loos|unscrew)"
)


def _thread(felt: Felt) -> Told:
    frame = felt.frame
    wanted = _WOULD.search(felt.question.lower())
    if not wanted and felt.motion not in (*ROTATIONS, *SLIDES):
        return _neither(felt, clause(felt.motion, frame))
    if frame.contact_side == "side":
        return _no_thread(felt, "gripped at its side, a turn shows as a slide")
    if not wanted and felt.motion in SLIDES:
        return _neither(felt, clause(frame.tell(felt.motion), frame))
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
        text = f"{told.value.capitalize()} {verb} it, {place(seen)}."
        return Told(text, told, seen, {verb: 1.0}, verb)
    tightens = bool(seen.tightens(felt.motion))
    options = {
        word: sum(felt.probabilities.get(m, 0.0) for m in ROTATIONS if seen.tightens(m) == is_tight)
        for word, is_tight in (("tightens", True), ("loosens", False))
    }
    verb = "tightens" if tightens else "loosens"
    told = seen.tell(felt.motion)
    facts = f"{frame.thread}-hand thread touched at its {frame.contact_side}"
    return Told(f"It {verb}: {told.value} {place(seen)}, {facts}.", told, seen, options, verb)


def _neither(felt: Felt, reason: str) -> Told:
    share = sum(p for motion, p in felt.probabilities.items() if motion not in ROTATIONS)
    share = 1.0 if felt.frame.actor == "sensor" else share
    text = f"Neither tighter nor looser: {reason}."
    told = felt.frame.tell(felt.motion)
    return Told(text, told, felt.frame, {"neither": share}, "neither")


def _no_thread(felt: Felt, reason: str) -> Told:
    text = f"I cannot tell tightening from loosening: {reason}."
    return Told(text, None, felt.frame, {}, "unknown", is_refusal=True)


VERDICTS = {
    "verify": ("Yes, {}.", "No, {}.", "yes", "no"),
    "negation": ("It is: {}.", "It is not: {}.", "it is", "it is not"),
    "premise": ("That holds: {}.", "But no, {}.", "it holds", "it does not"),
}
"""Kinds that say yes or no to a claim and tell the motion with it -> the sentence where it goes as
the question says, denied or not, where it does not, and their deciding words."""


def _judged(felt: Felt) -> Told:
    """Compare the claim in the question with the motion, both in the frame."""
    frame = felt.frame
    claims = claimed(felt.question)
    if claims is None and felt.verdict is not None and felt.verdict != (felt.kind == "negation"):
        claims = {felt.motion}  # the model found the claim true of the camera image
    if claims is None:
        return _open(felt)
    true = [motion for motion in Motion if frame.tell(motion) in claims]
    return _verdict(felt, felt.motion in true, true)


def _verdict(felt: Felt, is_true: bool, claims: Sequence[Motion]) -> Told:
    """Return yes or no and the motion; `claims` are those, in the image, of which yes is true."""
    yes, no, *words = VERDICTS[felt.kind]
    told = felt.frame.tell(felt.motion)
    share = sum(felt.probabilities.get(motion, 0.0) for motion in claims)
    text = (yes if is_true else no).format(clause(told, felt.frame))
    options = {words[0]: share, words[1]: 1.0 - share}
    return Told(text, told, felt.frame, options, words[0] if is_true else words[1])


def _choice(felt: Felt) -> Told:
    frame = felt.frame
    offered = offered_options(felt.question)
    told = frame.tell(felt.motion)
    shares = {m: 0.0 for m in offered.values()}
    for motion, probability in felt.probabilities.items():
        if frame.tell(motion) in shares:
            shares[frame.tell(motion)] += probability
    # Of letters that offer one motion the first stands for all: they are one answer.
    letters = {motion: letter for letter, motion in reversed(offered.items())}
    letter, total = letters.get(told), sum(shares.values())
    if letter is None or not total:
        return _open(felt)
    options = {f"{letters[m]}) {m.value}": share / total for m, share in shares.items()}
    text = f"{sentence(told, frame)[:-1]}, option {letter}."
    return Told(text, told, frame, options, f"{letter}) {told.value}")


def _class(felt: Felt) -> Told:
    shares: dict[str, float] = {}
    for motion, probability in felt.probabilities.items():
        word = motion_class(motion).value
        shares[word] = shares.get(word, 0.0) + probability
    kind = motion_class(felt.motion)
    return Told(KIND_SENTENCES[kind], None, felt.frame, shares, kind.value)


def _confidence(felt: Felt) -> Told:
    told = felt.frame.tell(felt.motion)
    claims = doubted(felt.question)
    if claims is not None:
        is_true = told in claims
        shares = felt.probabilities.items()
        share = min(sum(odds for motion, odds in shares if felt.frame.tell(motion) in claims), 1.0)
        text = f"The probability of that is {share:.0%}: {clause(told, felt.frame)}."
        options = {"yes": share, "no": 1.0 - share}
        return Told(text, told, felt.frame, options, "yes" if is_true else "no")
    share = felt.probabilities.get(felt.motion, 0.0)
    text = f"My confidence is {level(share)}: {share:.0%} that {clause(told, felt.frame)}."
    return _directed(felt, felt.frame, lambda _: text)


_RULES: dict[str, Callable[[Felt], Told]] = {
    "direction": _open,
    "verify": _judged,
    "choice": _choice,
    "class": _class,
    "negation": _judged,
    "premise": _judged,
    "viewpoint": _viewpoint,
    "actor": _actor,
    "thread": _thread,
    "mirrored": _mirrored,
    "reversed": _reversed,
    "undo": _undo,
    "confidence": _confidence,
}

RETOLD = frozenset(_RULES)
"""Kinds whose answer the rules can derive from a motion."""

ALWAYS_RETOLD = RETOLD - {"direction", "verify", "choice", "class", "negation", "premise"}
"""Kinds the rules derive even in the camera image; of the others the model's own words stand."""
