"""Answer choices, lettered or not, and which kind of motion it is, from what is believed."""

from __future__ import annotations

from dataclasses import replace

from geotlm_lm.conversation.felt import Felt, claim_of, subjects_of
from geotlm_lm.conversation.kind_choices import offered_kinds
from geotlm_lm.conversation.motion_claims import offered_options
from geotlm_lm.conversation.motion_names import motions_named
from geotlm_lm.conversation.option_meanings import (
    OptionSets,
    offers_neither,
    option_sets,
    true_option,
)
from geotlm_lm.conversation.rule_answers import RuleAnswer, RuleInput, answer_told, open_answer
from geotlm_lm.conversation.telling import tell
from geotlm_lm.conversation.wording import KIND_SENTENCES, capitalised, decapitalised
from geotlm_lm.core.labels import Motion, motion_class
from geotlm_lm.core.twist import COMPONENT_OF


def choice_answer(asked: RuleInput) -> RuleAnswer:
    """Pick what is believed of the motions that a question offers; of several the larger."""
    frame, felt = asked.frame, asked.felt.seen(asked.frame.tell)
    if (sets := option_sets(asked.question)) is not None:
        return _choice_of_sets(asked, felt, sets)
    offered = offered_options(asked.question)
    among = frozenset(offered.values()) or frozenset(motions_named(asked.question))
    subjects = subjects_of(among)
    opened = open_answer(felt, frame, subjects)
    true = [one for one in (*map(felt.way, felt.components), *felt.state) if one in among]
    if offers_neither(asked.question) and not true:
        return replace(opened, text=f"Neither: {decapitalised(opened.text)}", is_plain=False)
    if not offered or not true:
        return opened
    # Of letters that offer one motion the first stands for all: they are one answer.
    letters = {motion: letter for letter, motion in reversed(offered.items())}
    shares = {one: felt.words[one.value] for one in reversed(letters)}
    total = sum(shares.values())
    options = {f"{letters[one]}) {one.value}": share / total for one, share in shares.items()}
    told = tell(felt, frame, {COMPONENT_OF[true[0]]} if true[0] in COMPONENT_OF else ())
    word = f"{letters[true[0]]}) {true[0].value}"
    text = f"{capitalised(told.text)}, option {letters[true[0]]}."
    return replace(answer_told(told, text, frame, options, word), confidence=options[word])


def _choice_of_sets(asked: RuleInput, felt: Felt, sets: OptionSets) -> RuleAnswer:
    """Tell the option that is true of what is believed, where options say more or less than one."""
    label = true_option(sets, felt.state)
    subjects = frozenset().union(*(subjects_of(motions) for _, motions in sets.values()))
    told = tell(felt, asked.frame, subjects)
    if label is None:
        return open_answer(felt, asked.frame, subjects)
    options = {
        f"{one}) {words}": felt.probability(claim_of(motions))
        for one, (words, motions) in sets.items()
    }
    word = f"{label}) {sets[label][0]}"
    text = f"{capitalised(told.text)}, option {label}."
    sure = min(told.confidence, options[word])
    return replace(answer_told(told, text, asked.frame, options, word), confidence=sure)


def class_answer(asked: RuleInput) -> RuleAnswer:
    """Name the kind of every motion that counts, of those that a question offers."""
    frame, felt = asked.frame, asked.felt.seen(asked.frame.tell)
    shares: dict[str, float] = {}
    for motion, probability in felt.words.items():
        word = motion_class(Motion(motion)).value
        shares[word] = min(shares.get(word, 0.0) + probability, 1.0)
    ways = list(map(felt.way, felt.components)) or [felt.main]
    kinds, offered = [motion_class(way) for way in ways], offered_kinds(asked.question)
    told = [kind for kind in kinds if offered is None or kind in offered]
    names = [decapitalised(KIND_SENTENCES[kind][:-1]) for kind in told]
    text = f"{capitalised(' and '.join(names))}."
    if not told:
        told, text = kinds, f"None of these: {tell(felt, frame).text}."
    sure, is_plain = min(shares[kind.value] for kind in told), len(names) == 1
    word = told[0].value
    return RuleAnswer(
        text, None, frame, shares, word, sure, is_plain=is_plain, motion_class=told[0]
    )
