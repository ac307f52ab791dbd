"""Find the words of a text that an answer may copy: keys, labels, alternatives, columns.

A query copies them by place: `@2` is the second that is found. Each word counts once, where it
stands first. Names of formats and words that only lead up to others are never copied.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

from geotlm_lm.query.quantities import words_of_text

_RATES = ("s", "ms", "min", "frame", "px", "mm")
"""What ends "degrees/second", which are no alternatives."""

LONGEST = 32
"""Characters of a quoted word, at most."""

_QUOTED = re.compile(r"(?<!\w)\"([^\"\n]*)\"|“([^”\n]*)”|(?<!\w)'([^'\n]*)'(?!\w)|`([^`\n]*)`")
_NO_WORD = re.compile(r"<\w|\w>|\w=\w|[{}\[\]|\t;]|^(?:\.+|…|\?+|_+|\s*)$|^\w+(?:[,/]\w+){2,}$")
"""What is quoted and is no word: a template, a gap, a header line."""

_TAG = re.compile(r"<([A-Za-z][\w.-]*)>(?=.*</\1>)|(?<=>)([A-Za-z][\w+-]*)(?=</)", re.DOTALL)
_ITEM = r"[A-Za-z][\w.+-]*"
_BETWEEN_BARS = re.compile(r"(?<![\w|])[\w+-][\w.+-]*(?:(?:\s+\|\s+|\|)[\w.+-]+)+(?![\w])")
_HEADER = re.compile(
    rf"(?<![\w/.]){_ITEM}(?:(?:[;\t]{_ITEM})+|(?:,{_ITEM}){{2,}})(?![\w/])"
    r"|(?<![\w/.])[A-Za-z]\w*(?:,\w*_\w+)+(?![\w/])"
)
_SLASHED = re.compile(
    r"(?<![\w/])(?:[A-Za-z]\w*(?:/[A-Za-z]\w*){2,}"  # open/shut/none
    r"|[A-Za-z][\w-]{2,}(?:\s?/\s?[A-Za-z][\w-]{2,})+)(?![\w/])"  # pass / fail, but not deg/s
)
_PLAIN = re.compile(
    r"(?<![\w'])(?:"
    r"[A-Za-z]\w*_\w+"  # angle_deg
    r"|[A-Z][A-Z0-9]+(?![\w'])"  # STOP
    r"|N/A\b"
    r"|[a-z]{2,}[A-Z][A-Za-z0-9]*"  # turnAngle
    r"|[a-z]+(?:\.[a-z]+)*\.[xyzw]\b"  # angular.z
    r"|[GHJ-WZ](?![\w'.])"  # L; programs spell A to F themselves, and X and Y are axes
    # angle=..., angle: ..., way:cw|ccw
    r"|(?<!/)[A-Za-z](?:[\w.-]*\w)?(?=\s?=(?![=>])|:(?=[\s<{\"'\[?]|\w+\||$))"
    r")"
)
_POINTED = re.compile(r"(?:->|=>|→|:=)\s*([A-Za-z][\w-]*)(?![\w'])")
_SMALL = re.compile(r"(?:[\s:]+|\s*,\s*)([A-Za-z][\w-]{1,14})(?![\w'])")
_CONDITIONED = re.compile(
    r"(?:^|[,;:.]\s+(?:and |or )?)([A-Za-z][a-z-]{1,14})(?=\s+(?:if|when|unless|otherwise)\b)"
)
_LISTED_ITEM = re.compile(
    r"\s*(?:"
    r"(?P<quoted>\"[^\"\n]*\"|'[^'\n]*'|`[^`\n]*`)"
    r"|(?P<long>[A-Za-z][\w+-]*(?: [A-Za-z][\w+-]*){1,2})(?=\s*(?:[,;|)\].?!]|$)| (?:or|and) )"
    r"|(?P<short>[A-Za-z](?:[\w.+-]*\w)?)"
    r")"
)
_ASIDE = re.compile(r"\s*(?:\([^()\n]*\)|\[[^\[\]\n]*\]|<[^<>\n]*>)")
_JOINT = re.compile(r"(?:\s*[,;|/\t&]\s*(?:and |or )?|\s+(?:and|or)\s+|\s*\n\s*[-*]\s*)")
_VALUE = re.compile(r"[:=|]\s*$")
_NUMBERED = re.compile(r"\d\s$")
_PART = re.compile(r"[\w.+-]*[^\W\d_](?:[\w.+-]*[\w+])?")


@dataclass(frozen=True)
class Copied:
    """A word of a text and where it stands, its quotation marks included."""

    text: str
    start: int
    end: int


def copied(text: str) -> list[Copied]:
    """Return the words of a text that may be copied, in the order they stand in."""
    kept: list[Copied] = []
    for finder in (_quoted, _tags, _alternatives, _listed, _plain, _announced):
        for word in finder(text):
            is_free = all(word.end <= each.start or each.end <= word.start for each in kept)
            if is_free and word.text.lower() not in _words("formats"):
                kept.append(word)
    kept.sort(key=lambda each: each.start)
    first = {each.text: each for each in reversed(kept)}
    return [each for each in kept if first[each.text] is each]


@lru_cache(maxsize=1)
def _lists() -> dict[str, frozenset[str]]:
    """Return the lists of words; `filler` is all that leads up to what is copied."""
    lists = {name: frozenset(words) for name, words in words_of_text()["copied"].items()}
    leading = lists["behind"] | lists["listing"] | lists["keyed"] | lists["leading"]
    lists["filler"] = (lists["never"] - lists["labels"]) | leading
    lists["never"] |= leading
    units = words_of_text()["units"]
    lists["rates"] = frozenset(word for unit in _RATES for word in units[unit])
    return lists


def _words(name: str) -> frozenset[str]:
    return _lists()[name]


def _is_filler(word: str) -> bool:
    """Tell whether a word only leads up to others; of words in capitals few do."""
    if word.isupper():
        return word in ("IF", "ELSE", "THE", "AND", "OR", "IS", "OF", "ONLY", "THEN", "I")
    return word.lower() in _words("filler")


@lru_cache(maxsize=3)
def _any_of(name: str) -> re.Pattern[str]:
    words = sorted(_words(name), key=len, reverse=True)
    return re.compile(rf"\b(?:{'|'.join(map(re.escape, words))})\b", re.IGNORECASE)


def _quoted(text: str, offset: int = 0) -> Iterator[Copied]:
    """Yield what is quoted, but for templates, whose own quotes count, and types of values."""
    for match in _QUOTED.finditer(text):
        inner = next(group for group in match.groups() if group is not None)
        start = offset + match.start()
        if len(inner) > LONGEST or _NO_WORD.search(inner):
            yield from _quoted(inner, start + 1)
        elif not (_VALUE.search(text[: match.start()]) and inner.lower() in _words("types")):
            yield Copied(inner, start, offset + match.end())


def _tags(text: str) -> Iterator[Copied]:
    """Yield tags that are closed again, and single words inside: <answer>cw</answer>."""
    for match in _TAG.finditer(text):
        group = 1 if match[1] else 2
        yield Copied(match[group], *match.span(group))


def _alternatives(text: str) -> Iterator[Copied]:
    """Yield the parts of "cw|ccw|none", "pass / fail" and "angle;way", each by itself."""
    for pattern in (_BETWEEN_BARS, _HEADER, _SLASHED):
        for match in pattern.finditer(text):
            parts = list(_PART.finditer(match[0]))
            words = [part[0].lower() for part in parts]
            is_rate = pattern is _SLASHED and words[-1:] and words[-1] in _words("rates")
            if is_rate or any(_is_filler(part[0]) for part in parts):
                continue
            for part, word in zip(parts, words, strict=True):
                if pattern is not _BETWEEN_BARS or word not in _words("types"):
                    place = match.start() + part.start()
                    yield Copied(part[0], place, place + len(part[0]))


def _listed(text: str) -> Iterator[Copied]:
    """Yield the words of lists: "one of: a, b_c, d", "columns a, b and c"."""
    for name in ("listing", "keyed"):
        for match in _any_of(name).finditer(text):
            if match[0].lower() == "key" and not _is_of_data(text, match):
                continue
            items = list(_items(text, _behind(text, match.end()), name == "listing"))
            if len(items) > 1 or name == "keyed":
                yield from items


def _is_of_data(text: str, key: re.Match[str]) -> bool:
    """Tell whether a key is one of JSON, "with key angle", and not "the key turns"."""
    is_named = text[key.end() :].lstrip().startswith((":", "named", "called"))
    *_, before = text[: key.start()].lower().split() or ["."]
    return is_named or before.endswith(tuple(",.;:(")) or before in _words("before_key")


def _behind(text: str, at: int) -> int:
    """Return where a list begins behind what announces it."""
    while True:
        start = re.compile(r"[\s:,(\[{]*").match(text, at).end()
        word = re.compile(r"[A-Za-z]+(?=[\s:])").match(text, start)
        if word is None or word[0].lower() not in _words("between"):
            return start
        at = word.end()


def _items(text: str, at: int, may_be_long: bool) -> Iterator[Copied]:
    while match := _LISTED_ITEM.match(text, at):
        group = match.lastgroup
        parts = match[group].lower().split()
        if group == "long" and (not may_be_long or not _words("filler").isdisjoint(parts)):
            group = "short"
            match = re.compile(r"\s*(?P<short>[A-Za-z](?:[\w.+-]*\w)?)").match(text, at)
        word, at = match[group], match.end()
        while aside := _ASIDE.match(text, at):
            at = aside.end()
        joint = _JOINT.match(text, at)
        if group != "quoted":
            is_letter = word == "a" and joint is not None
            is_filler = _is_filler(word) and not is_letter
            if is_filler or word.lower() in _words("formats"):
                return
            yield Copied(word, *match.span(group))
        if joint is None:
            return
        at = joint.end()


def _plain(text: str) -> Iterator[Copied]:
    """Yield words that are written as keys and labels are; of a text in capitals no capitals."""
    is_loud = text.upper() == text and len(text.split()) > 5
    for match in _PLAIN.finditer(text):
        word = match[0]
        is_loud_word = is_loud and word.isalpha() and not text[match.end() :].startswith((":", "="))
        is_unit = _NUMBERED.search(text[: match.start()]) and word.islower()  # "3 degrees: ..."
        is_little = word in ("in", "In", "one", "two", "both")  # "fill in: ..."
        if not (is_loud_word or is_unit or is_little or _is_filler(word)):
            yield Copied(word, *match.span())


def _announced(text: str) -> Iterator[Copied]:
    """Yield words that are announced: "say stop or go", "redo if it slips", "cw -> tight"."""
    between, never = _words("between"), _words("never")
    for match in _POINTED.finditer(text):
        if match[1].lower() not in _words("filler") | _words("types"):
            yield Copied(match[1], *match.span(1))
    for match in _CONDITIONED.finditer(text):
        if match[1].lower() not in never:
            yield Copied(match[1], *match.span(1))
    for match in _any_of("behind").finditer(text):
        at = match.end()
        while following := _SMALL.match(text, at):
            word, at = following[1], following.end()
            if word.lower() in between:
                continue
            if word.lower() in never | _words("formats"):
                break
            yield Copied(word, *following.span(1))
            rest = text[at:].lstrip()
            if not rest.startswith((",", "or ", "and ")):
                break
