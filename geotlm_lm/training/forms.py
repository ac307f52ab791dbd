"""Questions that ask for an output of a given form, put together from parts of `forms.toml`.

Fields, keys, layouts, labels, conditions and openers are drawn apart from each other, so that the
pairs are as many as nobody can learn by heart. A layout, and a way to ask, is of one split.
"""

from __future__ import annotations

import random
import re
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any

from geotlm_lm.core.files import training_templates
from geotlm_lm.query.copied import copied
from geotlm_lm.query.quantities import find
from geotlm_lm.query.reader import MOST_WORDS
from geotlm_lm.training.grammar import Pair, numbered, split_of

MOST_FIELDS = 6
LONGEST_TEXT = 600
"""Characters of a text, at most."""

_KINDS = ("number", "bool", "word", "time")
_NUMBER = re.compile(r"[-+]?\d+")
_HOLE = re.compile(r"#([\w/]*)")
_ASKS = {"template": 10, "digits": 2, "labels": 2, "spelled": 2, "tags": 1, "bars": 1, "number": 1,
         "truth": 1, "bits": 1, "verdict": 3}  # fmt: skip
"""What is asked for, and how often one is drawn against the others."""
_SPACED = (",", ";", "|")
_OPAQUE, _ALTERNATIVES, _ROUNDED, _STATED, _JOINT = 0.15, 0.6, 0.2, 0.12, 0.4
"""How often keys mean nothing, a direction's labels are offered, decimals are told, a fact is
stated, and two conditions are joined."""


@dataclass(frozen=True)
class Meaning:
    """What a field may mean.

    Args:
        kind: Of its value, one of "number", "bool", "word" and "time".
        program: Words.
        keys: Spellings of a key that says it.
        phrases: Phrases.
        labels: Name of the labels that it may offer; "" of none.
    """

    kind: str
    program: str
    keys: tuple[str, ...]
    phrases: tuple[str, ...]
    labels: str = ""


@dataclass(frozen=True)
class Layout:
    """How a template is laid out."""

    id: str
    form: str
    around: str
    field: str
    between: str
    style: str


@dataclass
class Draft:
    """A text in the making; what is copied from it is marked as the grammar marks it."""

    copies: dict[str, str] = field(default_factory=dict)  # a mark in the line -> what it copies

    def mark(self, text: str) -> tuple[str, str]:
        """Return a word or a number, marked where it stands first, and its mark in the line."""
        for mark, copy in self.copies.items():
            if copy == text:
                return text, mark
        return self.mark_anew(text)

    def mark_anew(self, text: str) -> tuple[str, str]:
        """As `mark`, of a number that another may equal: "12 degrees and 12 px" are two."""
        place = len(self.copies) + 1
        is_number = _NUMBER.fullmatch(text) or text[0].isdigit()
        mark = ("\ue003" if is_number else "\ue004") + str(place)
        self.copies[mark] = text
        return f"\ue000{place}\ue001{text}\ue002", mark

    def filled(self, rng: random.Random, text: str, line: str) -> tuple[str, str]:
        """Return a text and its line with a number in each place of "#"; units are the line's."""
        units = _HOLE.findall(line)
        for unit in units:
            words, mark = self.mark_anew(_figure(rng, unit))
            text, line = text.replace("#", words, 1), _HOLE.sub(mark, line, count=1)
        return text, line


def _figure(rng: random.Random, unit: str) -> str:
    most = {"deg": 90, "px": 60, "mm": 3, "s": 5, "deg/s": 120, "": 9, "frame/s": 120}
    if unit in ("mm/px", "mm", "s"):
        return f"{rng.uniform(0.02, 0.09) if unit == 'mm/px' else rng.uniform(0.2, most[unit]):.2f}"
    return str(rng.randint(2, most.get(unit, 30)))


class Forms:
    """The parts of data_templates/query/forms.toml."""

    def __init__(self) -> None:
        path = training_templates() / "query" / "forms.toml"
        self.parts: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))

    @cached_property
    def meanings(self) -> list[Meaning]:
        """All that a field may mean."""
        rows = map(_row, self.parts["meanings"].strip().splitlines())
        return [
            Meaning(row[0], row[1], tuple(row[2].split()), _phrases(row[3]),
                    row[4].strip("-") if len(row) > 4 else "")
            for row in rows
        ]  # fmt: skip

    @cached_property
    def layouts(self) -> list[Layout]:
        """All layouts of templates."""
        rows = map(_row, self.parts["layouts"].strip().splitlines())
        return [Layout(f"forms/template-{place}", *row) for place, row in enumerate(rows)]

    @cached_property
    def conditions(self) -> list[list[str]]:
        """What may be required: program, phrases, and phrases of the opposite."""
        return [_row(line) for line in self.parts["conditions"]["rows"].strip().splitlines()]

    @cached_property
    def facts(self) -> list[list[str]]:
        """What may be stated, and its facts."""
        return [_row(line) for line in self.parts["facts"]["rows"].strip().splitlines()]

    def asks(self, split: str | None) -> dict[str, list[tuple[str, Any]]]:
        """Return the ways to ask of a split, each with its id, by what is asked for."""
        asks: dict[str, list[tuple[str, Any]]] = {
            name: [(f"forms/{name}-{place}", text) for place, text in enumerate(texts)]
            for name, texts in self.parts["ask"].items()
        }
        asks["template"] = [(layout.id, layout) for layout in self.layouts]
        kept = {
            name: [each for each in ways if split in (None, split_of(each[0]))]
            for name, ways in asks.items()
        }
        return {name: ways for name, ways in kept.items() if ways}


def _row(line: str) -> list[str]:
    return [part.strip() for part in line.split("::")]


def _phrases(text: str) -> tuple[str, ...]:
    return tuple(text.split(" / "))


@lru_cache(maxsize=1)
def _forms() -> Forms:
    return Forms()


def formed(rng: random.Random, split: str | None = None) -> Iterator[Pair]:
    """Yield pairs without end.

    Args:
        rng: Draws them.
        split: One of `grammar.SPLITS`; None for all ways to ask.
    """
    asks = _forms().asks(split)
    names = [name for name in _ASKS if name in asks]
    while True:
        (name,) = rng.choices(names, [_ASKS[name] for name in names])
        family, way = rng.choice(asks[name])
        draft = Draft()
        text, line = _WRITERS[name](rng, way, draft)
        if rng.random() < _STATED:
            text, line = _stated(rng, text, line, draft)
        pair = _whole(_typed(rng, text), line, family, draft)
        if pair is not None:
            yield pair


def _whole(text: str, line: str, family: str, draft: Draft) -> Pair | None:
    """Return a pair; None where a word or a number is not read as it was meant, or it is long."""
    if len(text) > LONGEST_TEXT:
        return None
    pair = numbered(text, line, (family,))
    if pair is None or len(pair.query.split()) > MOST_WORDS - 2:
        return None
    words = [each.text for each in copied(pair.text)]
    numbers = [each.quantity.value for each in find(pair.text)]
    meant = [draft.copies[mark] for mark in re.findall("[\ue003\ue004]\\d+", line)]
    slots = re.findall(r"(?<!\S)[#@]\d+(?!\S)", pair.query)
    for slot, copy in zip(slots, meant, strict=True):
        place = int(slot[1:]) - 1
        is_read = float(copy) == numbers[place] if slot[0] == "#" else copy == words[place]
        if not is_read:
            return None
    return pair


def _typed(rng: random.Random, text: str) -> str:
    """Return a text as somebody types it: with breaks and tabs, its first letter large or small."""
    text = re.sub(" *¶ *", "\n", text).replace("⇥", "\t").strip()
    if rng.random() < 0.3 and text[0].isalpha() and text[1:2].islower():
        text = text[0].swapcase() + text[1:]
    return text.rstrip(".") if rng.random() < 0.2 else text


def _stated(rng: random.Random, text: str, line: str, draft: Draft) -> tuple[str, str]:
    """Return a question with facts before or behind it."""
    words, facts = draft.filled(rng, *rng.choice(_forms().facts))
    end = "" if words.endswith(".") else "."
    is_first = rng.random() < 0.7
    text = f"{words}{end} {text}" if is_first else f"{text} {words}{end}"
    return text, f"{facts} ; {line}"


# Templates


def _template(rng: random.Random, layout: Layout, draft: Draft) -> tuple[str, str]:
    parts = _forms().parts
    count = min(rng.choice((1, 2, 2, 3, 3, 3, 4, 4, 5, 6)), MOST_FIELDS)
    count = max(count, 2) if layout.between in ("comma", *_SPACED, "⇥") else count
    meanings = {each.program: each for each in rng.sample(_forms().meanings, count)}.values()
    is_opaque = rng.random() < _OPAQUE
    keys = rng.sample(parts["opaque"]["keys"], count)
    if not is_opaque:
        keys = [_spelled_key(rng, each) for each in meanings]
    if len(set(keys)) < len(meanings):
        return _template(rng, layout, draft)
    decimals, digits = None, ""
    if rng.random() < _ROUNDED and all(each.kind != "time" for each in meanings):
        decimals = rng.choice(sorted(parts["decimals"]))
        digits = rng.choice(parts["decimals"][decimals])
    texts, fields, notes = [], [], []
    for key, meaning in zip(keys, meanings, strict=False):
        text, line, note = _field(rng, key, meaning, layout, draft)
        is_rounded = decimals is not None and meaning.kind == "number" and "count" not in line
        texts.append(text)
        fields.append(line.replace("\ue005", f"round {decimals} " if is_rounded else ""))
        notes += [note] * bool(note)
        if is_opaque:
            notes.append(_explained(rng, key, meaning))
    opener = rng.choice(parts["openers"][layout.form])
    body = layout.around.replace("§", _joined(rng, texts, layout))
    text = opener.replace("§", body)
    more = [rng.choice((", ", "; ")).join(notes)] if notes else []
    more += [digits, rng.choice(parts["closers"]["any"])]
    for words in filter(None, more):
        text = f"{text}{'' if text[-1] in '.!?:' else rng.choice((', ', '. ', '. ', ' - '))}"
        text = f"{text.rstrip()} {words}"
    return text, f"record {' , '.join(fields)} end ; as {layout.form}"


def _spelled_key(rng: random.Random, meaning: Meaning) -> str:
    """Return a key as one of many habits spells it."""
    key = rng.choice(meaning.keys)
    drawn = rng.random()
    if drawn < 0.08:
        return key.upper()
    if drawn < 0.16 and "_" in key:
        first, *others = key.split("_")
        return first + "".join(part.capitalize() for part in others)
    if drawn < 0.2:
        return key.replace("_", "-")
    if drawn < 0.24:
        return key[0].upper() + key[1:]
    return rng.choice(("tactile_", "obj_", "my_", "m_")) + key if drawn < 0.28 else key


def _field(
    rng: random.Random, key: str, meaning: Meaning, layout: Layout, draft: Draft
) -> tuple[str, str, str]:
    """Return a field, its words in the line, and what is explained of it."""
    key_text, mark = draft.mark(key)
    line, note = f"{mark} \ue005{meaning.program}", ""
    style = layout.style
    if style == "said":
        value = rng.choice(meaning.phrases)
    elif style == "-":
        value = ""
    elif meaning.labels and rng.random() < _ALTERNATIVES:
        value, chosen, note = _alternatives(rng, meaning.labels, style, draft)
        line, note = f"{mark} {chosen}", note and f"{key}: {note}"
    else:
        value = _forms().parts["styles"][style][_KINDS.index(meaning.kind)]
        if meaning.kind == "bool" and style in ("angle", "bare", "mark") and rng.random() < 0.5:
            value = "<true|false>" if style == "angle" else "true|false"
    text = layout.field.replace("VALUE", value or "...")
    if "KEY" not in text:
        raise ValueError(f"the layout {layout.id} shows no key")
    text = text.replace("KEY", key_text, 1).replace("KEY", key)
    return text, line, note


def _alternatives(rng: random.Random, name: str, style: str, draft: Draft) -> tuple[str, str, str]:
    """Return labels between bars, their words in the line, and what each means if that is told."""
    labels = _forms().parts["labels"][name]
    row = rng.choice(labels["rows"]).split()
    texts, marks = zip(*map(draft.mark, row), strict=True)
    between = rng.choice(("|", "|", " | ", "/"))
    value = between.join(texts)
    if style == "quoted" or rng.random() < 0.3:
        value = f'"{value}"'
    elif style == "angle":
        value = f"<{value}>"
    line = f"choose {' | '.join(map(' '.join, zip(marks, labels['cases'], strict=True)))}"
    is_code = all(map(_NUMBER.fullmatch, row))
    phrases = [rng.choice(_phrases(each)) for each in labels["said"]]
    note = ", ".join(map(" = ".join, zip(row, phrases, strict=True)))
    return value, line, note if is_code or rng.random() < 0.2 else ""


def _explained(rng: random.Random, key: str, meaning: Meaning) -> str:
    pattern = rng.choice(_forms().parts["opaque"]["said"]).strip("§")
    return pattern.replace("KEY", key).replace("SAID", rng.choice(meaning.phrases))


def _joined(rng: random.Random, texts: list[str], layout: Layout) -> str:
    if layout.between == "comma":
        return _enumerated(rng, texts, ("and", "and", ","))
    between = layout.between
    if between in _SPACED:
        is_loose = layout.form in ("json", "dict", "pairs", "yaml", "tuple", "brackets")
        between = rng.choice((f"{between} ", between)) if is_loose else between
        between = " | " if between == "|" and rng.random() < 0.5 else between
    between = between or (" " if layout.form == "pairs" else rng.choice(("", " ")))
    return between.join(texts)


def _enumerated(rng: random.Random, texts: list[str], ends: tuple[str, ...]) -> str:
    """Return "a, b and c"."""
    *others, last = texts
    end = rng.choice(ends)
    joint = f"{end} " if end == "," else f" {end} "
    return f"{', '.join(others)}{joint}{last}" if others else last


# Labels


def _labelled(
    rng: random.Random, draft: Draft, is_code: bool | None
) -> tuple[list[str], list[str], str]:
    """Return labels as they stand in the text, what each says, and the choice among them.

    Args:
        rng: Draws them.
        draft: Of the text.
        is_code: Whether they are numbers; None for any.
    """
    sets = list(_forms().parts["labels"].values())
    while True:
        labels = rng.choice(sets)
        row = rng.choice(labels["rows"]).split()
        if is_code in (None, all(map(_NUMBER.fullmatch, row))):
            break
    phrases = [rng.choice(_phrases(each)) for each in labels["said"]]
    items = list(zip(row, phrases, labels["cases"], strict=True))
    if rng.random() < 0.4:
        items.sort(key=lambda item: item[0])
    elif rng.random() < 0.2:
        rng.shuffle(items)
    if len(items) > 2 and rng.random() < 0.15:
        items.pop()
    texts, cases = [], []
    for label, _, case in items:
        text, mark = draft.mark(label)
        texts.append(text)
        cases.append(f"{mark} {case}")
    return texts, [phrase for _, phrase, _ in items], f"choose {' | '.join(cases)}"


def _digits(rng: random.Random, way: str, draft: Draft) -> tuple[str, str]:
    texts, phrases, line = _labelled(rng, draft, True)
    return way.replace("LIST", _legend(rng, texts, phrases)), f"{line} ; as bare"


def _legend(rng: random.Random, texts: list[str], phrases: list[str]) -> str:
    joint = rng.choice((" = ", " = ", "=", ": ", " - ", " for ", " means "))
    parts = [f"{text}{joint}{phrase}" for text, phrase in zip(texts, phrases, strict=True)]
    return rng.choice((", ", ", ", "; ", "¶", " / ")).join(parts)


def _labels(rng: random.Random, way: str, draft: Draft) -> tuple[str, str]:
    texts, phrases, line = _labelled(rng, draft, False)
    listed = _enumerated(rng, texts, ("or", "and", ",", ","))
    if rng.random() < 0.25:
        listed = ", ".join(f'"{text}"' for text in texts)
    elif rng.random() < 0.2:
        listed = ", ".join(
            f"{text} ({phrase})" for text, phrase in zip(texts, phrases, strict=True)
        )
    return way.replace("LIST", listed), f"{line} ; as bare"


def _spelled(rng: random.Random, way: str, draft: Draft) -> tuple[str, str]:
    texts, phrases, line = _labelled(rng, draft, None)
    joint = rng.choice((" if ", " for ", " when ", " = "))
    parts = [f"{text}{joint}{phrase}" for text, phrase in zip(texts, phrases, strict=True)]
    return way.replace("LIST", _enumerated(rng, parts, ("and", ",", "or"))), f"{line} ; as bare"


def _tags(rng: random.Random, way: str, draft: Draft) -> tuple[str, str]:
    tag = rng.choice(("answer", "result", "verdict", "motion", "out", "reply", "class", "final"))
    first, mark = draft.mark(tag)
    texts, _, line = _labelled(rng, draft, False)
    parts = [f"<{first if not place else tag}>{text}</{tag}>" for place, text in enumerate(texts)]
    listed = _enumerated(rng, parts, ("or", ",", "or"))
    return way.replace("LIST", listed), f"record {mark} {line} end ; as tags"


def _bars(rng: random.Random, way: str, draft: Draft) -> tuple[str, str]:
    texts, _, line = _labelled(rng, draft, False)
    return way.replace("LIST", rng.choice(("|", "|", " | ", "/")).join(texts)), f"{line} ; as bare"


# Numbers and verdicts


def _number(rng: random.Random, way: str, draft: Draft) -> tuple[str, str]:
    numbers = [each for each in _forms().meanings if each.kind == "number"]
    meaning = rng.choice([each for each in numbers if "count" not in each.program])
    decimals = rng.choice(sorted(_forms().parts["decimals"]))
    text = way.replace("SAID", rng.choice(meaning.phrases))
    text = text.replace("DECIMALS", rng.choice(_forms().parts["decimals"][decimals]))
    return text, f"round {decimals} {meaning.program} ; as number"


def _condition(rng: random.Random, draft: Draft, *, is_joint: bool = True) -> tuple[str, str]:
    """Return a condition as it is phrases, and its words in the line."""
    line, *phrases = rng.choice(_forms().conditions)
    is_denied = rng.random() < 0.25
    text = rng.choice(_phrases(phrases[is_denied]))
    text, line = draft.filled(rng, text, line)
    if is_denied:
        line = line.removeprefix("not ") if line.startswith("not ") else f"not {line}"
    if not is_joint or rng.random() > _JOINT:
        return text, line
    other, more = _condition(rng, draft, is_joint=False)
    if more.split("\ue003")[0] == line.split("\ue003")[0]:
        return text, line
    joint, word = rng.choice(
        ((" and ", "and"), (", and ", "and"), (" but ", "and"), (" or ", "or"))
    )
    return f"{text}{joint}{other}", f"{word} {line} {more}"


def _truth(rng: random.Random, way: str, draft: Draft) -> tuple[str, str]:
    text, line = _condition(rng, draft)
    return way.replace("SAID", text), f"{line} ; as true-false"


def _bits(rng: random.Random, way: str, draft: Draft) -> tuple[str, str]:
    text, line = _truth(rng, way, draft)
    return text, line.replace("true-false", "one-zero")


def _verdict(rng: random.Random, way: str, draft: Draft) -> tuple[str, str]:
    first, second = rng.choice(_forms().parts["verdicts"]["pairs"]).split()
    at = (way.index("L1"), way.index("L2"))
    condition, line = _condition(rng, draft)
    for label, text in sorted(
        (("L1", first), ("L2", second)), key=lambda each: at[each[0] == "L2"]
    ):
        way = way.replace(label, draft.mark(text)[0], 1).replace(label, text)
    marks = draft.mark(first)[1], draft.mark(second)[1]
    text = way.replace("COND", condition)
    return text, f"choose {marks[0]} {line} | {marks[1]} other ; as bare"


_WRITERS: dict[str, Callable[[random.Random, Any, Draft], tuple[str, str]]] = {
    "template": _template, "digits": _digits, "labels": _labels, "spelled": _spelled,
    "tags": _tags, "bars": _bars, "number": _number, "truth": _truth, "bits": _bits,
    "verdict": _verdict,
}  # fmt: skip
