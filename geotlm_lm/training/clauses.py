"""What stands around a question: points of view, facts, forms, manners, in their places."""

from __future__ import annotations

import random
from collections.abc import Mapping
from dataclasses import dataclass, field

from geotlm_lm.core.edit import EDIT_WORDS
from geotlm_lm.query.program import ACCEPTED, TWO_CLIPS

SHARES = {"edit": 0.3, "fact": 0.3, "subject": 0.08, "form": 0.07, "manner": 0.18, "noise": 0.15}
"""How often a clause of a kind stands around a question that takes it."""

TWICE = 0.25
"""How often a second edit, fact or sentence of no meaning follows the first, a second question the
first, and a third the second."""

_BETWEEN = (
    *(("", "", ""), ("", "And ", "And "), ("", "Also, ", "Finally, "), ("", "Then ", "Then ")),
    *(("1) ", "2) ", "3) "), ("1. ", "2. ", "3. "), ("(a) ", "(b) ", "(c) "), ("- ", "- ", "- ")),
)
"""What stands before each of several questions; from the fifth on of those with nothing around."""


_JOINTS = (" and ", ", and ", ", also ", ", plus ", " but ", ", while ", ", ", " & ")
"""What joins two facts in one sentence."""
_LEADS = (", so ", ": ", ", and ", ", ", " so ", "; now, ", ", then ")
"""What joins facts with the question behind them."""
JOINED = 0.4
"""How often two facts are; half as often a fact and the question, twice as often bare names."""

_REPEATED = ("edit", "fact", "noise")

_NAMED_WORDS = 3
"""Words of a question that only names what it wants; such ones stand in a row."""


@dataclass(frozen=True)
class Family:
    """Templates that mean one thing and are said by one kind of speaker.

    Args:
        id: Its kind and style.
        query: What its texts mean, with fields.
        texts: Templates.
        end: The mark it ends with.
        edits: Whether points of view and subjects may be added.
        complete: Whether nothing at all may.
    """

    id: str
    query: str
    texts: tuple[str, ...]
    end: str = "?"
    edits: bool = True
    complete: bool = False


@dataclass(frozen=True)
class Clause:
    """What may stand around a question.

    Args:
        id: Its name.
        kind: "edit", "fact", "subject", a form's, "manner" or "noise".
        query: What it means; "" of what means nothing.
        texts: Templates by place.
        by_itself: What it means where nothing is asked beside it, if that is told.
    """

    id: str
    kind: str
    query: str
    texts: Mapping[str, tuple[str, ...]]
    by_itself: str = ""


@dataclass
class Around:
    """A question and what is put around it."""

    text: str = ""
    end: str = ""
    query: str = ""
    edits: list[str] = field(default_factory=list)
    subject: str = ""
    form: str = ""
    late: str = ""
    sentences: list[tuple[str, str, str]] = field(default_factory=list)
    facts: list[str] = field(default_factory=list)

    def add(self, rng: random.Random, kind: str, place: str, text: str, meant: str) -> None:
        """Put a clause in its place and what it means where it belongs."""
        fact = f"fact {meant}" if kind == "fact" else ""
        if place == "alone":
            mark = "" if text.endswith((".", "?")) else rng.choice((".", ".", ".", ";", " -"))
            edit = meant if kind == "edit" else ""
            self.sentences.append((f"{text}{mark}", fact, edit))
        elif place == "alone_after":
            self.late += f" {text}."
        elif place == "before":
            self.text = f"{text} {self.text}"
        else:
            self.text = f"{self.text}{'' if text.startswith(',') else ' '}{text}"
        if kind == "fact" and place != "alone":
            self.facts.append(fact)
        elif kind == "edit":
            if place != "alone":
                self.edits.insert(0 if place == "before" else len(self.edits), meant)
        elif kind == "subject":
            self.subject = f"{meant} "
        elif kind != "fact" and meant and " as " not in self.query:
            self.form = f" ; as {meant}"

    def joined(self, rng: random.Random) -> tuple[str, str]:
        """Return the text and its meaning; facts and edits in the order they are said."""
        rng.shuffle(self.sentences)
        text = self.text
        if self.sentences and rng.random() < 0.6:
            text = text[:1].upper() + text[1:]
        edits = [*(edit for *_, edit in self.sentences), *self.edits]
        edit = " ".join(filter(None, edits))
        sentences = [part for part, *_ in self.sentences]
        if len(sentences) > 1 and rng.random() < JOINED:
            first, second = sentences[:2]
            sentences[:2] = [f"{_bare(first)}{rng.choice(_JOINTS)}{_begun_small(second)}"]
        if text:
            asked = f"{text}{self.end}{self.late}"
            if sentences and rng.random() < JOINED / 2:
                asked = f"{_bare(sentences.pop())}{rng.choice(_LEADS)}{_begun_small(asked)}"
            sentences.append(asked)
        facts = [fact for _, fact, _ in self.sentences if fact] + self.facts
        query = _seen(self.query, edit, self.subject) if self.query else ""
        return " ".join(sentences), " ; ".join([*facts, *[f"{query}{self.form}"] * bool(query)])


def chosen_clauses(rng: random.Random, family: Family, clauses: list[Clause]) -> list[Clause]:
    """Draw the clauses around a question: of a kind seldom two, and no two on the same thing."""
    chosen: list[Clause] = []
    wanted = [kind for kind, share in SHARES.items() if rng.random() < share]
    wanted += [kind for kind in _REPEATED if kind in wanted and rng.random() < TWICE]
    words = set(family.query.split()) & set(EDIT_WORDS)
    for kind in wanted:
        if not _takes(family, kind):
            continue
        kinds = {kind, *(_forms_of(family.query) if kind == "form" else ())}
        topics = {topic_of(each) for each in chosen}
        offered = [
            clause
            for clause in clauses
            if clause.kind in kinds
            and not words & set(clause.query.split())
            and not (topics and topic_of(clause) in topics)
        ]
        if offered:
            chosen.append(rng.choice(offered))
            words |= set(chosen[-1].query.split()) & set(EDIT_WORDS)
    return chosen


def _forms_of(query: str) -> tuple[str, ...]:
    """Return the forms that an answer to a pattern of a program may be wanted in."""
    words = [word for word in query.split() if word not in VIEWS]
    if words[0].startswith("choose"):
        return ("letter",)
    if words[0] in ACCEPTED["number"]:
        return ("number",)
    return (
        ("yes-no",)
        if words[0] in ACCEPTED["bool"] or (len(words) == 1 and words[0].startswith("{"))
        else ()
    )


VIEWS = (*EDIT_WORDS, "of-first", "of-second", "of-previous")
"""Words that stand before what is asked and take nothing else."""


def topic_of(clause: Clause) -> str:
    """Return what no other clause beside this one may be about."""
    words = [word for word in clause.query.split() if word not in ("not", "unclear")]
    return f"fact {words[0]}" if clause.kind == "fact" else clause.id


def _takes(family: Family, kind: str) -> bool:
    if kind == "edit":
        return family.edits
    words = family.query.split()
    is_one = words[0] in ("way", "claim", "choice", "amount", "kind") and ";" not in words
    return kind != "subject" or (family.edits and is_one)


_APART = ("not-understood", "again", "talk", "help", *TWO_CLIPS)


def may_join(family: Family, other: Family) -> bool:
    """Tell whether two questions may be asked in one breath."""
    words = {*family.query.split(), *other.query.split()}
    is_plain = not family.complete and not other.complete and not words & {"as", "fact", *_APART}
    is_lettered = any(each.query.startswith("choose A") for each in (family, other))
    return is_plain and not is_lettered and family.query != other.query


def listed(rng: random.Random, questions: list[str], *, is_bare: bool) -> str:
    """Return questions one after another, as a list only if nothing stands around them."""
    if is_bare and all(len(question.split()) <= _NAMED_WORDS for question in questions):
        names = [_bare(question) for question in questions]
        if rng.random() < 2 * JOINED:
            return f"{', '.join(names[:-1])}{rng.choice((', ', ' and ', ', and '))}{names[-1]}"
    marks = rng.choice(_BETWEEN if is_bare else _BETWEEN[:4])
    step = rng.choice((" ", " ", "\n"))
    return step.join(f"{mark}{question}" for mark, question in zip(marks, questions, strict=False))


def _bare(sentence: str) -> str:
    return sentence.rstrip(" .;-?")


def _begun_small(sentence: str) -> str:
    """Return a sentence as it goes on behind another; one that begins with "I" or "B" stays."""
    return sentence if sentence[1:2] in ("", " ", "'", ")") else sentence[:1].lower() + sentence[1:]


_UNSEEN = ("why", "sure", "sure-amount", "alternatives", "place", "area", "file", "setup")
"""What a point of view does not change."""


def _seen(query: str, edit: str, subject: str) -> str:
    """Return the answers of a program seen as an edit and a subject say, behind their own views."""
    parts = []
    for part in query.split(" ; "):
        words, at = part.split(), 0
        if words[0] in ("as", "fact", *_UNSEEN):
            parts.append(part)
            continue
        while words[at] in EDIT_WORDS:
            at += 1
        own, rest = words[:at], words[at:]
        parts.append(" ".join([*own, *edit.split(), *subject.split(), *rest]))
    return " ; ".join(parts)
