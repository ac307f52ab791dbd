"""Derive the answer to a question from the motion that the model perceived, in its frame.

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

from collections.abc import Callable, Sequence
from dataclasses import replace

from geotlm_lm.conversation.compound_claims import compound_claim
from geotlm_lm.conversation.half_directions import Half, asked_half, claimed_half, direction_of_half
from geotlm_lm.conversation.hypothetical_changes import (
    claimed_inverse,
    claims_on_changed_clip,
    supposed_changes,
)
from geotlm_lm.conversation.kind_choices import offered_kinds
from geotlm_lm.conversation.likelihood_questions import likelihood_subject
from geotlm_lm.conversation.motion_claims import claimed_motions, offered_options
from geotlm_lm.conversation.motion_names import motions_named
from geotlm_lm.conversation.option_meanings import (
    OptionSets,
    offers_neither,
    option_sets,
    true_option,
)
from geotlm_lm.conversation.rule_answers import RuleAnswer, RuleInput, directed_answer
from geotlm_lm.conversation.thread_answers import thread_answer
from geotlm_lm.conversation.wording import (
    KIND_SENTENCES,
    confidence_level,
    decapitalised,
    direction_clause,
    direction_sentence,
    frame_phrase,
    motion_phrase,
)
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import (
    DIRECTED,
    Motion,
    motion_class,
)

CAMERA = FrameSpec()


def answer_from_motion(felt: RuleInput) -> RuleAnswer:
    """Return the answer to `felt.question` that follows from the motion and the frame.

    Raises:
        KeyError: If no rule answers this kind of question.
    """
    return _RULES[felt.kind](felt)


def _open(felt: RuleInput) -> RuleAnswer:
    half = asked_half(felt.question) if felt.kind == "direction" else None
    if half is not None and direction_of_half(half, felt.frame.tell(felt.motion)) is not None:
        return _half(felt, half)
    return directed_answer(felt, felt.frame, lambda told: direction_sentence(told, felt.frame))


def _half(felt: RuleInput, half: Half) -> RuleAnswer:
    """Tell which way one half goes."""
    frame, options = felt.frame, {}
    for motion, probability in felt.probabilities.items():
        told = frame.tell(motion)
        word = (direction_of_half(half, told) or told).value
        options[word] = options.get(word, 0.0) + probability
    told = frame.tell(felt.motion)
    way = direction_of_half(half, told).value
    return RuleAnswer(
        f"The {half} half goes {way}, {frame_phrase(frame)}.", told, frame, options, way
    )


def _changed(felt: RuleInput) -> RuleAnswer:
    """Tell the motion of a clip that the question supposes changed, or whose motion undoes it."""
    changes = supposed_changes(felt.question, felt.kind)
    frame, ends = changes.frame(felt.frame), changes.in_words()

    def text(told: Motion) -> str:
        said = _undoing(told, frame) if "undo" in changes.names else direction_sentence(told, frame)
        return f"{said[:-1]}{ends}."

    told = directed_answer(felt, frame, text, changes.of)
    if "undo" in changes.names:
        claims = {claimed_inverse(felt.question)} - {None}
    else:
        claims = claims_on_changed_clip(felt.question)
    if not claims:
        return told
    share = min(sum(told.options.get(motion.value, 0.0) for motion in claims), 1.0)
    word = "yes" if told.direction in claims else "no"
    return replace(
        told,
        text=f"{word.capitalize()}, {decapitalised(told.text)}",
        options={"yes": share, "no": 1.0 - share},
        decided=word,
    )


def _undoing(told: Motion, frame: FrameSpec) -> str:
    if told in (Motion.STILL, Motion.NONE):
        return f"There is nothing to undo: {direction_clause(told, frame)}."
    if told not in DIRECTED:
        return f"{motion_phrase(told).capitalize()} undoes it."
    who = "Moving the sensor" if frame.actor == "sensor" else "Moving"
    return f"{who} {told.value} undoes it, {frame_phrase(frame)}."


VERDICTS = {
    "verify": ("Yes, {}.", "No, {}.", "yes", "no"),
    "negation": ("It is: {}.", "It is not: {}.", "it is", "it is not"),
    "premise": ("That holds: {}.", "But no, {}.", "it holds", "it does not"),
}
"""Kinds that say yes or no to a claim and tell the motion with it -> the sentence where it goes as
the question says, denied or not, where it does not, and their deciding words."""


def _judged(felt: RuleInput) -> RuleAnswer:
    """Compare the claim in the question with the motion, both in the frame."""
    frame, is_claim = felt.frame, felt.kind == "verify"
    whole = compound_claim(felt.question) if is_claim else None
    half = claimed_half(felt.question) if is_claim and whole is None else None
    read = whole or half
    claims = read.motions if read else claimed_motions(felt.question)
    if claims is None and felt.verdict is not None and felt.verdict != (felt.kind == "negation"):
        claims = {felt.motion}  # the model found the claim true of the camera image
    if claims is None:
        return _open(felt)
    true = [motion for motion in Motion if frame.tell(motion) in claims]
    verdict = _verdict(felt, felt.motion in true, true)
    told = direction_clause(frame.tell(felt.motion), frame)
    if whole is not None and whole.is_denied:
        so = "Yes, that is so" if verdict.decided == "yes" else "No, that is not so"
        return replace(verdict, text=f"{so}: {told}.")
    way = half and direction_of_half(half.half, frame.tell(felt.motion))
    if way:
        word = verdict.decided.capitalize()
        return replace(verdict, text=f"{word}, the {half.half} half goes {way.value}: {told}.")
    return verdict


def _verdict(felt: RuleInput, is_true: bool, claims: Sequence[Motion]) -> RuleAnswer:
    """Return yes or no and the motion; `claims` are those, in the image, of which yes is true."""
    yes, no, *words = VERDICTS[felt.kind]
    told = felt.frame.tell(felt.motion)
    share = sum(felt.probabilities.get(motion, 0.0) for motion in claims)
    text = (yes if is_true else no).format(direction_clause(told, felt.frame))
    options = {words[0]: share, words[1]: 1.0 - share}
    return RuleAnswer(text, told, felt.frame, options, words[0] if is_true else words[1])


def _choice(felt: RuleInput) -> RuleAnswer:
    frame = felt.frame
    if (sets := option_sets(felt.question)) is not None:
        return _choice_of_sets(felt, sets)
    if offers_neither(felt.question):
        return _or_neither(felt)
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
    text = f"{direction_sentence(told, frame)[:-1]}, option {letter}."
    return RuleAnswer(text, told, frame, options, f"{letter}) {told.value}")


def _choice_of_sets(felt: RuleInput, sets: OptionSets) -> RuleAnswer:
    """Tell the option that is true of the motion, where options say more or less than one."""
    frame, options = felt.frame, {}
    for motion, probability in felt.probabilities.items():
        label = true_option(sets, frame.tell(motion))
        if label is not None:
            word = f"{label}) {sets[label][0]}"
            options[word] = options.get(word, 0.0) + probability
    told = frame.tell(felt.motion)
    label = true_option(sets, told)
    if label is None:
        return _open(felt)
    text = f"{direction_sentence(told, frame)[:-1]}, option {label}."
    return RuleAnswer(text, told, frame, options, f"{label}) {sets[label][0]}")


def _or_neither(felt: RuleInput) -> RuleAnswer:
    """Tell the motion, and that it is none of those offered if so."""
    told = _open(felt)
    if told.direction in motions_named(felt.question):
        return told
    return replace(told, text=f"Neither: {direction_clause(told.direction, felt.frame)}.")


def _class(felt: RuleInput) -> RuleAnswer:
    shares: dict[str, float] = {}
    for motion, probability in felt.probabilities.items():
        word = motion_class(motion).value
        shares[word] = shares.get(word, 0.0) + probability
    kind, offered = motion_class(felt.motion), offered_kinds(felt.question)
    text = KIND_SENTENCES[kind]
    if offered is not None and kind not in offered:
        text = f"None of these: {direction_clause(felt.frame.tell(felt.motion), felt.frame)}."
    return RuleAnswer(text, None, felt.frame, shares, kind.value)


def _confidence(felt: RuleInput) -> RuleAnswer:
    told = felt.frame.tell(felt.motion)
    claims = likelihood_subject(felt.question)
    if claims is not None:
        is_true = told in claims
        shares = felt.probabilities.items()
        share = min(sum(odds for motion, odds in shares if felt.frame.tell(motion) in claims), 1.0)
        text = f"The probability of that is {share:.0%}: {direction_clause(told, felt.frame)}."
        options = {"yes": share, "no": 1.0 - share}
        return RuleAnswer(text, told, felt.frame, options, "yes" if is_true else "no")
    share = felt.probabilities.get(felt.motion, 0.0)
    level, clause = confidence_level(share), direction_clause(told, felt.frame)
    text = f"My confidence is {level}: {share:.0%} that {clause}."
    return directed_answer(felt, felt.frame, lambda _: text)


_RULES: dict[str, Callable[[RuleInput], RuleAnswer]] = {
    "direction": _open,
    "verify": _judged,
    "choice": _choice,
    "class": _class,
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
"""Kinds whose answer the rules can derive from a motion."""

ALWAYS_RULE_KINDS = RULE_KINDS - {"direction", "verify", "choice", "class", "negation", "premise"}
"""Kinds the rules derive even in the camera image; of the others the model's own words stand."""
