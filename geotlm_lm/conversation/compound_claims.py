"""Find the motions of which a claim is true, its negations and second clauses included.

"It is not slipping, right?" is true of all that does not slide, "touching but not moving" of what
touches and is still. What denies one motion by its name ("is it not turning left?") is no such
claim: the models are trained on those.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from geotlm_lm.conversation.axis_claims import claimed_axis
from geotlm_lm.conversation.felt import State, claim_of, subjects_of
from geotlm_lm.conversation.motion_claims import CLASS_NAMES, asks_both_kinds, asks_yes_or_no
from geotlm_lm.conversation.motion_names import motions_named
from geotlm_lm.conversation.option_labels import labelled
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import without_openers
from geotlm_lm.core.labels import ROTATIONS, Motion, MotionClass, motion_class
from geotlm_lm.core.twist import Component

_PHRASES = Phrases("compound_claims")
EVERY = frozenset(Motion)
AT_REST = frozenset({Motion.STILL, Motion.NONE})

_SAID_BEFORE = _PHRASES.pattern("SAID_BEFORE")
_CLOSERS = _PHRASES.pattern("CLOSERS")
_TAGS = _PHRASES.pattern("TAGS")
_SAID = _PHRASES.pattern("SAID")
_SAID_TO_BE_FALSE = _PHRASES.pattern("SAID_TO_BE_FALSE")
_NO_CLAIM = _PHRASES.pattern("NO_CLAIM")
_CLAUSES = _PHRASES.pattern("CLAUSES")
_WHILE = _PHRASES.pattern("WHILE")
_DENIAL = _PHRASES.pattern("DENIAL")
_AUXILIARY = re.compile(r"(?<=\w)n't\b")

TORSION = _PHRASES.pattern("TORSION")
_MOVES = _PHRASES.pattern("MOVES")
_TOUCHES = _PHRASES.pattern("TOUCHES")
_HELD = _PHRASES.pattern("HELD")
_KIND_NOTED = _PHRASES.pattern("KIND_NOTED")
_NOTED_OR_NOT = _PHRASES.pattern("NOTED_OR_NOT")
_LINEAR = _PHRASES.pattern("LINEAR")
_OF_AN_AXIS = _PHRASES.pattern("OF_AN_AXIS")


@dataclass(frozen=True)
class CompoundClaim:
    """What a yes-or-no question claims.

    Args:
        clauses: The motions of each clause; all of them are claimed.
        is_denied: Whether it is said of something that it is not so.
        is_false: Whether it is claimed that the clauses are not all true.
    """

    clauses: tuple[frozenset[Motion], ...]
    is_denied: bool = False
    is_false: bool = False

    def holds(self, state: State) -> bool:
        """Tell whether the claim is true of a state."""
        return all(claim_of(one)(state) for one in self.clauses) != self.is_false

    @property
    def subjects(self) -> frozenset[Component]:
        """The components it is about; none where it is about rest or contact."""
        return frozenset().union(*map(subjects_of, self.clauses))


def compound_claim(question: str) -> CompoundClaim | None:
    """Parse what a question claims as a whole; None where other rules, or the model, do."""
    if asks_both_kinds(question):
        return CompoundClaim((of_kind(MotionClass.ROTATION), of_kind(MotionClass.SLIDE)))
    text = without_openers(question).strip(" ?.!")
    if len(labelled(question.upper(), bool)) > 1:
        return None
    text = _CLOSERS.sub("", without_openers(_SAID_BEFORE.sub("", text, count=1)))
    if (noted := _NOTED_OR_NOT.fullmatch(text)) is not None:
        return CompoundClaim((_of_noun(noted["noun"]),))
    while (shorter := _TAGS.sub("", text)) != text:
        text = shorter
    if (noted := _KIND_NOTED.fullmatch(text)) is not None:
        return CompoundClaim((_of_noun(noted["any"] or noted["seen"] or noted["short"]),))
    if _OF_AN_AXIS.fullmatch(text) and (axis := claimed_axis(text)):
        return CompoundClaim((axis,))
    false = _SAID_TO_BE_FALSE.match(text)
    if false is None:
        return _of_clauses(_SAID.sub("", text, count=1) if _SAID.match(text) else text)
    said = _of_clauses(text[false.end() :], is_judged=True)
    return said and CompoundClaim(said.clauses, is_denied=True, is_false=True)


def claimed_set(text: str) -> frozenset[Motion] | None:
    """Return the motions of which all clauses, negated or not, are true; None if unknown.

    Args:
        text: In lower case; no question.
    """
    sets = [_of_one(clause) for clause in _CLAUSES.split(text)]
    return frozenset.intersection(*sets) if all(sets) else None


def _of_one(clause: str) -> frozenset[Motion] | None:
    """Return the motions of which one clause is true."""
    plain, denials = _DENIAL.subn(" ", _AUXILIARY.sub(" not", clause))
    found = _plain_set(plain)
    if denials > 1 or found is None:
        named = motions_named(clause) if denials else set()
        return frozenset(named) if len(named) == 1 else None  # "nothing"
    return EVERY - found if denials else found


def _of_clauses(text: str, *, is_judged: bool = False) -> CompoundClaim | None:
    """Return what all clauses together claim.

    None where it is nothing that is denied, and no two things said to go on at once.

    Args:
        text: A question, or what is said to be so.
        is_judged: Whether a single plain claim counts as well.
    """
    text = re.sub(r"\bstill (?=not\b|no\b)", "", text)
    if _NO_CLAIM.search(text):
        return None
    main, *during = _WHILE.split(text)
    parts = _CLAUSES.split(main)
    parts += ["touching" if _HELD.fullmatch(one) else one for one in during]
    sets = [_of_one(part) for part in parts]
    denied = [part for part in parts if _DENIAL.search(part)]
    if not all(sets):
        return None
    if not (denied or during or is_judged or _are_of_several(text, sets)):
        return None
    if len(parts) == 1 and not is_judged and not _denies_a_kind(text):
        return None
    if denied and not frozenset.intersection(*sets) and not all(map(subjects_of, sets)):
        return None  # "pressed but not moving?": pressed is then no motion
    return CompoundClaim(tuple(sets), is_denied=bool(denied))


def _are_of_several(text: str, clauses: Sequence[frozenset[Motion]]) -> bool:
    """Tell whether it is asked if several components go at once: "is it turning and sliding?"."""
    subjects = [subjects_of(one) for one in clauses]
    is_each_another = len(frozenset().union(*subjects)) == sum(map(len, subjects))
    return len(clauses) > 1 and all(subjects) and is_each_another and asks_yes_or_no(text)


def _denies_a_kind(text: str) -> bool:
    """Tell whether a clause denies a kind of motion, or any; none by its name, and no contact."""
    plain = _DENIAL.sub(" ", _AUXILIARY.sub(" not", text))
    named = motions_named(plain) | motions_named(re.sub(r"\bnothing\b", " ", text))
    return not named and _plain_set(plain) not in (None, EVERY - {Motion.NONE})


def _plain_set(text: str) -> frozenset[Motion] | None:
    """Return the motions of which a clause without a denial is true."""
    if TORSION.search(text):
        return frozenset(ROTATIONS)
    named = motions_named(text)
    if named:
        return frozenset(named) if len(named) == 1 else None
    kinds = {kind for kind, words in CLASS_NAMES if re.search(words, text)}
    if kinds:
        return of_kind(kinds.pop()) if len(kinds) == 1 else None
    if axis := claimed_axis(text):
        return axis
    if _MOVES.search(text):
        return EVERY - AT_REST
    return EVERY - {Motion.NONE} if _TOUCHES.search(text) else None


def of_kind(kind: MotionClass) -> frozenset[Motion]:
    """Return the motions of a kind."""
    return frozenset(motion for motion in Motion if motion_class(motion) == kind)


def _of_noun(noun: str) -> frozenset[Motion]:
    if TORSION.search(noun):
        return frozenset(ROTATIONS)
    return of_kind(MotionClass.SLIDE) if _LINEAR.search(noun) else _plain_set(noun)
