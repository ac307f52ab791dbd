"""Write (text, query) pairs from data_templates/query, the same ones from the same seed.

Whole families of phrasings are held out: a pair of the "test" split has a question, or a clause
around it, of a family that no other split writes. `.ci/grammar.py` shows what is written.
"""

from __future__ import annotations

import hashlib
import json
import math
import random
import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

from geotlm_lm.core.files import training_templates
from geotlm_lm.query.copied import copied
from geotlm_lm.query.lines import normal, read, write
from geotlm_lm.query.program import (
    MOST_COPIED,
    MOST_SLOTS,
    TRAITS,
    TWO_CLIPS,
    head_of,
    type_of,
)
from geotlm_lm.query.quantities import find
from geotlm_lm.training.clauses import (
    TWICE,
    VIEWS,
    Around,
    Clause,
    Family,
    chosen_clauses,
    listed,
    may_join,
    topic_of,
)

_FILES = (
    *("ways", "claims", "choices", "amounts", "times", "about", "statements", "more", "own"),
    "clauses",
)
_PLACES = ("before", "after", "alone", "alone_after")
_FIELD = re.compile(r"\{([\w-]+?)(\d?)\}")
_CHOICE = re.compile(r"\[([^\[\]]*\|[^\[\]]*)\]|\{([^{}]*\|[^{}]*)\}")
_MARK = re.compile("\ue000(\\d+)\ue001(.*?)\ue002", re.DOTALL)
_MARKS = ".!?"
_MISTYPED = re.compile(r"[^\W\d_\ue000-\ue003]{4,}")
_KEPT = ("left", "right", "down", "turn", "clockwise", "counterclockwise", "anticlockwise")
"""Words that a slip might turn into others."""
SPLITS = ("train", "validation", "test")

_SEEN = ("bool", "number", "way", "label")
"""Types of what a point of view may be put around."""
_OF_ALL = ("fact", "manner", "noise")
"""Kinds of clauses that hold for whatever questions follow."""
LEAST_FAMILIES = 25
"""A kind is drawn by the root of its number of families, or of this where it has fewer."""


@dataclass(frozen=True)
class Pair:
    """A text and its meaning.

    Args:
        text: As somebody may type it.
        query: The normal line of its program, numbers and copied words as slots.
        families: Of the question and of every clause.
    """

    text: str
    query: str
    families: tuple[str, ...]


@dataclass
class _Draft:
    """A text in the making: values bound by its fields, numbers by their marks."""

    values: dict[str, str] = field(default_factory=dict)
    numbers: int = 0
    least: float = 0.0
    copied: list[str] = field(default_factory=list)


class Grammar:
    """The templates, clauses and words of data_templates/query.

    Raises:
        ValueError: If a template names a field that no word list fills.
    """

    def __init__(self) -> None:
        folder = training_templates() / "query"
        paths = [
            *(folder / f"{name}.toml" for name in _FILES),
            *sorted(folder.glob("voices/*.toml")),
        ]
        files = [tomllib.loads(path.read_text(encoding="utf-8")) for path in paths]
        self.words: dict[str, Any] = {}
        for part_ in (tomllib.loads((folder / "lexicon.toml").read_text()), *files):
            plain = {key: part for key, part in part_.items() if isinstance(part, dict)}
            self.words |= plain.pop("words", {})
            self.words |= plain
            self.words |= {part["name"]: part for part in part_.get("quantity", ())}
        rows = [part_ for file in files for part_ in file.get("family", ())]
        self.families = [family for row in rows for family in _families(row)]
        self.clauses = [_clause(part_) for file in files for part_ in file.get("clause", ())]
        self.families += _families_of(self.clauses)
        self._check()

    def _check(self) -> None:
        texts = [text for item in self.families for text in (*item.texts, item.query)]
        texts += [text for item in self.clauses for lines in item.texts.values() for text in lines]
        fields = {match[1] for text in texts for match in _FIELD.finditer(text)}
        missing = fields - self.words.keys()
        if missing:
            raise ValueError(f"templates name fields that no list fills: {sorted(missing)}")

    def pairs(self, seed: int, split: str | None = None) -> Iterator[Pair]:
        """Yield pairs without end.

        Args:
            seed: Of everything that is drawn.
            split: One of `SPLITS`; None for all families alike.
        """
        rng = random.Random(f"{seed}/{split}")
        kinds: dict[str, list[Family]] = {"fact": []}
        for item in self.families:
            if split in (None, split_of(item.id)):
                kinds.setdefault(kind_of(item.query), []).append(item)
        clauses = [item for item in self.clauses if split in (None, "test") or _may(item, split)]
        names = sorted(kinds)
        shares = [math.sqrt(max(len(kinds[kind]), LEAST_FAMILIES)) for kind in names]
        while True:
            family, *others = (
                rng.choice(kinds[kind] or [None]) for kind in rng.choices(names, shares, k=3)
            )
            pair = self._pair(rng, family, others, clauses)
            if pair is not None:
                yield pair

    def wordings(self, seed: int, split: str, query: str) -> Iterator[Pair]:
        """Yield questions without end that mean `query`, with nothing around them.

        Args:
            seed: Of everything that is drawn.
            split: One of `SPLITS`.
            query: The pattern that families of the split mean.
        """
        rng = random.Random(f"{seed}/{split}/{query}")
        families = [
            item for item in self.families if item.query == query and split_of(item.id) == split
        ]
        while True:
            pair = self._pair(rng, rng.choice(families), [], [])
            if pair is not None:
                yield pair

    def surrounded(self, rng: random.Random, pair: Pair) -> Pair:
        """Return a labelled question with clauses of the training split around it.

        A question that has numbers, parts or a point of view of its own is returned as it is.
        """
        if any(mark in pair.query for mark in "#@;") or any(mark in pair.text for mark in "{["):
            return pair
        plain = pair.text.rstrip("?.! ")
        end = pair.text[len(plain) :].strip() or ("" if pair.text == plain else ".")
        (asked,) = read(pair.query).answers or (None,)
        is_complete = asked is None or head_of(asked).word in TWO_CLIPS or type_of(asked) == "talk"
        is_seen = asked is not None and type_of(asked) in _SEEN
        family = Family(pair.families[0], pair.query, (plain,), end, is_seen, is_complete)
        clauses = [clause for clause in self.clauses if split_of(clause.id) == "train"]
        return self._pair(rng, family, [], clauses) or pair

    def _pair(
        self,
        rng: random.Random,
        family: Family | None,
        others: list[Family | None],
        clauses: list[Clause],
    ) -> Pair | None:
        around = Around()
        draft, used = _Draft(), []
        if family is None:
            facts = [each for each in clauses if each.kind == "fact" and "alone" in each.texts]
            chosen = rng.sample(facts, rng.choice((1, 1, 1, 2)))
            if len({topic_of(each) for each in chosen}) < len(chosen):
                return None
        else:
            used = [family.id]
            around.text = self._filled(rng, rng.choice(family.texts), draft)
            around.end = _end(around.text, family)
            around.query = self._meant(family.query, draft)
            chosen = [] if family.complete else chosen_clauses(rng, family, clauses)
        for clause in chosen:
            place = "alone" if family is None else rng.choice(sorted(clause.texts))
            words = self._filled(rng, rng.choice(clause.texts[place]), draft)
            around.add(rng, clause.kind, place, words, self._meant(clause.query, draft))
            used.append(clause.id)
        text, query = around.joined(rng)
        if family and all(each.kind in _OF_ALL for each in chosen):
            questions, numbers = [text], draft.numbers
            for other in others:
                if other is None or not may_join(family, other) or rng.random() >= TWICE:
                    break
                next_ = _Draft(numbers=numbers)
                words = self._filled(rng, rng.choice(other.texts), next_)
                questions, numbers = [*questions, f"{words}{_end(words, other)}"], next_.numbers
                query, used = f"{query} ; {self._meant(other.query, next_)}", [*used, other.id]
            if len(questions) > 1:
                text = listed(rng, questions, is_bare=not chosen)
        return numbered(_roughened(rng, text), query, tuple(used))

    def _filled(self, rng: random.Random, text: str, draft: _Draft) -> str:
        """Return a template with its alternatives drawn and its fields filled."""
        while (match := _CHOICE.search(text)) or (match := _FIELD.search(text)):
            if match.re is _CHOICE:
                new = rng.choice((match[1] or match[2]).split("|"))
            else:
                new = self._word(rng, match[1], match[2], draft)
            text = f"{text[: match.start()]}{new}{text[match.end() :]}"
        return re.sub(r"  +", " ", text).strip()

    def _word(self, rng: random.Random, name: str, place: str, draft: _Draft) -> str:
        words = self.words[name]
        if isinstance(words, list):
            return rng.choice(words)
        if "forms" in words:
            draft.numbers += 1
            mark = "\ue004" if words.get("copied") else "\ue003"
            draft.values[f"{name}{place}"] = f"{mark}{draft.numbers}"
            if words.get("copied"):
                taken = draft.copied
                value = rng.choice([each for each in words["values"] if each not in taken])
                draft.copied.append(value)
                form = rng.choice(words["forms"]).replace("#", value)
                return f"\ue000{draft.numbers}\ue001{form}\ue002"
            # The second of two numbers is the larger: spans and ranges run upwards.
            offered = [each for each in words["values"] if not place or each > draft.least]
            value = rng.choice(offered or [2 * words["values"][-1]])
            draft.least = max(value, draft.least)
            form = rng.choice(words["forms"]).replace("#", f"{value:g}")
            return f"\ue000{draft.numbers}\ue001{form}\ue002"
        key = f"{name}{place}"
        taken = {
            value for other, value in draft.values.items() if other.rstrip("0123456789") == name
        }
        if key not in draft.values:
            draft.values[key] = rng.choice([each for each in words if each not in taken])
        return rng.choice(words[draft.values[key]])

    def _meant(self, query: str, draft: _Draft) -> str:
        while _FIELD.search(query):
            query = _FIELD.sub(lambda match: draft.values[f"{match[1]}{match[2]}"], query)
        return query


def numbered(text: str, line: str, families: tuple[str, ...]) -> Pair | None:
    """Return a pair with its numbers as slots; None where one is not found again, or too late."""
    spans: dict[str, tuple[int, int]] = {}
    plain, at = "", 0
    for match in _MARK.finditer(text):
        plain += text[at : match.start()]
        spans[match[1]] = (len(plain), len(plain) + len(match[2]))
        plain, at = plain + match[2], match.end()
    plain += text[at:]
    if not plain.strip("?.! "):
        return None
    offered = {"\ue003": find(plain)[:MOST_SLOTS], "\ue004": copied(plain)[:MOST_COPIED]}
    for number, (start, end) in spans.items():
        for mark, slot in (("\ue003", "#"), ("\ue004", "@")):
            wanted = re.compile(f"{mark}{number}(?!\\d)")
            if not wanted.search(line):
                continue
            places = [
                place
                for place, each in enumerate(offered[mark], 1)
                if each.start < end and start < each.end
            ]
            if len(places) != 1:
                return None
            line = wanted.sub(f"{slot}{places[0]}", line)
    return Pair(plain, write(normal(read(line))), families)


def _roughened(rng: random.Random, text: str) -> str:
    """Return a text as somebody may have typed it; marks of numbers stay whole."""
    text = text[:1].upper() + text[1:] if rng.random() < 0.6 else text
    drawn = rng.random()
    if drawn < 0.12:
        text = text.rstrip("?.")
    elif drawn < 0.16:
        text = text.lower()
    elif drawn < 0.18:
        text = text.replace("?", " ?")
    elif drawn < 0.2:
        text = text.upper()
    if rng.random() < 0.15:
        text = _with_slip(rng, text)
    return text


def _with_slip(rng: random.Random, text: str) -> str:
    """Return a text with one word misspelt: two letters swapped, one lost, doubled or changed."""
    numbers = [match.span() for match in re.finditer("\ue000.*?\ue002", text)]
    words = [
        match
        for match in _MISTYPED.finditer(text)
        if match[0].lower() not in _KEPT
        and not any(start <= match.start() < end for start, end in numbers)
    ]
    if not words:
        return text
    match = rng.choice(words)
    word = match[0]
    at = rng.randrange(1, len(word) - 1)
    slips = (
        word[:at] + word[at + 1] + word[at] + word[at + 2 :],
        word[:at] + word[at + 1 :],
        word[:at] + word[at] + word[at:],
        word[:at] + rng.choice("aeinorst") + word[at + 1 :],
    )
    return text[: match.start()] + rng.choice(slips) + text[match.end() :]


def kind_of(query: str) -> str:
    """Return the kind of a pattern, by which it is drawn: the first word of its first answer.

    Of what is so or not it is "claim"; of facts alone "fact".
    """
    answers = [part for part in query.split(" ; ") if part.split()[0] not in ("fact", "as")]
    if not answers:
        return "fact"
    words = [word for word in answers[0].split() if word not in VIEWS]
    return "claim" if words[0] in TRAITS or words[0].startswith("{") else words[0]


_FIXED = {"train": "train", "held": "validation", "blind": "test"}
"""Splits that a family names by the end of its id."""


def split_of(family: str) -> str:
    """Return the split that a family belongs to: by a hash of its id, four in five to train.

    Where a kind has few families their ids end in ".train", ".held" (validation) or ".blind".
    """
    named = _FIXED.get(family.rpartition(".")[2])
    place = int.from_bytes(hashlib.sha256(family.encode()).digest()[:4]) % 20
    return named or ("test" if place < 2 else "validation" if place < 4 else "train")


def corpus(split: str) -> list[Pair]:
    """Return the questions of a split that were written and labelled one by one.

    Questions that begin alike and ask alike are a family; what askers who had seen no template
    wrote and labelled themselves is all for training.
    """
    folder = training_templates() / "query"
    pairs = []
    for name in ("corpus", "askers"):
        for line in (folder / f"{name}.jsonl").read_text(encoding="utf-8").splitlines():
            row = json.loads(line)
            begins = " ".join(row["text"].lower().split()[:3])
            family = f"{name}/{kind_of(row['query'])} {begins}"
            if split == ("train" if name == "askers" else split_of(family)):
                pairs.append(Pair(row["text"], row["query"], (family,)))
    return pairs


def _may(clause: Clause, split: str) -> bool:
    return split_of(clause.id) != "test" or split == "test"


def _families(row: dict[str, Any]) -> Iterator[Family]:
    """Yield the family of a row, or one of each of its lines, which then ends with its own mark."""
    texts = tuple(line for line in row["texts"].strip().splitlines() if line.strip())
    if not row.get("each"):
        yield Family(**row | {"texts": texts})
        return
    plain = {name: value for name, value in row.items() if name != "each"}
    name, dot, split = row["id"].partition(".")
    for place, line in enumerate(texts, 1):
        text = line.rstrip(_MARKS)
        own = {"id": f"{name}-{place}{dot}{split}", "texts": (text,)}
        end = line[len(text) :] or row.get("end", Family.end)
        yield Family(**plain | own | {"end": end})


def _end(text: str, family: Family) -> str:
    return "" if text.endswith(tuple(_MARKS)) else family.end


def _clause(row: dict[str, Any]) -> Clause:
    texts = {place: tuple(row[place].strip().splitlines()) for place in _PLACES if place in row}
    return Clause(row["id"], row["kind"], row["query"], texts, row.get("by_itself", ""))


def _families_of(clauses: list[Clause]) -> Iterator[Family]:
    """Yield clauses that may stand by themselves as families, each of the split of its clause."""
    ends = {split: end for end, split in _FIXED.items()}
    for clause in clauses:
        if clause.by_itself:
            name = f"{clause.by_itself}/{clause.id}.{ends[split_of(clause.id)]}"
            yield Family(name, clause.by_itself, clause.texts["alone"], ".", complete=True)


@lru_cache(maxsize=1)
def grammar() -> Grammar:
    """Return the grammar, read once."""
    return Grammar()
