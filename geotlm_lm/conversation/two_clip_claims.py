"""Find what a question about two clips wants decided: a relation, or which clip is meant."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from geotlm_lm.conversation.axis_claims import claimed_axis
from geotlm_lm.conversation.clip_names import (
    clip_named,
    place_of,
)
from geotlm_lm.conversation.motion_claims import CLASS_NAMES, asks_yes_or_no
from geotlm_lm.conversation.motion_names import motions_named
from geotlm_lm.conversation.phrases import Phrases
from geotlm_lm.conversation.text_normalisation import without_openers
from geotlm_lm.conversation.two_clip_questions import canonical_two_clip_question
from geotlm_lm.core.labels import Motion, motion_class

_PHRASES = Phrases(
    "two_clip_claims",
    A_CLIP=clip_named("clip"),
    OTHER_CLIP=clip_named("other"),
    ONE_CLIP=clip_named("one"),
    SUBJECT_CLIP=clip_named("subject"),
)


Relation = Literal["same", "opposite", "different"]
Of = Literal["which", "both", "either", "neither", "one", "first", "second"]
Change = Literal["mirrored", "reversed"]

_RELATIONS: tuple[tuple[Relation, str], ...] = (
    ("same", _PHRASES.text("SAME")),
    ("opposite", _PHRASES.text("OPPOSITE")),
    ("different", _PHRASES.text("DIFFERENT")),
)
_RELATION = re.compile(
    r"\b(?:" + "|".join(f"(?P<{name}>{words})" for name, words in _RELATIONS) + r")\b"
)
_OPENLY = _PHRASES.pattern("OPENLY")
_TAG = _PHRASES.pattern("TAG")
_OF_KIND = _PHRASES.pattern("OF_KIND")
_PLAINLY = _PHRASES.pattern("PLAINLY")
_FALSE = _PHRASES.pattern("FALSE")
_SUPPOSED = _PHRASES.pattern("SUPPOSED")
_IMAGE_OF = _PHRASES.pattern("IMAGE_OF")
_UNDO = _PHRASES.pattern("UNDO")

_OF_WHOM: tuple[tuple[Of, str], ...] = (
    ("neither", _PHRASES.text("OF_NEITHER")),
    ("one", _PHRASES.text("OF_ONE")),
    ("first", _PHRASES.text("OF_FIRST")),
    ("second", _PHRASES.text("OF_SECOND")),
    ("which", _PHRASES.text("OF_WHICH")),
    ("either", _PHRASES.text("OF_EITHER")),
    ("both", _PHRASES.text("OF_BOTH")),
)
_NO_CLIP = _PHRASES.pattern("NO_CLIP")
_IF_ANY = _PHRASES.pattern("IF_ANY")
_OFFERED = _PHRASES.pattern("OFFERED")
_DENIED = _PHRASES.pattern("DENIED")
_TOUCHED = _PHRASES.pattern("TOUCHED")
_MOVES = _PHRASES.pattern("MOVES")
_EACH = _PHRASES.pattern("EACH")
_SUBJECT = _PHRASES.pattern("SUBJECT")
_AS_MUCH = _PHRASES.pattern("AS_MUCH")
_SPEED = _PHRASES.pattern("SPEED")
_COMPARED = _PHRASES.pattern("COMPARED")

_OF_REST = frozenset({Motion.STILL, Motion.NONE})
MOVING = frozenset(Motion) - _OF_REST
TOUCHED = frozenset(Motion) - {Motion.NONE}


@dataclass(frozen=True)
class RelationClaim:
    """A relation of two clips that a question claims.

    Args:
        relation: Of their directions.
        is_denied: Whether the question asks if it does not hold: "is it false that".
        is_plain: Whether it is asked so that naming the relation answers it: "the same way?".
    """

    relation: Relation
    is_denied: bool = False
    is_plain: bool = False


@dataclass(frozen=True)
class ShareClaim:
    """Motions of which a question asks which clip shows one, or claims how many do.

    Args:
        of: "which" is asked; of the others a yes or no is.
        motions: Any of them counts.
    """

    of: Of
    motions: frozenset[Motion]


def asks_of_two(question: str) -> bool:
    """Tell whether a question surely is about two clips: "which one slides?", "do both turn?"."""
    asked = (claimed_count, claimed_each, claimed_transform, supposed_transform, asks_same_amount)
    is_compared = claimed_subject(question) is not None and _COMPARED.search(question.lower())
    is_of_two = is_compared or asks_inverse(question) or canonical_two_clip_question(question)
    return bool(is_of_two) or any(read(question) is not None for read in asked)


def claimed_relation(question: str) -> RelationClaim | None:
    """Return the relation of two clips that a yes-or-no question claims; None where it claims none.

    None too where it offers two: "the same or opposite?".
    """
    text = _IF_ANY.sub("", without_openers(question))
    named = [found.lastgroup for found in _RELATION.finditer(text)]
    if _OPENLY.match(text) or len(set(named)) != 1:
        return None
    is_tagged = _TAG.search(text) is not None
    is_asked = asks_yes_or_no(text) or is_tagged or text.endswith("?") or _PLAINLY.match(text)
    if not is_asked:
        return None
    is_plain = named[0] == "same" and not is_tagged and bool(_PLAINLY.match(text))
    return RelationClaim(named[0], bool(_FALSE.search(text)), is_plain and "n't" not in text)


def claims_same_kind(question: str) -> bool | None:
    """Tell whether a text claims one kind of motion for two clips, or two kinds; else None."""
    text = without_openers(question)
    said = _OF_KIND.fullmatch(text)
    return None if said is None else bool(said["same"]) != bool(said["denied"])


def supposed_transform(question: str) -> tuple[str, int, Change] | None:
    """Return a question without its supposition, which clip it changes, 0 or 1, and how.

    "If the second clip were mirrored, would they turn the same way?"
    """
    text = without_openers(question)
    said = _SUPPOSED.search(text)
    if said is None:
        return None
    rest = re.sub(r"\bwould(?= (?:they|both|the two|these)\b)", "do", text.replace(said[0], " "))
    which = place_of(said["clip"])
    return " ".join(rest.split()).strip(" ,"), which, "mirrored" if said["mirrored"] else "reversed"


def claimed_transform(question: str) -> Change | None:
    """Return the transform that is claimed to relate two clips: mirrored or reversed."""
    text = without_openers(question)
    said = _IMAGE_OF.search(text)
    if said is None or not (asks_yes_or_no(text) or text.endswith("?")):
        return None
    return "mirrored" if said["mirrored"] else "reversed"


def asks_inverse(question: str) -> bool:
    """Tell whether a question asks if one clip's motion undoes the other's."""
    text = without_openers(question)
    return bool(_UNDO.search(text)) and not _OPENLY.match(text)


def claimed_count(question: str) -> ShareClaim | None:
    """Return the motions asked for and of how many clips; None for other questions."""
    text = _IF_ANY.sub("", _OFFERED.sub(" ", without_openers(question)))
    if _NO_CLIP.search(text) or _RELATION.search(text):
        return None
    of = next((of for of, words in _OF_WHOM if re.search(words, text)), None)
    if of is None or (of == "neither" and _DENIED.search(text)):
        return None
    words = dict(_OF_WHOM)[of]
    is_asked = of == "which" or asks_yes_or_no(text) or text.endswith("?")
    motions = _meant(re.sub(words, " ", text)) if is_asked else None
    if motions is None:
        return None
    if _DENIED.search(text):
        if of != "which":
            return None  # "both do not turn": none, or not all?
        motions = frozenset(Motion) - motions
    return ShareClaim(of, motions)


def claimed_subject(question: str) -> int | None:
    """Return which clip, 0 or 1, a yes-or-no question is about: "is the second one faster?"."""
    said = _SUBJECT.search(without_openers(question))
    return None if said is None else place_of(said["subject"])


def asks_same_amount(question: str) -> str | None:
    """Return "magnitude" or "rate" where it is asked if two clips go as far, or as fast."""
    text = without_openers(question)
    if _OPENLY.match(text) or not _AS_MUCH.search(text):
        return None
    return "rate" if _SPEED.search(text) else "magnitude"


_TURNS = _PHRASES.pattern("TURNS")


def claimed_each(question: str) -> tuple[frozenset[Motion], frozenset[Motion]] | None:
    """Return what a question claims of the first clip and of the second; None where not of both."""
    said = _EACH.fullmatch(without_openers(question).rstrip("?!. "))
    if said is None or place_of(said["one"]) == place_of(said["other"]):
        return None
    of_other = said["of_other"]
    if _TURNS.search(said["of_one"]) and re.fullmatch("left|right", of_other):
        of_other = f"turns {of_other}"
    claims = _meant(said["of_one"]), _meant(of_other)
    if None in claims:
        return None
    return claims[::-1] if place_of(said["one"]) else claims


def _meant(text: str) -> frozenset[Motion] | None:
    """Return the motions that words mean: one way, a kind, any at all, or touch; else None."""
    named, axis = motions_named(text), claimed_axis(text)
    if axis and named <= axis:
        return axis
    if len(named) == 1:
        return frozenset(named)
    kinds = {kind for kind, words in CLASS_NAMES if re.search(words, text)}
    if named or len(kinds) > 1:
        return None
    if kinds:
        return frozenset(one for one in Motion if motion_class(one) in kinds)
    if _TOUCHED.search(text):
        return TOUCHED
    return MOVING if _MOVES.search(text) else None
