"""Find the motions of which a claim is true, its negations and second clauses included.

"It is not slipping, right?" is true of all that does not slide, "touching but not moving" of what
touches and is still. What denies one motion by its name ("is it not turning left?") is no such
claim: the models are trained on those.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from geotlm_lm.conversation.axis_claims import claimed_axis
from geotlm_lm.conversation.motion_claims import CLASS_NAMES
from geotlm_lm.conversation.motion_names import motions_named
from geotlm_lm.conversation.motion_verbs import ENDING, GO, STIR
from geotlm_lm.conversation.option_labels import labelled
from geotlm_lm.conversation.text_normalisation import without_openers
from geotlm_lm.core.labels import ROTATIONS, Motion, MotionClass, motion_class

EVERY = frozenset(Motion)
AT_REST = frozenset({Motion.STILL, Motion.NONE})

_SAID_BEFORE = re.compile(
    r"^(?:(?:hi|surely|from touch alone|quick question|looking at this clip|one more)[,:!]? )+"
)
_CLOSERS = re.compile(
    r"(?:[,.]? (?:please|thanks|thank you|then|now|here|in this clip|just asking|be brief)[.!?]*)+$"
)
_TAGS = re.compile(
    r"(?:[,;:.?] ?(?:right|correct|true|yes|eh|ok|am i right|is that (?:so|right|correct|true)"
    r"|(?:is|was|does|did|has)(?:n't| not)? (?:it|this|that|there))"
    r"|[,;:.?]? (?:or not|yes/no|y/n|yes or no|true or false|correct or not))[?.! ]*$"
)
_THINKING = r"(?: that| to (?:say|think)(?: that)?| in (?:saying|thinking)(?: that)?)"
_SAID = re.compile(
    r"(?:is it (?:true|correct|right|so|the case) that"
    rf"|am i (?:right|correct){_THINKING}"
    r"|can (?:i|we|you) (?:assume|say|conclude|confirm)(?: that)?"
    r"|(?:do|would|could) you (?:think|agree|believe|say)(?: that)?|i (?:think|believe|guess|say)"
    r"(?: that)?|(?:true or false|yes or no|correct or not|right or wrong)[:,]?"
    r"|(?:check|verify|confirm|tell me|say)(?: that| if| whether|:)) "
)
_SAID_TO_BE_FALSE = re.compile(
    r"(?:(?:is|was|would) (?:it|that)(?: be)? (?:wrong|false|incorrect|untrue|a mistake)"
    r"(?: that| to (?:say|claim|think|believe|assume|state)(?: that)?)"
    rf"|am i (?:wrong|mistaken){_THINKING}"
    r"|can (?:i|we|you) (?:rule out|exclude)(?: that)?) "
)
_NO_CLAIM = re.compile(
    r"\b(?:which|what|how|why|where|when|who|whose|if|whether|or|than|should|will|would|could|might"
    r"|tomorrow|again|before|later|next|only|just|yet|longer|stop\w*|ceas\w*|halt\w*"
    r"|los(?:e|es|ing|t)|without"
    r"|direction|kind|type|cannot)\b|\d|^(?:i|we|please)\b"
    r"|^(?:do|is|was|does|did|has|are)(?:n't| not)\b"
)
"""Words of another question, of another time, or of an end; "isn't it moving?" denies nothing."""

_CLAUSES = re.compile(r",? (?:and|but|yet)(?: (?=not\b|no\b)| )|[,;:] ")
_WHILE = re.compile(r",? (?:while|whilst) ")
_DENIAL = re.compile(r"\b(?:not|never|no|nothing|none)\b|n't\b")
_AUXILIARY = re.compile(r"(?<=\w)n't\b")

TORSION = re.compile(r"\b(?:torsion\w*|rotational|rotary|angular)(?: (?:slip\w*|slid\w*))?\b")
"""A slip that is a turn."""

_MOVES = re.compile(
    rf"\b(?:(?:{GO}|{STIR}){ENDING}|movement|motion|happen(?:s|ed|ing)?|going on)\b"
)
_TOUCHES = re.compile(r"\b(?:touch(?:es|ed|ing)?|contact)\b")
_HOLD = r"(?:press|push|hold|grip|squeez|touch)"
_HELD = re.compile(
    r"(?:(?:it|this|that|the \w+) )?(?:(?:is|was|being|gets) )*(?:pressed|pushed|held|gripped"
    rf"|squeezed|touched)(?: (?:against|on|by) .+)?|{_HOLD}ing(?: (?:it|on it|on the \w+))?"
    rf"|(?:i|we|you|the (?:robot|gripper|finger|hand)) (?:(?:am|are|is|was) )?{_HOLD}\w*(?: .+)?"
)
"""Said of what touches, whether it is pressed further in or not."""

_NOUN = (
    r"(?:rotation|turning|turn|twist|torsion|(?:torsional|rotational|linear|translational) "
    r"(?:slip|motion|movement)|slip|slippage|slide|sliding|translation)"
)
_KIND_NOTED = re.compile(
    rf"(?:any|some|(?:can|could|do|did) you (?:detect|see|feel|sense|notice)(?: any| a| some)?)"
    rf" (?P<any>{_NOUN})(?: at all| there)?"
    rf"|(?:any |is |was )?(?P<seen>{_NOUN}) (?:is |was |being )?"
    r"(?:detected|visible|present|noticeable|observed)"
    r"|(?P<short>(?:torsional|rotational|linear|translational) slip)"
)
_NOTED_OR_NOT = re.compile(rf"(?P<noun>{_NOUN})[:,]? (?:yes/no|y/n|yes or no)")
_LINEAR = re.compile(r"\b(?:linear|translational) (?:motion|movement|slip)")
_OF_AN_AXIS = re.compile(
    r"(?:is|was) (?:it|this|that|(?:the|its|this|that) (?:motion|movement|slide|slip|shift)) "
    r"(?:\w+ )?(?:horizontal|vertical|sideways)"
    r"|(?:(?:is|was) there (?:(?:an?|any|some) )?|(?:any|some) )(?:horizontal|vertical|sideways) "
    r"(?:motion|movement|slide|slip|shift)(?: at all| there)?"
)


@dataclass(frozen=True)
class CompoundClaim:
    """What a yes-or-no question claims.

    Args:
        motions: Of which a yes is true.
        is_denied: Whether it is said of something that it is not so.
    """

    motions: frozenset[Motion]
    is_denied: bool


def compound_claim(question: str) -> CompoundClaim | None:
    """Parse what a question claims as a whole; None where other rules, or the model, do."""
    text = without_openers(question).strip(" ?.!")
    if len(labelled(question.upper(), bool)) > 1:
        return None
    text = _CLOSERS.sub("", without_openers(_SAID_BEFORE.sub("", text, count=1)))
    if (noted := _NOTED_OR_NOT.fullmatch(text)) is not None:
        return CompoundClaim(_of_noun(noted["noun"]), is_denied=False)
    while (shorter := _TAGS.sub("", text)) != text:
        text = shorter
    if (noted := _KIND_NOTED.fullmatch(text)) is not None:
        return CompoundClaim(
            _of_noun(noted["any"] or noted["seen"] or noted["short"]), is_denied=False
        )
    if _OF_AN_AXIS.fullmatch(text) and (axis := claimed_axis(text)):
        return CompoundClaim(axis, is_denied=False)
    false = _SAID_TO_BE_FALSE.match(text)
    if false is None:
        return _of_clauses(_SAID.sub("", text, count=1) if _SAID.match(text) else text)
    said = _of_clauses(text[false.end() :], is_judged=True)
    return None if said is None else CompoundClaim(EVERY - said.motions, is_denied=True)


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
    if not (denied or during or is_judged):
        return None
    if len(parts) == 1 and not is_judged and not _denies_a_kind(text):
        return None
    if denied and not frozenset.intersection(*sets):
        return None  # "pressed but not moving?": pressed is then no motion
    return CompoundClaim(frozenset.intersection(*sets), is_denied=bool(denied))


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
