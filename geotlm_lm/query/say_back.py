"""Say a query back in plain words: what a question was taken to ask."""

from __future__ import annotations

from geotlm_lm.core.edit import Edit
from geotlm_lm.query import types as t
from geotlm_lm.query.bounds import timed_as
from geotlm_lm.query.phrases import WORDS

_EDITS = {
    "mirror": "in the mirror",
    "flip": "with the image flipped upside down",
    "half": "with the image turned by 180 degrees",
    "quarter-cw": "with the image turned by 90 degrees clockwise",
    "quarter-ccw": "with the image turned by 90 degrees counterclockwise",
    "behind": "seen from the object's side",
    "backwards": "played backwards",
    "undo": "to undo it",
    "sensor": "of the sensor's own motion",
}
_OF = {None: "it moves", "turn": "it turns", "slide": "it slides", "press": "it presses in",
       "x": "it slides along x", "y": "it slides along y", "thread": "it tightens or loosens",
       "sign": "it turns, as a sign"}  # fmt: skip
_MEASURES = {"path": ", there and back added up", "peak": " at most"}
_SPANS = {
    "whole": "in the whole recording",
    "start": "at the start",
    "end": "at the end",
    "first-half": "in the first half",
    "second-half": "in the second half",
}


def say_back(query: t.Query) -> str:
    """Return what a query asks as a phrase: "which way it turns, played backwards"."""
    return "; ".join(map(_part, query.parts)) or "nothing: it states a fact"


def _part(part: t.Part) -> str:
    told = _ask(part.ask)
    subject = part.subject
    if subject.clip is not None:
        told += f", of {subject.clip.replace('-', ' ')}" + " clip" * (
            subject.clip in ("first", "second", "previous")
        )
    if subject.span is not None:
        told += f", {_span(subject.span)}"
    return told + _edit(part.edit)


def _span(span: t.Span) -> str:
    if span.name is not None:
        return _SPANS[span.name]
    ends = [("from", span.begin), ("to", span.end)]
    return " ".join(f"{word} {_number(one)}" for word, one in ends if one is not None)


def _edit(edit: Edit) -> str:
    words = [_EDITS[word] for word in edit.words]
    return f", {', '.join(words)}" if words else ""


def _ask(ask: t.Ask) -> str:
    simple = {
        "way": f"which way {_OF.get(ask.of, 'it moves')}",
        "kind": "what kind of motion it is",
        "why": "why I say so",
        "alternatives": "what else it could be",
        "place": "where the contact is",
        "again": "the same again, changed",
        "help": "what can be asked",
        "setup": "which set-up I take it to have",
        "recording": f"the recording's {ask.topic}",
        "unanswerable": f"about {ask.topic}, which I cannot tell",
        "talk": "nothing",
        "not-understood": "something I did not understand",
    }
    if ask.kind in simple:
        return simple[ask.kind]
    if ask.kind == "choice":
        return "which it is: " + " or ".join(
            " and ".join(_literal(one) for one in option.proposition.literals)
            for option in ask.options
        )
    if ask.kind == "amount":
        how = "how fast" if ask.per else "how far"
        summed = _MEASURES.get(ask.measure, "")
        return f"{how} {_OF.get(ask.of, f'it goes {WORDS.get(ask.of or str(), ask.of)}')}{summed}"
    if ask.kind == "order":
        named = [WORDS.get(one, one) for one in (ask.of, ask.then) if one]
        return "what happens first and what then" + f" ({', '.join(named)})" * bool(named)
    if ask.kind == "compare":
        return (
            f"how two clips compare ({(ask.relation or 'which way each goes').replace('-', ' ')})"
        )
    said = "it" if ask.proposition is None else proposition_words(ask.proposition)
    begins = {
        "claim": "whether it is",
        "when": "when it is",
        "how-long": "how long it is",
        "how-often": "how many times it is",
        "how-sure": "how sure I am of",
        "which-clip": "which clip is",
    }
    return f"{begins[ask.kind]} {said}"


def proposition_words(proposition: t.Proposition) -> str:
    """Return a proposition as words: "left and not turning", "reverses more than 4 times"."""
    return f" {proposition.joint} ".join(map(_literal, proposition.literals))


def _literal(literal: t.Literal) -> str:
    told = f"{'not ' * literal.denied}{WORDS.get(literal.atom, literal.atom)}"
    if literal.bound is None:
        return told
    relation = {"more": "more than", "less": "less than", "about": "about", "between": "between"}
    numbers = [one for one in (literal.bound.low, literal.bound.high) if one is not None]
    is_count = (
        not any(isinstance(one, t.Slot) for one in numbers) and timed_as(literal) == "how-often"
    )
    said = " and ".join(map(_number, numbers)) + " times" * is_count
    return f"{told} {relation[literal.bound.relation]} {said}"


def _number(number: t.Number) -> str:
    if isinstance(number, t.Slot):
        return f"number {number.index}"
    return f"{number.value:g} {number.unit}".strip()
