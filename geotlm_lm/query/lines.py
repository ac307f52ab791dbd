"""A program as a line of words, written and read back.

Arguments stand behind their primitive, so a line reads from the left without brackets, and at each
place it is known which words may follow: a decoder writes well-formed programs only.

    program := clause (";" clause)*
    clause  := "fact" fact | answer | "as" form
    within final #1 contact > speed turn #2   "in the last 0.2 s of contact, faster than 30 deg/s?"

`#k` is the k-th number of the question, `@k` the k-th of its words that may be copied.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from geotlm_lm.core.edit import EDIT_WORDS, Edit
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.twist import Component
from geotlm_lm.query.program import (
    ACCEPTED,
    AROUND,
    BETWEEN,
    COMPARED,
    COMPONENT,
    END_OF_FIELDS,
    FORMS,
    LABELS,
    MOST_COPIED,
    MOST_SLOTS,
    NAMES,
    OTHERS,
    OVER_EVENTS,
    UNITS,
    Argument,
    Case,
    Expression,
    Fact,
    Field,
    Number,
    Program,
    Quantity,
    Slot,
    Text,
    of,
    with_parts,
)

END = "<end>"
"""Stands among the next words where a program may end."""

FACTS: dict[str, tuple[tuple[str, ...], int]] = {
    "mirrored": ((), 0),
    "turned": (("half", "quarter-cw", "quarter-ccw"), 0),
    "seen": (("sensor", "object"), 0),
    "moves": (("sensor", "object"), 0),
    "thread": (("left", "right"), 0),
    "side": (("head", "shank", "side"), 0),
    "scale": ((), 1),
    "view": ((), 1),
    "rate": ((), 1),
    "everything": ((), 0),
    "unclear": (("turned", "mirrored", "thread", "side", "other"), 0),
}
"""Name of a fact -> its settings and how many quantities it has.

"turned" is how the recorded image is; "scale" mm per pixel or pixels per mm, "view" the width that
the frames show, "rate" frames per second; "unclear" is one that was not understood."""


class Malformed(UsageError):
    """A line is no program: the word that stands there and those that could."""

    def __init__(self, words: Sequence[str], at: int, expected: Sequence[str]) -> None:
        given = repr(words[at]) if at < len(words) else "nothing more"
        super().__init__(
            f"A query had {given} after {' '.join(words[:at])!r}, expected one of "
            f"{', '.join(sorted(expected))}; write one of these there."
        )
        self.at, self.expected = at, frozenset(expected)


def write(program: Program) -> str:
    """Return a program as its line of words."""
    clauses = [" ".join(_fact_words(fact)) for fact in program.facts]
    clauses += map(written, program.answers)
    if program.form != "sentence":
        clauses.append(f"as {program.form}")
    return " ; ".join(clauses)


def written(expression: Expression) -> str:
    """Return one expression as its words."""
    return " ".join(_words_of(expression))


def _fact_words(fact: Fact) -> Iterator[str]:
    yield from ("fact", *["not"] * fact.denied, fact.name)
    if fact.value is not None:
        yield fact.value
    yield from map(_constant, fact.numbers)


def _words_of(value: Argument) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, tuple):
        is_fields = isinstance(value[0], Field)
        for place, item in enumerate(value):
            if place:
                yield BETWEEN["fields" if is_fields else "cases"]
            label, inner = (item.key, item.answer) if is_fields else (item.label, item.holds)
            if label is not None:
                yield _constant(label)
            yield from _words_of(inner)
        if is_fields:
            yield END_OF_FIELDS
    elif value.value is not None:
        yield _constant(value.value)
    else:
        yield value.word
        for argument in value.arguments:
            yield from _words_of(argument)


def _constant(value: str | Number | Text) -> str:
    """Return a constant as it is read: "#2", "12.5:deg", "@1", or a plain word."""
    if isinstance(value, Quantity):
        return f"{value.value!r}:{value.unit}"
    return value if isinstance(value, str) else f"{'@#'[isinstance(value, Slot)]}{value.index}"


def read(line: str, slots: int = MOST_SLOTS, texts: int = MOST_COPIED) -> Program:
    """Return the program of a line of words.

    Args:
        line: The words.
        slots: How many quantities the question holds.
        texts: How many of its words may be copied.

    Raises:
        Malformed: If it is none.
    """
    return _Line(line.split(), slots, texts).program()


def begun(
    prefix: Sequence[str], slots: int, texts: int = 0
) -> tuple[frozenset[str], tuple[str, tuple[Argument, ...]] | None]:
    """Return the words that may follow, and the innermost primitive that lacks an argument.

    `END` is among them where the beginning is whole. The primitive comes with the arguments it has;
    None where none is open.

    Raises:
        Malformed: If no program begins so.
    """
    line = _Line([*prefix, ""], slots, texts)  # no word: what could stand here is what is missed
    try:
        line.program()
    except Malformed as missed:
        if missed.at == len(prefix):
            word, arguments = line.open[-1] if line.open else (None, ())
            return missed.expected, None if word is None else (word, tuple(arguments))
        raise
    raise AssertionError("an empty word was read")


class _Line:
    """Words read from the left; remembers what could have stood at the present place."""

    def __init__(self, words: Sequence[str], slots: int, texts: int) -> None:
        self.words, self.at = words, 0
        self.slots = tuple(f"#{place + 1}" for place in range(slots))
        self.texts = tuple(f"@{place + 1}" for place in range(texts))
        self.open: list[tuple[str, list[Argument]]] = []  # primitives that lack an argument yet
        self.expected: set[str] = set()

    @property
    def next(self) -> str:
        """The next word; "" at the end."""
        return self.words[self.at] if self.at < len(self.words) else ""

    def has(self, *names: str) -> bool:
        """Tell whether one of some words is next."""
        self.expected.update(names)
        return self.next in names

    def has_number(self) -> bool:
        """Tell whether a slot, or a quantity written out, is next."""
        return self.has(*self.slots) or ":" in self.next

    def take(self, *names: str) -> str:
        """Return the next word, which must be one of some."""
        if not self.has(*names):
            raise Malformed(self.words, self.at, sorted(self.expected))
        self.at, self.expected = self.at + 1, set()
        return self.words[self.at - 1]

    def optional(self, *names: str) -> str | None:
        """Return the next word if it is one of some."""
        return self.take(*names) if self.has(*names) else None

    def number(self) -> Number:
        """Return a slot, or a quantity written out as "12.5:deg"."""
        if ":" in self.next:
            value, _, unit = self.next.partition(":")
            self.at, self.expected = self.at + 1, set()
            return Quantity(float(value), unit)
        return Slot(int(self.take(*self.slots)[1:]))

    def program(self) -> Program:
        facts: list[Fact] = []
        answers: list[Expression] = []
        form = "sentence"
        while True:
            if not answers and self.optional("fact"):
                facts.append(self.fact())
            elif (answers or facts) and self.optional("as"):
                form = self.take(*FORMS[1:])
                break
            else:
                answers.append(self.value("answer"))
            if self.optional(";") is None:
                break
        if self.at < len(self.words):
            raise Malformed(self.words, self.at, sorted({*self.expected, END}))
        return Program(tuple(answers), tuple(facts), form)

    def fact(self) -> Fact:
        denied = self.optional("not") is not None
        has_numbers = self.slots or any(":" in word for word in self.words)
        names = [name for name, (_, count) in FACTS.items() if has_numbers or not count or denied]
        name = self.take(*names)
        values, count = FACTS[name]
        value = self.optional(*values) if denied else self.take(*values) if values else None
        numbers = () if denied else tuple(self.number() for _ in range(count))
        return Fact(name, value, numbers, denied)

    def value(self, wanted: str) -> Argument:
        if wanted in BETWEEN:
            read_item, items = {"cases": self.case, "fields": self.field}[wanted], []
            while not items or self.optional(BETWEEN[wanted]) is not None:
                items.append(read_item())
            if wanted == "fields":
                self.take(END_OF_FIELDS)
            return tuple(items)
        if wanted in ("number", "answer") and self.has_number():
            return Expression("#", (), self.number())
        accepted = ACCEPTED[wanted]
        word = self.take(*accepted)
        if wanted in NAMES:
            return word
        arguments: list[Argument] = []
        self.open.append((word, arguments))
        for type_ in accepted[word]:
            arguments.append(self.value(type_))
        self.open.pop()
        return Expression(word, tuple(arguments))

    def case(self) -> Case:
        label: str | Number | Text | None = self.optional(*LABELS, *self.texts)
        if label is None and self.has_number():
            label = self.number()
        elif label is not None and label.startswith("@"):
            label = Text(int(label[1:]))
        other = self.optional(*OTHERS)
        return Case(Expression(other) if other else self.value("bool"), label)

    def field(self) -> Field:
        key = self.optional(*self.texts)
        return Field(self.value("answer"), None if key is None else Text(int(key[1:])))


PROGRAM_WORDS = tuple(
    dict.fromkeys(
        (
            *(";", *BETWEEN.values(), END_OF_FIELDS, "as", "fact", "not"),
            *(f"#{place + 1}" for place in range(MOST_SLOTS)),
            *(f"@{place + 1}" for place in range(MOST_COPIED)),
            *(word for words in ACCEPTED.values() for word in words),
            *(*LABELS, *OTHERS),
            *FACTS,
            *(word for values, _ in FACTS.values() for word in values),
            *FORMS[1:],
        )
    )
)
"""Every word that a program may hold."""


# Which numbers of a question may stand where: beside an angle stands one, a span is a time

_ANY = ("", "percent")
_TIMES = (*UNITS["time"], *_ANY)
_LENGTHS = (*UNITS["length"], *_ANY)
_SIZES = (*UNITS["length"], "")
_OF_TIME = ("t", "initial", "final", "later", "earlier", "around")
_INSIDE = ("within", "at", "abs", "negate", "round", "nearest", "low", "high", "sigma", "floor",
           "ceil", *OVER_EVENTS)  # fmt: skip
_UNITS_OF = {
    **dict.fromkeys(("length", "lasts", "time-while", "delay", "clock"), _TIMES),
    **dict.fromkeys(("share", "percent-of", "area", "chance", "place-x", "place-y"), _ANY),
    "count": ("", "turn"),  # "three turns"
}
"""Units of what is measured of no motion."""


def fitting(prefix: Sequence[str], quantities: Sequence[Quantity], texts: int = 0) -> set[str]:
    """Return the next words of a program without those whose number cannot be meant there.

    Args:
        prefix: Words so far.
        quantities: Of the question, as slots count them.
        texts: How many of its words may be copied.
    """
    allowed, open_ = begun(prefix, len(quantities), texts)
    words, last = set(allowed), prefix[-1] if prefix else ""
    if last == "fact":
        is_length = any(_fits(quantity, _SIZES) for quantity in quantities)
        return words if is_length else words - {"scale", "view"}
    units = _SIZES if last in ("scale", "view") else None
    if units is None and open_ is not None:
        units = _wanted(*open_)
    slots = {word for word in words if word.startswith("#")}
    if units is None or not slots:
        return words
    fit = {word for word in slots if _fits(quantities[int(word[1:]) - 1], units)}
    return (words - slots) | (fit or slots)


def _wanted(word: str, arguments: Sequence[Expression]) -> tuple[str, ...] | None:
    """Return the units that the next number of a primitive may have; None where any will do."""
    if word in _OF_TIME:
        return _TIMES
    if word not in (*COMPARED, "+", "-", "percent-of") or not arguments:
        return None
    return units_of(arguments[0])


def units_of(measured: Expression) -> tuple[str, ...] | None:
    """Return the units that a number may be told in; None where that is not known."""
    while measured.word in _INSIDE:
        measured = measured.arguments[-1]
    if measured.word == "unit":
        kind = next(units for units in UNITS.values() if measured.arguments[0] in units)
        return (*kind, *_ANY)
    if measured.word not in ("amount", "net", "path", "peak", "limit"):
        return _UNITS_OF.get(measured.word)
    component = COMPONENT.get(measured.arguments[0])
    if component is None:
        return None
    return (*UNITS["angle"], *_ANY) if component is Component.TURN else _LENGTHS


def _fits(quantity: Quantity, units: Sequence[str]) -> bool:
    top, _, per = quantity.unit.partition("/")
    # Of "1 px = 0.04 mm" the pixel is no size; of "20 px per mm" it is a part.
    is_size = units is _SIZES
    is_part = is_size and per != "" and per in units
    return not (is_size and quantity.unit == "px") and (top in units or is_part)


def _without_unit(measured: Expression) -> Expression:
    """Return what is measured without the unit that it is told in."""
    if measured.word == "unit":
        return _without_unit(measured.arguments[1])
    if measured.word not in ("round", *AROUND):
        return measured
    *outer, inner = measured.arguments
    return of(measured.word, *outer, _without_unit(inner))


def normal(value: Any) -> Any:
    """Return a program, or a part of one, in the words that all who mean the same share.

    A run of views is in its shortest words: one that is taken back at once is none. Degrees are not
    named, in which angles are told anyway, a unit takes the place of one inside it, and a speed's
    unit of time stands before that of its way.
    """
    value = with_parts(value, normal)
    if isinstance(value, Expression) and value.word == "unit":
        unit, measured = value.arguments
        if (bare := _without_unit(measured)) != measured:
            return normal(of("unit", unit, bare))
        if measured.word == "per":
            time, way = measured.arguments
            return of("per", time, normal(of("unit", unit, way)))
        is_angle = (units_of(measured) or ("",))[0] in UNITS["angle"]
        return measured if unit == "deg" and is_angle else value
    words, inner = [], value
    while isinstance(inner, Expression) and inner.word in EDIT_WORDS:
        words.append(inner.word)
        (inner,) = inner.arguments
    for word in reversed(Edit.of(*words).words if words else ()):
        inner = of(word, inner)
    return inner if words else value
