"""Read facts on the set-up, and several questions, sentence by sentence, as turns are.

Of several facts before a question, read as a whole, one is lost now and then; in a sentence of its
own each is read well. Facts hold until they are taken back: the question may be read without them.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain

from geotlm_lm.query import types as t
from geotlm_lm.query.reading import Reading
from geotlm_lm.query.text import MOST_SLOTS, write

SURELY = 0.9
"""Probability from which on a sentence is taken to state facts and to ask nothing."""

MOST_SENTENCES = 12
"""Texts of more are read as a whole only."""

_RESTING = ("again", "talk", "help", "not-understood", "compare", "which-clip")
"""Asks that mean something only beside what else is said."""

_SEEN_SO = {
    "mirrored": {"mirror", "flip"},
    "turned": {"half", "quarter-cw", "quarter-ccw", "flip"},
    "seen": {"behind"},
    "moves": {"sensor"},
}
"""Words of a point of view that does what a fact does."""

_AS_USUAL = (t.Fact("moves", "object"), t.Fact("seen", "sensor"))
"""Facts that change nothing where nothing was stated."""

_END = re.compile(r"(?<=[.!?;])(?!(?<=\d\.)\s\d)\s+|\s*\n\s*")


def sentences(text: str) -> list[str]:
    """Return a text's sentences; a semicolon and the end of a line end one too."""
    return [one for one in _END.split(text.strip()) if one]


@dataclass(frozen=True)
class Sentence:
    """A sentence and its likeliest reading.

    Args:
        text: As it stands.
        places: Of its numbers in the whole text, from 1.
        reading: With these places.
    """

    text: str
    places: tuple[int, ...]
    reading: Reading

    @property
    def surely_states(self) -> bool:
        """Whether it surely states facts and asks nothing."""
        query = self.reading.slotted
        return bool(query.facts) and not query.parts and self.reading.probability >= SURELY


def read_alone(text: str, read: Callable[[str], Reading]) -> list[Sentence]:
    """Return each sentence of a text with its likeliest reading.

    None at all of one sentence alone, of more than are read so, and of more numbers than a query
    can name.
    """
    said = sentences(text)
    found: list[Sentence] = []
    for one in said if 1 < len(said) <= MOST_SENTENCES else ():
        reading = read(one)
        first = 1 + sum(len(before.places) for before in found)
        places = tuple(range(first, first + len(reading.quantities)))
        if len(places) + first - 1 > MOST_SLOTS:
            return []
        found.append(Sentence(one, places, reading.at(places)))
    return found


def read_apart(said: Sequence[Sentence], read: Callable[[str], list[Reading]]) -> list[Reading]:
    """Return readings of what some sentences ask, behind the facts that others surely state.

    Args:
        said: What `read_alone` returns of a text.
        read: Returns the likeliest readings of a text, the best first.

    Returns:
        As `read` does, but that probabilities are those of what asks. None where no sentence
        surely states a fact and not each asks for itself.
    """
    stated = [one.reading for one in said if one.surely_states]
    left = [one for one in said if not one.surely_states]
    asked: list[Reading] = []
    if stated and not left:
        asked, stated = stated[-1:], stated[:-1]
    elif stated:
        places = tuple(chain.from_iterable(one.places for one in left))
        together = read(" ".join(one.text for one in left))
        asked = [one.at(places) for one in together if len(one.quantities) == len(places)]
    if left and all(one.text.endswith("?") for one in left):
        asked = max(asked, _each([one.reading for one in left]), key=chance_of)
    facts = tuple(chain.from_iterable(one.slotted.facts for one in stated))
    quantities = tuple(chain.from_iterable(one.reading.quantities for one in said))
    found = []
    for one in asked:
        query = one.slotted
        if not left or not any(_clash(fact, query.facts) for fact in facts):
            line = write(replace(query, facts=last_of_each((*facts, *query.facts))))
            chance = math.prod(fact.chance for fact in stated) * one.chance
            found.append(replace(one, line=line, quantities=quantities, chance=chance))
    return found


def chance_of(readings: Sequence[Reading]) -> float:
    """Return the chance of the best reading; 0 of none."""
    return readings[0].chance if readings else 0.0


def last_of_each(facts: Iterable[t.Fact]) -> tuple[t.Fact, ...]:
    """Return facts without those that are stated once more later on."""
    return tuple(reversed(dict.fromkeys(reversed(tuple(facts)))))


def _clash(fact: t.Fact, others: Iterable[t.Fact]) -> bool:
    """Tell whether it counts which is said first, a fact or some others."""
    return any(
        fact != one and (_topic(fact) == _topic(one) or "everything" in (fact.name, one.name))
        for one in others
    )


def _topic(fact: t.Fact) -> str | None:
    return fact.value if fact.name == "unclear" else fact.name


def _each(questions: Sequence[Reading]) -> list[Reading]:
    """Return questions one after another as one reading; none where one rests on the others."""
    queries = [one.slotted for one in questions]
    parts = tuple(dict.fromkeys(chain.from_iterable(one.parts for one in queries)))
    is_resting = any(one.ask.kind in _RESTING for one in parts)
    if len(questions) < 2 or is_resting or any(one.form != "sentence" for one in queries):
        return []
    query = t.Query(parts, last_of_each(chain.from_iterable(one.facts for one in queries)))
    chance = math.prod(one.chance for one in questions)
    return [replace(questions[0], line=write(query), chance=chance)]


def chance_lost(reading: Reading, said: Iterable[Sentence]) -> float:
    """Return how probable it is that sentences state facts that hold by no word of a reading.

    On each thing the last fact counts that is stated at all. One that holds anyhow is not missed
    unless the reading says otherwise; a point of view that is asked from says as much as a fact.
    """
    query = reading.slotted
    seen = {word for part in query.parts for word in part.edit.words}
    held = {one.name: one for one in query.facts}
    missed: dict[str, float] = {}
    for one in said:
        chance = one.reading.probability
        for fact in one.reading.slotted.facts:
            if fact.name == "everything":
                missed = {name: before * (1 - chance) for name, before in missed.items()}
            is_missed = fact != held.get(fact.name) and not _is_needless(fact, held, seen)
            before = missed.get(fact.name, 0.0)
            missed[fact.name] = before * (1 - chance) + chance * is_missed
    return 1 - math.prod(1 - chance for chance in missed.values())


def _is_needless(fact: t.Fact, held: dict[str, t.Fact], seen: set[str]) -> bool:
    """Tell whether a fact that is not stated is none to miss."""
    if fact.name == "unclear":
        return True
    is_seen = not fact.denied and not seen.isdisjoint(_SEEN_SO.get(fact.name, ()))
    return fact.name not in held and (is_seen or fact in _AS_USUAL)
