"""Read facts on the set-up, and several questions, sentence by sentence, as turns are.

Of several facts before a question, read as a whole, one is lost now and then; in a sentence of its
own each is read well. Facts hold until they are taken back: the question may be read without them.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from itertools import accumulate, chain

from geotlm_lm.query.quantities import Quantity
from geotlm_lm.query.reading import Reading
from geotlm_lm.query.text import MOST_SLOTS

SURELY = 0.9
"""Probability from which on a sentence is taken to state facts and to ask nothing."""

MOST_SENTENCES = 12
"""Texts of more are read as a whole only."""

_RESTING = ("again", "as", "talk", "help", "not-understood", "compare", "which-clip")
"""Asks, and forms, that mean something only beside what else is said."""

_SEEN_SO = {
    "mirrored": ("mirror", "flip"),
    "turned": ("half", "quarter-cw", "quarter-ccw", "flip"),
    "seen": ("behind",),
    "moves": ("sensor",),
}
"""Words of a query that say what a fact on a topic does."""

_AS_USUAL = ("fact moves object", "fact seen sensor")
"""Facts that change nothing where nothing else was stated."""

_END = re.compile(r"(?<=[.!?;])\s+|\s*\n\s*")


Reads = Callable[[str], list[Reading]]


def sentences(text: str) -> list[str]:
    """Return a text's sentences; a semicolon and the end of a line end one too."""
    return [one for one in _END.split(text.strip()) if one]


def read_alone(text: str, read: Reads) -> list[Reading]:
    """Return the likeliest reading of each sentence of a text, numbered as in the text.

    None at all of one sentence alone, of more than are read so, and of more numbers than a query
    can name.
    """
    said = sentences(text)
    found: list[Reading] = []
    if 1 < len(said) <= MOST_SENTENCES:
        for one in said:
            numbers = sum(len(before.quantities) for before in found)
            reading = read(one)[0]
            found.append(reading.at(range(numbers + 1, numbers + len(reading.quantities) + 1)))
    return found if sum(len(one.quantities) for one in found) <= MOST_SLOTS else []


def read_apart(text: str, alone: Sequence[Reading], read: Reads) -> list[Reading]:
    """Return readings of what a text asks, behind the facts that sentences of their own state.

    Args:
        text: Facts and questions.
        alone: What `read_alone` returns of it.
        read: Returns the likeliest readings of a text, the best first.

    Returns:
        As `read` does, but that probabilities are those of what asks. None where no sentence
        surely states a fact and not each asks for itself, or where what is left states something
        on the same as a fact: then the order counts.
    """
    if not alone:
        return []
    said = sentences(text)
    ends = list(accumulate(len(one.quantities) for one in alone))
    places = [
        range(end - len(one.quantities) + 1, end + 1) for one, end in zip(alone, ends, strict=True)
    ]
    stated = [one for one in alone if one.states_only and one.probability >= SURELY]
    left = [at for at, one in enumerate(alone) if one not in stated] or [len(alone) - 1]
    numbers_left = list(chain.from_iterable(places[at] for at in left))
    asked = read(" ".join(said[at] for at in left)) if stated else []
    asked = [one.at(numbers_left) for one in asked if len(one.quantities) == len(numbers_left)]
    if all(said[at].endswith("?") for at in left):
        asked = max(asked, _each([alone[at] for at in left]), key=chance_of)
    facts = list(chain.from_iterable(one.clauses for one in stated))
    if asked and not _clash(facts, set(asked[0].clauses) - set(facts)):
        quantities = tuple(chain.from_iterable(one.quantities for one in alone))
        chance = math.prod(one.chance for one in stated)
        return [_behind(facts, chance, one, quantities) for one in asked]
    return []


def chance_of(readings: Sequence[Reading]) -> float:
    """Return the chance of the best reading; 0 of none."""
    return readings[0].chance if readings else 0.0


def _each(questions: Sequence[Reading]) -> list[Reading]:
    """Return questions one after another as one reading; none where one rests on the others."""
    clauses = list(dict.fromkeys(chain.from_iterable(one.clauses for one in questions)))
    asks = [one.rpartition(" > ")[2].split()[0] for one in clauses]
    facts = [one for one, ask in zip(clauses, asks, strict=True) if ask == "fact"]
    parts = [one for one, ask in zip(clauses, asks, strict=True) if ask != "fact"]
    if len(questions) < 2 or not set(asks).isdisjoint(_RESTING):
        return []
    chance = math.prod(one.chance for one in questions)
    return [replace(questions[0], line=" ; ".join([*facts, *parts]), chance=chance)]


def chance_lost(reading: Reading, alone: Iterable[Reading]) -> float:
    """Return how probable it is that sentences state facts of which a reading says nothing.

    Those that hold where nothing is stated are not missed; a point of view that a question is asked
    from says as much as the fact.
    """
    words, kept = set(reading.line.split()), 1.0
    for one in alone:
        facts = [fact for fact in one.clauses if fact not in _AS_USUAL and "unclear" not in fact]
        if any(words.isdisjoint((topic, *_SEEN_SO.get(topic, ()))) for topic in _topics(facts)):
            kept *= 1 - one.probability
    return 1 - kept


def _clash(facts: Iterable[str], others: Iterable[str]) -> bool:
    """Tell whether it counts which of some facts come first."""
    topics, more = _topics(facts), _topics(others)
    return not topics.isdisjoint(more) or bool(more and topics and "everything" in topics | more)


def _topics(clauses: Iterable[str]) -> set[str]:
    """Return what facts are about: their names, of an unclear one what is."""
    words = [one.split() for one in clauses if one.startswith("fact ")]
    return {next(word for word in one[1:] if word not in ("not", "unclear")) for one in words}


def _behind(
    facts: Sequence[str], chance: float, asked: Reading, quantities: tuple[Quantity, ...]
) -> Reading:
    clauses = dict.fromkeys((*facts, *asked.clauses))
    return replace(
        asked, line=" ; ".join(clauses), quantities=quantities, chance=chance * asked.chance
    )
