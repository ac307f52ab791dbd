"""Find the words of a text that an answer may copy as they stand: labels, keys of a template.

A program points at them by place: `@2` is the second that is found. They are quoted, in capitals,
joined by an underscore, before a colon or an equals sign, a single capital, between slashes, or
follow a word such as "print", "else" and "keys" that announces them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

from geotlm_lm.query.quantities import words_of_text

_QUOTED = re.compile(r"\"([^\"\n]{1,32})\"|(?<!\w)'([^'\n]{1,32})'(?!\w)|`([^`\n]{1,32})`")
_PLAIN = re.compile(
    r"(?<![\w'])(?:"
    r"[A-Za-z]\w*_\w+"  # angle_deg
    r"|[A-Z][A-Z0-9]+(?![\w'])"  # STOP
    r"|N/A\b"
    r"|[GHJ-WZ](?![\w'.])"  # L; programs spell A to F themselves, and X and Y are axes
    r"|[A-Za-z]\w*(?=\s?=(?!=)|:(?=[\s<{\"\[]|$))"  # angle=..., angle: ...
    r")"
)
_LISTED = re.compile(
    r"(?<![\w/])(?:[A-Za-z]\w*(?:/[A-Za-z]\w*){2,}"  # open/shut/none
    r"|[A-Za-z][\w-]{2,}(?:\s?/\s?[A-Za-z][\w-]{2,})+)(?![\w/])"  # pass / fail, but not deg/s
)
_SMALL = re.compile(r"(?:[\s:]+|\s*,\s*)([a-z][\w-]{1,14})(?![\w'])")
_CONDITIONED = re.compile(
    r"(?:^|[,;:.]\s+(?:and |or )?)([A-Za-z][a-z-]{1,14})(?=\s+(?:if|when|unless|otherwise)\b)"
)
_PART = re.compile(r"[\w-]+")


@dataclass(frozen=True)
class Copied:
    """A word of a text and where it stands, its quotation marks included."""

    text: str
    start: int
    end: int


def copied(text: str) -> list[Copied]:
    """Return the words of a text that may be copied, in the order they stand in."""
    quoted = [
        Copied(next(group for group in match.groups() if group), *match.span())
        for match in _QUOTED.finditer(text)
    ]
    words = {each.start: each for each in quoted}
    for listed in _LISTED.finditer(text):
        for word in _PART.finditer(listed[0]):
            start = listed.start() + word.start()
            words.setdefault(start, Copied(word[0], start, start + len(word[0])))
    for match in _PLAIN.finditer(text):
        if not any(each.start <= match.start() < each.end for each in quoted):
            words.setdefault(match.start(), Copied(match[0], *match.span()))
    for announced in _announced(text):
        words.setdefault(announced.start, announced)
    return sorted(words.values(), key=lambda each: each.start)


@lru_cache(maxsize=1)
def _announcing() -> tuple[re.Pattern[str], frozenset[str], frozenset[str]]:
    """Return what announces a word to be copied, what stands between, and what is never copied."""
    listed = words_of_text()["copied"]
    before = "|".join(map(re.escape, listed["behind"]))
    return (
        re.compile(rf"\b(?:{before})\b", re.IGNORECASE),
        frozenset(listed["between"]),
        frozenset((*listed["never"], *listed["behind"])),
    )


def _announced(text: str) -> Iterator[Copied]:
    """Yield words that are announced: "say stop or go", "keys angle, way", "redo if it slips"."""
    behind, between, never = _announcing()
    for match in _CONDITIONED.finditer(text):
        if match[1].lower() not in never:
            yield Copied(match[1], *match.span(1))
    for match in behind.finditer(text):
        at = match.end()
        while following := _SMALL.match(text, at):
            word, at = following[1], following.end()
            if word in between:
                continue
            if word in never:
                break
            yield Copied(word, *following.span(1))
            rest = text[at:].lstrip()
            if not rest.startswith((",", "or ", "and ")):
                break
