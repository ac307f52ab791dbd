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

from geotlm_lm.query.facts import FACTS, read_fact, write_fact
from geotlm_lm.query.program import (
    ACCEPTED,
    BETWEEN,
    END_OF_FIELDS,
    FORMS,
    LABELS,
    MOST_SLOTS,
    NAMES,
    OTHERS,
    Argument,
    Case,
    Expression,
    Field,
    Program,
    Text,
)
from geotlm_lm.query.types import Fact, Quantity, Slot
from geotlm_lm.query.words import Malformed, Words, number_word


def write(program: Program) -> str:
    """Return a program as its line of words."""
    clauses = [*map(write_fact, program.facts)]
    clauses += [list(_written(answer)) for answer in program.answers]
    if program.form != "sentence":
        clauses.append(["as", program.form])
    return " ; ".join(" ".join(clause) for clause in clauses)


def written(expression: Expression) -> str:
    """Return one expression as its words."""
    return " ".join(_written(expression))


def _written(value: Argument) -> Iterator[str]:
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
            yield from _written(inner)
        if is_fields:
            yield END_OF_FIELDS
    elif value.value is not None:
        yield _constant(value.value)
    else:
        yield value.word
        for argument in value.arguments:
            yield from _written(argument)


def _constant(value: str | Slot | Quantity | Text) -> str:
    if isinstance(value, Text):
        return f"@{value.index}"
    return value if isinstance(value, str) else number_word(value)


def read(line: str, slots: int = MOST_SLOTS, texts: int = MOST_SLOTS) -> Program:
    """Return the program of a line of words.

    Args:
        line: The words.
        slots: How many quantities the question holds.
        texts: How many of its words may be copied.

    Raises:
        Malformed: If it is none.
    """
    return _read(Words(line.split(), slots), texts)


def begun(
    prefix: Sequence[str], slots: int, texts: int = 0
) -> tuple[frozenset[str], tuple[str, tuple[Argument, ...]] | None]:
    """Return the words that may follow, and the innermost primitive that lacks an argument.

    `words.END` is among them where the beginning is whole. The primitive comes with the arguments
    it has; None where none is open.

    Raises:
        Malformed: If no program begins so.
    """
    words = Words([*prefix, ""], slots)  # no word: whatever could stand here is what is missed
    try:
        _read(words, texts)
    except Malformed as missed:
        if missed.at == len(prefix):
            word, arguments = words.open[-1] if words.open else (None, ())
            return missed.expected, None if word is None else (word, tuple(arguments))
        raise
    raise AssertionError("an empty word was read")


def _read(words: Words, texts: int) -> Program:
    facts: list[Fact] = []
    answers: list[Expression] = []
    form = "sentence"
    while True:
        if not answers and words.optional("fact"):
            facts.append(read_fact(words))
        elif (answers or facts) and words.optional("as"):
            form = words.take(*FORMS[1:])
            break
        else:
            answers.append(_read_value(words, "answer", texts))
        if words.optional(";") is None:
            break
    words.close()
    return Program(tuple(answers), tuple(facts), form)


def _read_value(words: Words, wanted: str, texts: int) -> Argument:
    if wanted in ("cases", "fields"):
        reader, items = {"cases": _read_case, "fields": _read_field}[wanted], []
        while not items or words.optional(BETWEEN[wanted]) is not None:
            items.append(reader(words, texts))
        if wanted == "fields":
            words.take(END_OF_FIELDS)
        return tuple(items)
    accepted = ACCEPTED[wanted]
    is_number = wanted in ("number", "answer")
    if is_number and (words.has(*_slots(words)) or ":" in words.next):
        return Expression("#", (), words.number())
    word = words.take(*accepted)
    if wanted in NAMES:
        return word
    arguments: list[Argument] = []
    words.open.append((word, arguments))
    for each in accepted[word]:
        arguments.append(_read_value(words, each, texts))
    words.open.pop()
    return Expression(word, tuple(arguments))


def _slots(words: Words) -> tuple[str, ...]:
    return tuple(f"#{place + 1}" for place in range(words.slots))


def _copied(texts: int) -> tuple[str, ...]:
    return tuple(f"@{place + 1}" for place in range(texts))


def _read_case(words: Words, texts: int) -> Case:
    label: str | Slot | Quantity | Text | None = words.optional(*LABELS, *_copied(texts))
    if label is None and (words.has(*_slots(words)) or ":" in words.next):
        label = words.number()
    elif label is not None and label.startswith("@"):
        label = Text(int(label[1:]))
    other = words.optional(*OTHERS)
    return Case(Expression(other) if other else _read_value(words, "bool", texts), label)


def _read_field(words: Words, texts: int) -> Field:
    key = words.optional(*_copied(texts))
    return Field(_read_value(words, "answer", texts), None if key is None else Text(int(key[1:])))


PROGRAM_WORDS = tuple(
    dict.fromkeys(
        (
            *(";", *BETWEEN.values(), END_OF_FIELDS, "as", "fact", "not"),
            *(f"{mark}{place + 1}" for mark in "#@" for place in range(MOST_SLOTS)),
            *(word for words in ACCEPTED.values() for word in words),
            *(*LABELS, *OTHERS),
            *FACTS,
            *(word for values, _ in FACTS.values() for word in values),
            *FORMS[1:],
        )
    )
)
"""Every word that a program may hold."""
