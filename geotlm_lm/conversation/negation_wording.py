"""Rewrite negations without "not": "anything but a turn", "it can't be moving, can it?"."""

from __future__ import annotations

import re

from geotlm_lm.conversation.kind_choices import REST

_BUT = r"(?:any|every|some)thing (?:but|except(?: for)?|other than|else than)"
_IT = r"(?:it|this|that|(?:the|my) \w+)"
_MOVES = re.compile(
    rf"\b(?P<is>is|was) (?P<who>{_IT}) {_BUT} {REST}(?=[ ?.!]*$)",
    re.IGNORECASE,
)
"""What is anything but at rest moves: "not still" would be judged as what is told of it."""

_OTHER_THAN = re.compile(
    rf"(?:\b(?:(?P<is>is|was) (?P<who>{_IT})(?: doing)?|(?P<does>does|did) (?P<whom>{_IT}) do)"
    rf" |^\W*){_BUT} ",
    re.IGNORECASE,
)
"""No other place of it is a denial: "does anything but the cap touch the gel?"."""

_CANNOT = re.compile(
    r"\b(?P<who>it|this|that|(?:the|my) \w+) (?:can't|cannot|can not|couldn't|could not)"
    r"(?: possibly)? (?:be|have been) (?P<what>[^?]+?),? (?:can|could) (?:it|that)\b",
    re.IGNORECASE,
)


_WITHOUT = re.compile(r"\b(moving|touching|pressing) without (?=\w+ing\b)", re.IGNORECASE)
"""Both are asked: of "turning without sliding" the first alone would do."""


def with_explicit_negation(question: str) -> str:
    """Replace an implicit negation by "not"; any other text stays as it is."""
    text = question.replace("\u2019", "'")
    denied = _CANNOT.sub(r"\g<who> is not \g<what>, is it", text)
    denied = _MOVES.sub(r"\g<is> \g<who> moving", denied)
    denied = _WITHOUT.sub(r"\1 but not ", _OTHER_THAN.sub(_not, denied))
    return question if denied == text else denied


def _not(said: re.Match[str]) -> str:
    verb, who = said["is"] or said["does"], said["who"] or said["whom"]
    return f"{verb} {who} not " if verb else "not "
