"""Write a `Query` as a line of words and read it back, word by word as a decoder emits them.

    query  := clause (";" clause)*
    clause := "fact" fact | [edit+ ">"] [subject+ ">"] ask | "as" form

A field of an ask that is left out is the usual one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from geotlm_lm.core.edit import EDIT_WORDS, Edit
from geotlm_lm.query import types as t
from geotlm_lm.query.facts import FACTS, read_fact, write_fact
from geotlm_lm.query.words import Malformed, Words, number_word

LABELS = (*"ABCDEF", *"123456")
_RELATIONS = {"more": ">", "less": "<", "about": "~", "between": "in-range"}
_UNIT_WORDS = tuple(unit for units in t.UNITS.values() for unit in units)


def _write_proposition(value: t.Proposition) -> list[str]:
    found: list[str] = []
    for at, literal in enumerate(value.literals):
        found += [value.joint] * (at > 0) + ["not"] * literal.denied + [literal.atom]
        if literal.bound is not None:
            numbers = (literal.bound.low, literal.bound.high)
            found.append(_RELATIONS[literal.bound.relation])
            found += [number_word(one) for one in numbers if one is not None]
    return found


def _read_proposition(words: Words) -> t.Proposition:
    literals, joint = [], None
    while True:
        denied = words.optional("not") is not None
        atom = words.take(*t.ATOMS)
        sign = None
        if words.slots or any(":" in one for one in words.words):
            sign = words.optional(*_RELATIONS.values())
        bound = None
        if sign is not None:
            relation = next(name for name, one in _RELATIONS.items() if one == sign)
            low = words.number()
            bound = t.Bound(relation, low, words.number() if relation == "between" else None)
        literals.append(t.Literal(atom, bound, denied))
        step = words.optional(*(("and", "or") if joint is None else (joint,)))
        if step is None:
            return t.Proposition(tuple(literals), joint or "and")
        joint = step


def _write_options(options: tuple[t.Option, ...]) -> list[str]:
    found: list[str] = []
    for at, option in enumerate(options):
        found += [","] * (at > 0) + ([option.label] if option.label else [])
        found += _write_proposition(option.proposition)
    return found


def _read_options(words: Words) -> tuple[t.Option, ...]:
    found = []
    while not found or words.optional(",") is not None:
        label = words.optional(*LABELS)
        other = words.optional(*t.OTHER_ATOMS)
        said = t.Proposition((t.Literal(other),)) if other else _read_proposition(words)
        found.append(t.Option(said, label))
    return tuple(found)


_FLAGS = {"denied": "excluded", "of_amount": "of-amount", "is_speed": "speed", "is_plain": "plain"}
_NAMES: dict[tuple[str, str], tuple[str, ...]] = {
    ("way", "of"): t.ASKED_ATOMS,
    ("amount", "of"): t.MEASURED_ATOMS,
    ("amount", "unit"): _UNIT_WORDS,
    ("amount", "per"): tuple(t.PER),
    ("amount", "measure"): ("path", "peak"),
    ("when", "edge"): ("begin", "end"),
    ("order", "of"): t.ATOMS,
    ("order", "then"): t.ATOMS,
    ("place", "half"): t.HALVES,
    ("compare", "relation"): t.RELATIONS,
    ("compare", "of"): ("kind", "way", "amount", *t.COMPONENT_ATOMS),
    ("recording", "topic"): t.TOPICS,
    ("setup", "topic"): t.SETTINGS,
    ("again", "unit"): _UNIT_WORDS,
    ("again", "mover"): ("object", "sensor"),
    ("talk", "topic"): t.TALK,
    ("unanswerable", "topic"): t.UNANSWERABLE,
}
"""What a field of an ask of a kind may be."""

_REQUIRED, _OF_ANSWERS = ("topic", "edge"), ("why", "how-sure")
"""Fields that are never left out; asks that need no proposition."""


def _write_ask(ask: t.Ask) -> list[str]:
    found = [ask.kind]
    for name in t.ASKS[ask.kind]:
        value = getattr(ask, name)
        if name in _FLAGS:
            found += [_FLAGS[name]] * value
        elif name == "options":
            found += _write_options(value)
        elif value is not None:
            found += _write_proposition(value) if name == "proposition" else [value]
    return found


def _read_ask(words: Words) -> t.Ask:
    kind = words.take(*t.ASKS)
    found: dict[str, Any] = {}
    for name in t.ASKS[kind]:
        if name in _FLAGS:
            found[name] = words.optional(_FLAGS[name]) is not None
        elif name == "options":
            found[name] = _read_options(words)
        elif name != "proposition":
            names = _NAMES[kind, name]
            found[name] = words.take(*names) if name in _REQUIRED else words.optional(*names)
        elif kind not in _OF_ANSWERS or words.has("not", *t.ATOMS):
            found[name] = _read_proposition(words)
    return t.Ask(kind, **found)


_CLIPS = {name: f"of-{name}" for name in t.CLIPS}
_PLACES = {name: f"at-{name}" for name in t.HALVES}
_TIMES = {name: f"in-{name}" for name in t.SPANS}


def _write_subject(subject: t.Subject) -> list[str]:
    found = [] if subject.clip is None else [_CLIPS[subject.clip]]
    found += [] if subject.half is None else [_PLACES[subject.half]]
    if (span := subject.span) is not None:
        numbers = [(word, one) for word, one in (("from", span.begin), ("to", span.end)) if one]
        found += [] if span.name is None else [_TIMES[span.name]]
        found += [text for word, one in numbers for text in (word, number_word(one))]
    return [*found, ">"] if found else []


def _read_subject(words: Words) -> t.Subject:
    def taken(names: dict[str, str]) -> str | None:
        word = words.optional(*names.values())
        return next((name for name, one in names.items() if one == word), None)

    start = words.at
    clip, half, name = taken(_CLIPS), taken(_PLACES), taken(_TIMES)
    times = ("from", "to") if words.slots or any(":" in one for one in words.words) else ()
    begin = words.number() if "from" in times and words.optional("from") else None
    end = words.number() if "to" in times and words.optional("to") else None
    span = t.Span(name, begin, end) if (name, begin, end) != (None,) * 3 else None
    if words.at > start:
        words.take(">")
    return t.Subject(clip, half, span)


MOST_SLOTS = 9
"""Quantities of a text that a query can point at."""

QUERY_WORDS = tuple(
    dict.fromkeys(
        (
            *(">", ";", ",", "as", "fact", "and", "or", "not", "from", "to"),
            *(f"#{place + 1}" for place in range(MOST_SLOTS)),
            *EDIT_WORDS,
            *(*_CLIPS.values(), *_PLACES.values(), *_TIMES.values()),
            *t.ASKS,
            *_FLAGS.values(),
            *(word for names in _NAMES.values() for word in names),
            *(*t.ATOMS, *t.OTHER_ATOMS, *_RELATIONS.values(), *LABELS),
            *FACTS,
            *(word for values, _ in FACTS.values() for word in values),
            *t.FORMS[1:],
        )
    )
)
"""Every word that a query may hold."""


def _read_part(words: Words) -> t.Part:
    edit = []
    while (word := words.optional(*EDIT_WORDS)) is not None:
        edit.append(word)
    if edit:
        words.take(">")
    subject = _read_subject(words)
    return t.Part(_read_ask(words), Edit.of(*edit), subject)


def _write_part(part: t.Part) -> list[str]:
    edit = [*part.edit.words, ">"] if part.edit.words else []
    return [*edit, *_write_subject(part.subject), *_write_ask(part.ask)]


def write(query: t.Query) -> str:
    """Return a query as its line of words."""
    clauses = [*map(write_fact, query.facts), *map(_write_part, query.parts)]
    if query.form != "sentence":
        clauses.append(["as", query.form])
    return " ; ".join(" ".join(clause) for clause in clauses)


def read(text: str, slots: int = MOST_SLOTS) -> t.Query:
    """Return the query of a line of words.

    Args:
        text: The line.
        slots: How many quantities the question holds.

    Raises:
        Malformed: If it is none.
    """
    return _read(text.split(), slots)


def _read(given: Sequence[str], slots: int) -> t.Query:
    words = Words(given, slots)
    facts: list[t.Fact] = []
    parts: list[t.Part] = []
    form = "sentence"
    while True:
        if not parts and words.optional("fact"):
            facts.append(read_fact(words))
        elif (parts or facts) and words.optional("as"):
            form = words.take(*t.FORMS[1:])
            break
        else:
            parts.append(_read_part(words))
        if words.optional(";") is None:
            break
    words.close()
    return t.Query(tuple(parts), tuple(facts), form)


def next_words(prefix: Sequence[str], slots: int) -> frozenset[str]:
    """Return the words that may follow a beginning, `END` among them where it is whole.

    Args:
        prefix: Words so far.
        slots: How many quantities the question holds.

    Raises:
        Malformed: If no query begins so.
    """
    words = [*prefix, ""]  # no word: whatever could stand here is what is missed
    try:
        _read(words, slots)
    except Malformed as missed:
        if missed.at == len(prefix):
            return missed.expected
        raise
    raise AssertionError("an empty word was read")
