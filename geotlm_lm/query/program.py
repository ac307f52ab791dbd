"""What a question means: a typed expression, written as a line of words and read back.

Every word is a primitive that takes so many arguments of given types: one table says which.
Numbers and the words of a template are never spelled: they are the k-th of the question until
`filled`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from geotlm_lm.core.edit import EDIT_WORDS
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENT_OF, Component

WAY_ATOMS = {
    "cw": Motion.CLOCKWISE,
    "ccw": Motion.COUNTERCLOCKWISE,
    "left": Motion.LEFT,
    "right": Motion.RIGHT,
    "up": Motion.UP,
    "down": Motion.DOWN,
    "in": Motion.PRESS,
    "out": Motion.RELEASE,
}
"""Words of programs for ways, and the motions that they are."""

ATOM_OF = {way: atom for atom, way in WAY_ATOMS.items()}

UNITS = {
    "angle": ("deg", "rad", "mrad", "gon", "turn", "arcmin"),
    "length": ("px", "mm", "cm", "m", "um", "inch", "thou"),
    "time": ("s", "ms", "us", "min", "frame"),
    "share": ("percent",),
}


def dimension_of(unit: str) -> str:
    """Return what a unit measures, a key of `UNITS`, of a speed its way's; "" of none."""
    top = unit.partition("/")[0]
    return next((kind for kind, units in UNITS.items() if top in units), "")


UNANSWERABLE = (
    "force", "identity", "material", "look", "size", "quality", "temperature", "sound", "future",
    "advice", "cause", "place", "tilt", "axis", "world", "language", "off-topic",
)  # fmt: skip
"""What is asked that touch, or this program, cannot tell."""

TALK = ("greeting", "thanks", "fine", "bye", "doubt", "who", "statement")
TOPICS = ("duration", "frames", "rate", "interval", "size", "used", "scale")
SETTINGS = ("frame", "mirrored", "turned", "mover", "thread", "side", "options")


@dataclass(frozen=True)
class Slot:
    """The k-th quantity of the question, from 1."""

    index: int


@dataclass(frozen=True)
class Quantity:
    """A number with its unit; an empty unit where none is told, "deg/s" of a speed."""

    value: float
    unit: str = ""


Number = Slot | Quantity


@dataclass(frozen=True)
class Fact:
    """Something stated of the set-up.

    Args:
        name: One of `lines.FACTS`.
        value: Its setting, or None.
        numbers: Its quantities.
        denied: It is stated not to hold (any more).
    """

    name: str
    value: str | None = None
    numbers: tuple[Number, ...] = ()
    denied: bool = False


WAYS = tuple(WAY_ATOMS)
COMPONENTS = tuple(component.value for component in Component)

AXIS = {
    "cw": (1, 0, 0, 0),
    "ccw": (-1, 0, 0, 0),
    "left": (0, -1, 0, 0),
    "right": (0, 1, 0, 0),
    "up": (0, 0, -1, 0),
    "down": (0, 0, 1, 0),
    "in": (0, 0, 0, 1),
    "out": (0, 0, 0, -1),
}
"""Where each way goes in a motion's four numbers: turn, right, down, inward."""

COMPONENT = {
    **{word: COMPONENT_OF[way] for word, way in WAY_ATOMS.items()},
    **{component.value: component for component in Component},
    **dict.fromkeys(("x", "y"), Component.SLIDE),
}
"""What of a motion a word is of."""

MEASURED = (*COMPONENTS, *WAYS, "x", "y", "move")
"""What goes a way: "move" the longer of turn and slide, "x" and "y" along columns and rows."""

TRAITS = (*MEASURED, "tighten", "loosen", "still", "touch", "none")
"""What is so or not of a span: "still" that it touches and does not move."""

KINDS = (*MEASURED, "still", "touch", "none", "contact", "slip", "pause", "reverse", "any")
"""What happens in a recording: "touch" and "none" that contact begins and ends, "contact" from one
to the other, "still" a rest."""

EVENTS = "-events"
"""Ends the word for all that happens of a kind: "cw-events"."""

MIXED = ("move", "any", "slip", "reverse")
"""Kinds of which what happens may be a turn as well as a slide."""

ASKED = ("all", *COMPONENTS, "x", "y", "thread", "sign")
PER = ("per-s", "per-ms", "per-min", "per-frame")

COUNTS = tuple(map(str, range(13)))
"""Numbers that a program may spell, for "once" and "the second half"."""

HALVES = ("upper", "lower", "left-half", "right-half")
LABELS = (
    *("A", "B", "C", "D", "E", "F", "1", "2", "3", "4", "5", "6", "-1", "0"),
    *("pass", "fail", "ok", "good", "bad", "yes", "no", "true", "false"),
    *("high", "medium", "low", "large", "small", "fast", "slow"),
)

GOING = ("amount", "net", "path", "peak", "speed", "top-speed")
"""How far, or how fast, something goes; "amount" of what comes back is how far it got."""

COMPARED = (">", "<", "=", "~", "in-range")
"""Truths about numbers: the first is what is measured."""

OVER_EVENTS = ("mean-of", "median-of", "sum-of", "most-of", "least-of", "spread-of")
"""One number made of that of each event."""

TWO_CLIPS = (
    *("same", "opposite", "mirrored", "more", "less", "as-far", "both", "either", "neither"),
    *("only-one", "which-clip", "which-more", "which-less", "each-clip"),
)
"""What is asked of two clips together."""

FORMS = (
    "sentence", "word", "letter", "number", "sign", "yes-no", "one-zero", "brief", "bare",
    "one-sentence", "list", "table", "json", "csv", "pairs", "yaml", "tuple",
    "brackets", "semicolons", "tabs", "pipes", "markdown", "dict", "tags", "true-false",
)  # fmt: skip
"""How an answer is written; "pairs" are lines of key=value, a "tuple" is (1, 2), "brackets" [1].

"semicolons", "tabs" and "pipes" are a CSV's rows parted by these, "markdown" a table of it, "dict"
one of Python, "tags" are <key>value</key>."""

TEMPLATES = ("json", "csv", "pairs", "yaml", "tuple", "brackets", "semicolons", "tabs", "pipes",
             "markdown", "dict", "tags")  # fmt: skip
"""Forms that programs read."""

BARE = ("word", "letter", "number", "sign", "yes-no", "one-zero", "bare", "true-false")
"""Forms of a value alone, which programs read as well."""

MOST_SLOTS, MOST_COPIED = 9, 20
"""Quantities of a text, and words of it, that a program can point at."""

_PLAIN = {
    "bool": {
        **{trait: () for trait in TRAITS},
        "not": ("bool",),
        **{joint: ("bool", "bool") for joint in ("and", "or", "xor")},
        **{sign: ("number", "number") for sign in (">", "<", "=", "~")},
        "in-range": ("number", "number", "number"),
        **{change: ("of",) for change in ("speeds-up", "slows-down")},
        "happens": ("events",),
        **{order: ("time", "time") for order in ("before", "after")},
        "ever": ("bool",),  # at some moment of the span
        "always": ("bool",),  # at every moment of it
        "lies": ("half",),
        **{how: ("way",) for how in ("same", "opposite", "mirrored")},  # of two clips
        **{how: ("number",) for how in ("more", "less", "as-far")},
        **{which: ("bool",) for which in ("both", "either", "neither", "only-one")},
    },
    "number": {
        **{count: () for count in COUNTS},
        "pi": (),
        **{how: ("of",) for how in (*GOING, "limit")},
        "length": ("span",),
        "lasts": ("events",),
        "time-while": ("bool",),
        "share": ("bool",),  # of the span's time
        "count": ("events",),
        "delay": ("time", "time"),
        "clock": ("time",),  # since the recording began
        **{place: () for place in ("area", "place-x", "place-y", "frame-rate", "frame-count")},
        **{size: () for size in ("frame-width", "frame-height")},
        "chance": ("bool",),
        **{sign: ("number", "number") for sign in ("+", "-", "*", "/", "percent-of", "min", "max")},
        **{how: ("number",) for how in ("abs", "negate", "floor", "ceil")},
        **{how: ("number",) for how in ("low", "high", "sigma")},  # of its span
        "margin": ("bool",),  # how far the two sides of a comparison lie apart
        **{how: ("events", "number") for how in OVER_EVENTS},
        "unit": ("unit", "number"),
        "per": ("per", "number"),
        "round": ("decimals", "number"),
        "nearest": ("number", "number"),  # "to the nearest 5 degrees"
    },
    "time": {
        "t": ("number",),
        **{end: ("span",) for end in ("begin", "end")},
        **{shift: ("time", "number") for shift in ("later", "earlier")},
        **{which: ("bool",) for which in ("first-time", "last-time")},
        **{which: ("of",) for which in ("peak-time", "top-speed-time")},
        "then": (),  # the moment that was spoken of last
    },
    "event": {
        **{which: ("events",) for which in ("first", "last", "largest", "longest", "fastest")},
        **{which: ("events",) for which in ("smallest", "shortest", "slowest")},
        "nth": ("number", "events"),
        **{which: ("event", "events") for which in ("next", "previous")},
        "it": (),  # what was spoken of last
    },
    "span": {
        "recording": (),
        "contact": (),
        "here": (),  # the span that is looked at: of an event that is picked, its own
        "between": ("time", "time"),
        **{which: ("number", "span") for which in ("initial", "final")},
        **{side: ("time",) for side in ("until", "since")},
        "part": ("number", "number", "span"),  # "part 2 2 contact": its second half
        "around": ("time", "number"),
    },
    "events": {
        **{f"{kind}{EVENTS}": () for kind in KINDS},
        "such": ("bool", "events"),
        "gaps": ("events",),  # the times between them
        "those": (),  # of the kind that was spoken of last
    },
    "way": {"way": ("asked",), **{what: () for what in ("kind", "extent", "story")}},
    "label": {
        **{which: ("cases",) for which in ("choose", "choose-not")},
        "which-clip": ("bool",),
        **{which: ("number",) for which in ("which-more", "which-less")},
    },
    "record": {
        "record": ("fields",),
        "each": ("events", "answer"),
        "each-clip": ("answer",),
        **{ends: ("events",) for ends in ("begins", "ends")},
    },
    "talk": {
        **{plain: () for plain in ("why", "sure", "sure-amount", "alternatives", "place", "help")},
        **{of: ("bool",) for of in ("why-of", "sure-of")},
        "setup": ("setting",),
        "file": ("topic",),
        "talk": ("remark",),
        "cannot": ("unanswerable",),
        "not-understood": (),
    },
}
"""Primitives by the type that they give, and the types of what they take."""

NAMES = {
    "of": MEASURED,
    "what": (*MEASURED, *GOING, "limit"),
    "half": HALVES,
    "asked": ASKED,
    "unit": tuple(unit for units in UNITS.values() for unit in units),
    "per": PER,
    "decimals": COUNTS[:7],
    "setting": SETTINGS,
    "topic": TOPICS,
    "remark": TALK,
    "unanswerable": UNANSWERABLE,
}
"""Types whose values are names alone."""

MOVERS = {"as-object": False, "as-sensor": True}
"""Whose motion is meant, whatever it was before, and whether that is the sensor's."""

CLIPS = {"of-first": 0, "of-second": 1, "of-previous": 0}
"""Which of two clips is meant, and its place."""

AROUND = (*EDIT_WORDS, *MOVERS, *CLIPS, "within", "at", "plain")
"""Views, clips and spans: what is put around an expression and leaves its type what it is."""

_WRAPPERS: Mapping[str, tuple[str, ...]] = {
    "within": ("span", "*"),
    "at": ("time", "*"),
    **{edit: ("*",) for edit in EDIT_WORDS},
    **{clip: ("*",) for clip in CLIPS},
    "if": ("bool", "*", "*"),
    **{mover: ("*",) for mover in MOVERS},
    "again": (),  # what was asked last
    "plain": ("*",),  # without the views and spans that were asked for before
    "instead": ("what", "*"),  # the same of something else: "and the slide?", "and how fast?"
    "with": ("number", "*"),  # the same with another number: "I meant 50"
}
"""Primitives that give whatever type is wanted, "*"."""

LEANING = ("it", "then", "those", "instead", "with")
"""What is spelled out by what was asked before, beside "again"."""

_ANSWERS = ("bool", "number", "time", "event", "way", "label", "record", "talk")
"""Types of what can be asked for."""


def _accepted() -> dict[str, dict[str, tuple[str, ...]]]:
    """Return the words that each type may begin with, and what each takes."""
    accepted = {name: {word: () for word in words} for name, words in NAMES.items()}
    accepted |= {name: dict(words) for name, words in _PLAIN.items()}
    accepted["span"] |= accepted["event"]
    accepted["answer"] = {word: takes for name in _ANSWERS for word, takes in _PLAIN[name].items()}
    for name, words in accepted.items():
        if name in (*_PLAIN, "answer"):
            words |= {
                word: tuple(name if each == "*" else each for each in takes)
                for word, takes in _WRAPPERS.items()
            }
    return accepted


ACCEPTED = _accepted()

BETWEEN, END_OF_FIELDS = {"cases": "|", "fields": ","}, "end"
"""What stands between cases, and between fields, which end as they may hold fields themselves."""

OTHERS = ("other", "unknown")
"""Cases such as "none of these" and "cannot tell"."""


@dataclass(frozen=True)
class Text:
    """The k-th word of the question that is to be written as it stands, from 1."""

    index: int


@dataclass(frozen=True)
class Case:
    """One of several answers offered: its label, and what it says."""

    holds: Expression
    label: str | Slot | Quantity | Text | None = None


@dataclass(frozen=True)
class Field:
    """One of a record's answers and the key it is written under."""

    answer: Expression
    key: str | Text | None = None


Argument = Any
"""An `Expression`, a name, or a tuple of cases or of fields."""


@dataclass(frozen=True)
class Expression:
    """A primitive and its arguments; of a number `value` instead."""

    word: str
    arguments: tuple[Argument, ...] = ()
    value: Slot | Quantity | None = None

    def __iter__(self) -> Iterator[Expression]:
        """Yield this expression and all within it."""
        yield self
        for argument in self.arguments:
            for inner in argument if isinstance(argument, tuple) else (argument,):
                if isinstance(inner, Case | Field):
                    inner = inner.holds if isinstance(inner, Case) else inner.answer
                if isinstance(inner, Expression):
                    yield from inner


def of(word: str, *arguments: Argument) -> Expression:
    """Return an expression; strings among the arguments are names where it takes names."""
    return Expression(word, arguments)


def number(value: Slot | Quantity | float) -> Expression:
    """Return a number as an expression."""
    plain = value if isinstance(value, Slot | Quantity) else Quantity(float(value))
    return Expression("#", (), plain)


@dataclass(frozen=True)
class Program:
    """What a text asks and states; a mere statement has no answers."""

    answers: tuple[Expression, ...] = ()
    facts: tuple[Fact, ...] = ()
    form: str = "sentence"


def leans(program: Program) -> bool:
    """Tell whether a program is whole only with what was asked before."""
    words = {each.word for answer in program.answers for each in answer}
    return not words.isdisjoint(("again", *LEANING))


def type_of(expression: Expression) -> str:
    """Return the type that an expression gives."""
    if expression.value is not None:
        return "number"
    if expression.word in OTHERS:
        return "bool"
    if expression.word in _WRAPPERS:
        return type_of(expression.arguments[-1]) if expression.arguments else "answer"
    return next(name for name, words in _PLAIN.items() if expression.word in words)


def with_parts(value: Any, change: Callable[[Any], Any]) -> Any:
    """Return a program, or a part of one, with each of its own parts changed; names stay."""
    if isinstance(value, tuple):
        return tuple(map(change, value))
    if not isinstance(value, Program | Expression | Case | Field | Fact):
        return value
    parts = {
        name: change(inner)
        for name, inner in vars(value).items()
        if isinstance(inner, tuple | Expression | Slot | Quantity | Text)
    }
    return replace(value, **parts)


def head_of(expression: Expression) -> Expression:
    """Return what is asked, without the views, clips and spans around it."""
    while expression.word in _WRAPPERS and expression.arguments and expression.word != "if":
        expression = expression.arguments[-1]
    return expression


def words_of(expression: Expression) -> Iterator[str]:
    """Yield what an expression speaks of: "turn" of `amount turn` and of `turn-events` alike."""
    for each in expression:
        yield each.word.removesuffix(EVENTS)
        yield from (name for name in each.arguments if isinstance(name, str))


def asks_of_two(expression: Expression) -> bool:
    """Tell whether something is asked of two clips together."""
    words = {each.word for each in expression}
    return bool(words & set(TWO_CLIPS)) or {"of-first", "of-second"} <= words


_BETWEEN_TWO = ("and", "or", "xor", ">", "<", "=", "~", "before", "after", "-", "/", "percent-of")


def is_void(program: Program) -> bool:
    """Tell whether a program compares a thing with itself, which nobody asks."""
    return any(
        each.word in _BETWEEN_TWO and each.arguments[0] == each.arguments[1]
        for answer in program.answers
        for each in answer
    )


def measure_of(number: Expression) -> Expression:
    """Return what a number measures, without the unit and the rounding around it."""
    while number.word in ("unit", "per", "round", "nearest", "floor", "ceil", "abs"):
        number = number.arguments[-1]
    return number


def filled(value: Any, quantities: Sequence[Quantity], texts: Sequence[str] = ()) -> Any:
    """Return a program, or a part of one, with the question's numbers and words in their slots.

    Raises:
        IndexError: If a slot counts beyond them.
    """
    if isinstance(value, Slot):
        return quantities[value.index - 1]
    if isinstance(value, Text):
        return texts[value.index - 1]
    return with_parts(value, lambda part: filled(part, quantities, texts))
