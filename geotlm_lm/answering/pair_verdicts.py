"""Judge claims about two clips: yes or no, or which of the two is meant."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from geotlm_lm.answering.abstention import LEAST_SURE, tentative_text
from geotlm_lm.answering.answer import Answer
from geotlm_lm.answering.multi_clip import (
    Comparison,
    both_directions,
    compare_directions,
    pair_probabilities,
    why_not_comparable,
)
from geotlm_lm.conversation.felt import Felt, claim_of, subjects_of
from geotlm_lm.conversation.two_clip_claims import Change, Of, RelationClaim, ShareClaim
from geotlm_lm.conversation.wording import decapitalised
from geotlm_lm.core.labels import Motion, mirror, motion_class, reverse

_CHANGES: dict[Change, Callable[[Motion], Motion]] = {"mirrored": mirror, "reversed": reverse}

_HOLDS: dict[Of, Callable[[bool, bool], bool]] = {
    "both": lambda one, other: one and other,
    "either": lambda one, other: one or other,
    "neither": lambda one, other: not (one or other),
    "one": lambda one, other: one != other,
    "first": lambda one, other: one and not other,
    "second": lambda one, other: other and not one,
}
_WHICH = {
    (True, True): "both",
    (True, False): "first",
    (False, True): "second",
    (False, False): "neither",
}


def transformed_answer(answer: Answer, change: Change) -> Answer:
    """Return the open answer about a clip as if it were mirrored, or played backwards."""
    become = _CHANGES[change]
    options: dict[str, float] = {}
    for word, share in answer.options.items():
        options[become(Motion(word)).value] = share
    direction = None if answer.direction is None else become(answer.direction)
    return replace(answer, direction=direction, options=options)


def judge_relation(claim: RelationClaim, answers: Sequence[Answer]) -> Comparison:
    """Judge a claimed relation of two clips: yes or no.

    A release is a press played backwards: asked whether they are opposite, they are.
    """
    compared = compare_directions(*answers)
    if compared.abstained:
        return compared
    one, other = (answer.direction for answer in answers)
    if claim.relation == "opposite" and one == reverse(other) and compared.relation == "different":
        text = f"Opposite, as one is the other played backwards: {both_directions(answers)}"
        compared, is_so = replace(compared, text=text), True
    elif claim.relation == "different":
        is_so = compared.relation != "same"
    else:
        is_so = compared.relation == claim.relation
    word = _yes_or_no(is_so != claim.is_denied)
    if not claim.is_plain:
        text = f"{word.capitalize()}, {decapitalised(compared.text)}"
        compared = replace(compared, text=text)
    return replace(compared, decided=word)


def judge_transformed(
    judge: Callable[[Sequence[Answer]], Comparison],
    which: int,
    change: Change,
    answers: Sequence[Answer],
) -> Comparison:
    """Judge two clips of which one is supposed mirrored, or played backwards."""
    supposed = [
        transformed_answer(one, change) if at == which else one for at, one in enumerate(answers)
    ]
    judged = judge(supposed)
    if judged.abstained:
        return replace(judged, first=answers[0], second=answers[1])
    how = "mirrored" if change == "mirrored" else "played backwards"
    text = f"{judged.text[:-1]}, with the {('first', 'second')[which]} {how}."
    return replace(judged, text=text, first=answers[0], second=answers[1])


def judge_mirror_or_reversal(change: Change, answers: Sequence[Answer]) -> Comparison:
    """Judge whether one clip's motion is the other's mirrored, or played backwards."""
    one, other = transformed_answer(answers[0], change), answers[1]
    is_so = one.direction is not None and one.direction == other.direction
    share = sum(p for (a, b), p in pair_probabilities((one, other)).items() if a == b)
    return _told(_yes_or_no(is_so), share if is_so else 1.0 - share, answers, ", by direction: ")


def judge_kind(is_one_kind: bool, answers: Sequence[Answer]) -> Comparison:
    """Judge whether two clips show one kind of motion, or two kinds where that is asked."""
    kinds = [answer.direction and motion_class(answer.direction) for answer in answers]
    is_same = kinds[0] == kinds[1]
    share = sum(
        p
        for (one, other), p in pair_probabilities(answers).items()
        if (motion_class(one) == motion_class(other)) == is_same
    )
    return _told(_yes_or_no(is_same == is_one_kind), share, answers, ", by kind: ")


def judge_count(claim: ShareClaim, felts: Sequence[Felt], answers: Sequence[Answer]) -> Comparison:
    """Judge which of two clips, or how many of them, show the claimed motion."""
    shows, odds = _shows(felts, [claim.motions] * 2)
    answers = _about(claim.motions, felts, answers)
    if claim.of == "which":
        word = _WHICH[shows]
        share = sum(share for pair, share in odds.items() if _WHICH[pair] == word)
        return _told(word, share, answers)
    is_so = _HOLDS[claim.of](*shows)
    share = sum(share for pair, share in odds.items() if _HOLDS[claim.of](*pair) == is_so)
    return _told(_yes_or_no(is_so), share, answers)


def judge_each(
    claims: Sequence[frozenset[Motion]], felts: Sequence[Felt], answers: Sequence[Answer]
) -> Comparison:
    """Judge a claim on the first clip together with one on the second."""
    shows, odds = _shows(felts, claims)
    is_so, both = all(shows), odds[True, True]
    answers = _about(frozenset().union(*claims), felts, answers)
    return _told(_yes_or_no(is_so), both if is_so else 1.0 - both, answers)


def judge_amounts(compared: Comparison, claimed: str) -> Comparison:
    """Judge a claimed comparison of amounts: yes or no.

    Args:
        compared: As of a question for which of them goes further or faster.
        claimed: The relation that is claimed: "first", "second" or "similar".
    """
    if compared.abstained:
        return compared
    word = _yes_or_no(compared.relation == claimed)
    text = decapitalised(compared.text.removeprefix("Neither: "))
    return replace(compared, text=f"{word.capitalize()}, {text}", decided=word)


def judge_inverse(amounts: Comparison, answers: Sequence[Answer]) -> Comparison:
    """Judge whether one clip's motion undoes the other's: opposite direction, same amount.

    Args:
        amounts: The comparison of how far they go.
        answers: Which way each goes.
    """
    if (unsure := why_not_comparable(answers)) is not None:
        return Comparison(unsure, "unknown", 0.0, True, *answers)
    one, other = (answer.direction for answer in answers)
    is_back = one != other and other == reverse(one)
    share = sum(
        p for (a, b), p in pair_probabilities(answers).items() if a != b and b == reverse(a)
    )
    if not is_back:
        return _told("no", 1.0 - share, answers)
    if amounts.abstained:
        ways = both_directions(answers)
        text = f"One goes back what the other went, how far I cannot compare: {ways}"
        return Comparison(text, "opposite", share, False, *answers)
    if amounts.relation == "similar":
        told = _told("yes", share, answers)
        if told.abstained:
            return told
        text = f"{told.text} {_sized(amounts)}"
        return replace(told, text=text, confidence=share * amounts.confidence)
    text = f"No, only in part: {both_directions(answers)} {_sized(amounts)}"
    return Comparison(text, "opposite", share * amounts.confidence, False, *answers, "no")


def _sized(amounts: Comparison) -> str:
    sizes = amounts.text.partition("about ")[2]
    return f"They go about {sizes}"


def _told(word: str, share: float, answers: Sequence[Answer], joined: str = ": ") -> Comparison:
    """Return what is decided with which way each clip goes, unless it is withheld."""
    if (unsure := why_not_comparable(answers)) is not None:
        return Comparison(unsure, "unknown", 0.0, True, *answers)
    if word in ("first", "second"):
        text = f"The {word}: {both_directions(answers, beginning=word)}"
    else:
        text = f"{word.capitalize()}{joined}{both_directions(answers)}"
    if share < LEAST_SURE:
        return Comparison(tentative_text(text, share), "unknown", 0.0, True, *answers)
    relation = word if word in ("first", "second") else compare_directions(*answers).relation
    return Comparison(text, relation, share, False, *answers, word)


def _shows(
    felts: Sequence[Felt], claims: Sequence[frozenset[Motion]]
) -> tuple[tuple[bool, bool], dict[tuple[bool, bool], float]]:
    """Return whether each clip shows what is claimed of it, and how probable each pair is."""
    judged = [(claim_of(motions), felt) for motions, felt in zip(claims, felts, strict=True)]
    one, other = (claim(felt.state) for claim, felt in judged)
    p, q = (felt.probability(claim) for claim, felt in judged)
    odds = {
        (a, b): (p if a else 1.0 - p) * (q if b else 1.0 - q)
        for a in (True, False)
        for b in (True, False)
    }
    return (one, other), odds


def _about(
    motions: frozenset[Motion], felts: Sequence[Felt], answers: Sequence[Answer]
) -> list[Answer]:
    """Return the answers with the way of the component that is claimed, where it counts."""
    subjects = subjects_of(motions)
    found = []
    for felt, answer in zip(felts, answers, strict=True):
        ways = [felt.way(one) for one in felt.components if one in subjects]
        is_told = answer.direction is not None and ways
        found.append(replace(answer, direction=ways[0]) if is_told else answer)
    return found


def _yes_or_no(is_so: bool) -> str:
    return "yes" if is_so else "no"
