"""Derive the answer to a question from what is believed of each component, in a frame.

Why rules: seen from the other side, told for the sensor, mirrored, played backwards, undone and
tightened are exact functions of the motion in the camera image and of the frame. A network could
only learn them approximately, would need the frame in its prompt, and every new fact would double
its questions. What is believed is one value per clip, so that the answers to an open question, a
claim, its denial and a choice never contradict each other.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from geotlm_lm.conversation.choice_answers import choice_answer, class_answer
from geotlm_lm.conversation.compound_claims import compound_claim
from geotlm_lm.conversation.felt import AT_REST, Claim, Felt, claim_of, subjects_of
from geotlm_lm.conversation.half_directions import Half, asked_half, claimed_half, direction_of_half
from geotlm_lm.conversation.hypothetical_changes import (
    claimed_inverse,
    claims_on_changed_clip,
    supposed_changes,
)
from geotlm_lm.conversation.likelihood_questions import likelihood_subject
from geotlm_lm.conversation.motion_claims import claimed_motions, presumed_class
from geotlm_lm.conversation.motion_names import motions_named, nearly_named
from geotlm_lm.conversation.rule_answers import RuleAnswer, RuleInput, answer_told, open_answer
from geotlm_lm.conversation.telling import Told, doing, tell
from geotlm_lm.conversation.thread_answers import thread_answer
from geotlm_lm.conversation.wording import (
    capitalised,
    confidence_level,
    direction_clause,
    frame_phrase,
)
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, Motion, MotionClass, motion_class
from geotlm_lm.core.twist import COMPONENT_OF, Component

CAMERA = FrameSpec()

_COMPONENT = {MotionClass.ROTATION: Component.TURN, MotionClass.SLIDE: Component.SLIDE}


def asked_components(question: str) -> tuple[Component, ...]:
    """Return the component whose way a question asks for; none where it asks for any."""
    presumed = presumed_class(question)
    return () if presumed is None else (_COMPONENT[presumed],)


def answer_from_motion(felt: RuleInput) -> RuleAnswer:
    """Return the answer to `felt.question` that follows from what is believed and the frame.

    Raises:
        KeyError: If no rule answers this kind of question.
    """
    return _RULES[felt.kind](felt)


def _open(asked: RuleInput) -> RuleAnswer:
    half = asked_half(asked.question) if asked.kind == "direction" else None
    felt = asked.felt.seen(asked.frame.tell)
    if half is not None and felt.main in DIRECTED:
        return _half(felt, asked.frame, half)
    return open_answer(felt, asked.frame, asked_components(asked.question))


def _half(felt: Felt, frame: FrameSpec, half: Half) -> RuleAnswer:
    """Tell which way one half goes in the larger motion."""
    only = felt.only(COMPONENT_OF[felt.main])
    options: dict[str, float] = {}
    for word, probability in only.words.items():
        way = (direction_of_half(half, Motion(word)) or Motion(word)).value
        options[way] = options.get(way, 0.0) + probability
    way = direction_of_half(half, felt.main).value
    text = f"The {half} half goes {way}, {frame_phrase(frame)}."
    return RuleAnswer(text, felt.main, frame, options, way, options[way])


def _changed(asked: RuleInput) -> RuleAnswer:
    """Tell the motion of a clip that the question supposes changed, or whose motion undoes it."""
    changes = supposed_changes(asked.question, asked.kind)
    frame, ends = changes.frame(asked.frame), changes.in_words()
    felt = asked.felt.seen(lambda motion: frame.tell(changes.of(motion)))
    is_undone = "undo" in changes.names
    told = tell(felt, frame, () if is_undone else asked_components(asked.question))
    if is_undone:
        told = replace(told, text=_undoing(felt, frame))
        claims = frozenset({claimed_inverse(asked.question)} - {None})
    else:
        claims = claims_on_changed_clip(asked.question)
        told = tell(felt, frame, subjects_of(claims)) if claims else told
    text = f"{told.text}{ends}."
    if not claims:
        return answer_told(told, capitalised(text), frame, felt.words, told.direction.value)
    return _verdict(felt, frame, told, [claim_of(claims)], ("Yes, {}", "No, {}", "yes", "no"), text)


def _undoing(felt: Felt, frame: FrameSpec) -> str:
    if not felt.components:
        return f"there is nothing to undo: {direction_clause(felt.main, frame)}"
    of = "the sensor" if frame.actor == "sensor" else ""
    text = doing(felt, felt.components, of)
    text += f"{',' * (',' in text)} undoes it"
    directed = felt.state & set(DIRECTED)
    return f"{text}, {frame_phrase(frame)}" if directed else text


VERDICTS = {
    "verify": ("Yes, {}.", "No, {}.", "yes", "no"),
    "negation": ("It is: {}.", "It is not: {}.", "it is", "it is not"),
    "premise": ("That holds: {}.", "But no, {}.", "it holds", "it does not"),
}
"""Kinds that say yes or no to a claim and tell the motion with it -> the sentence where it goes as
the question says, denied or not, where it does not, and their deciding words."""


def _judged(asked: RuleInput) -> RuleAnswer:
    """Compare the claim in the question with what is believed, both in the frame."""
    frame, is_claim = asked.frame, asked.kind == "verify"
    felt = asked.felt.seen(frame.tell)
    whole = compound_claim(asked.question) if is_claim else None
    if whole is not None:
        told = tell(felt, frame, whole.subjects)
        verdict = _verdict(felt, frame, told, [whole.holds], VERDICTS["verify"])
        if whole.is_denied:
            so = "Yes, that is so" if verdict.decided == "yes" else "No, that is not so"
            return replace(verdict, text=f"{so}: {told.text}.", is_plain=False)
        return verdict
    half = claimed_half(asked.question) if is_claim else None
    if half is not None:
        return _judged_half(felt, frame, half.half, half.motions)
    claims = claimed_motions(asked.question)
    if claims is None and asked.verdict is not None:
        claims = _heard_claim(asked, felt.main)
    if claims is None:
        return _open(asked)
    told = tell(felt, frame, subjects_of(claims))
    return _verdict(felt, frame, told, [claim_of(claims)], VERDICTS[asked.kind])


def _heard_claim(asked: RuleInput, main: Motion) -> frozenset[Motion] | None:
    """Return the claim that only the model has read, as far as its verdict tells of it."""
    if asked.motion is None:
        return None
    named = asked.frame.tell(asked.motion)
    if asked.verdict != (asked.kind == "negation"):
        return frozenset({named})
    # A "no" to words that name no motion may be one to words that the model does not know.
    is_read = motions_named(asked.question) or nearly_named(asked.question)
    is_as_seen = named == asked.motion == main
    return frozenset(Motion) - {named} if is_as_seen and is_read else None


def _judged_half(felt: Felt, frame: FrameSpec, half: Half, claims: frozenset[Motion]) -> RuleAnswer:
    only = felt.only(COMPONENT_OF[felt.main]) if felt.components else felt
    told = tell(only, frame)
    verdict = _verdict(only, frame, told, [claim_of(claims)], VERDICTS["verify"])
    way = direction_of_half(half, only.main)
    if way is None:
        return verdict
    text = f"{verdict.decided.capitalize()}, the {half} half goes {way.value}: {told.text}."
    return replace(verdict, text=text)


def _verdict(
    felt: Felt,
    frame: FrameSpec,
    told: Told,
    claims: Sequence[Claim],
    said: tuple[str, str, str, str],
    text: str | None = None,
) -> RuleAnswer:
    """Return yes or no and the motion; a "no" is as sure as the least sure thing it says.

    The way that something goes "if at all" is not what it says.
    """
    yes, no, *words = said

    def holds(state: frozenset[Motion]) -> bool:
        return all(claim(state) for claim in claims)

    is_true, share = holds(felt.state), felt.probability(holds)
    options = {words[0]: share, words[1]: 1.0 - share}
    word = words[0] if is_true else words[1]
    if told.is_doubtful:
        rest = tell(felt, frame).confidence if felt.components else 1.0
        told = replace(told, direction=felt.main, confidence=rest)
    return answer_told(
        replace(told, confidence=min(told.confidence, options[word])),
        (yes if is_true else no).format(told.text if text is None else text),
        frame,
        options,
        word,
    )


def _moving(asked: RuleInput) -> RuleAnswer:
    moves = claim_of(frozenset(Motion) - AT_REST)
    is_so, share = moves(asked.felt.state), asked.felt.probability(moves)
    untouched = Motion.NONE in asked.felt.state
    text = "No, there is no contact." if untouched else "No, it is still."
    return _yes_or_no(asked, is_so, share, "Yes, it is moving." if is_so else text)


def _contact(asked: RuleInput) -> RuleAnswer:
    touches = Motion.NONE not in asked.felt.state
    share = asked.felt.probability(lambda state: Motion.NONE not in state)
    text = "Yes, something is" if touches else "No, nothing is"
    return _yes_or_no(asked, touches, share, f"{text} touching the gel.")


def _yes_or_no(asked: RuleInput, is_so: bool, share: float, text: str) -> RuleAnswer:
    options = {"yes": share, "no": 1.0 - share}
    word = "yes" if is_so else "no"
    kind = None if is_so or asked.kind == "contact" else motion_class(asked.felt.main)
    return RuleAnswer(
        text, None, asked.frame, options, word, options[word], is_plain=True, motion_class=kind
    )


def _confidence(asked: RuleInput) -> RuleAnswer:
    frame, felt = asked.frame, asked.felt.seen(asked.frame.tell)
    claims = likelihood_subject(asked.question)
    if claims is not None:
        told = tell(felt, frame, subjects_of(claims))
        claim = claim_of(claims)
        text = f"The probability of that is {felt.probability(claim):.0%}: {told.text}."
        return _verdict(felt, frame, told, [claim], ("{}", "{}", "yes", "no"), text)
    told = tell(felt, frame)
    level = confidence_level(told.confidence)
    text = f"My confidence is {level}: {told.confidence:.0%} that {told.text}."
    return answer_told(told, text, frame, felt.words, told.direction.value)


_RULES: dict[str, Callable[[RuleInput], RuleAnswer]] = {
    "direction": _open,
    "verify": _judged,
    "choice": choice_answer,
    "class": class_answer,
    "contact": _contact,
    "moving": _moving,
    "negation": _judged,
    "premise": _judged,
    "viewpoint": _changed,
    "actor": _changed,
    "thread": thread_answer,
    "mirrored": _changed,
    "reversed": _changed,
    "undo": _changed,
    "confidence": _confidence,
}

RULE_KINDS = frozenset(_RULES)
"""Kinds whose answer the rules derive from what is believed."""

ALWAYS_RULE_KINDS = RULE_KINDS - {
    "direction",
    "verify",
    "choice",
    "class",
    "contact",
    "moving",
    "negation",
    "premise",
}
"""Kinds whose sentence is never the model's own."""
