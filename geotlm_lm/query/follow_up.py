"""Follow-ups: what leans on what was asked before is spelled out.

"And mirrored?", "in radians?", "more than 20 degrees?" hold `again` in the place of what was asked
last, "how long was that?" and "what came after it?" hold `it` in the place of what it spoke of,
"and how often?" `those` in the place of its kind. They are exchanged for that itself: the state of
a conversation is expressions.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from geotlm_lm.core.edit import EDIT_WORDS
from geotlm_lm.query.lines import normal, units_of
from geotlm_lm.query.program import (
    ACCEPTED,
    AROUND,
    ASKED,
    CLIPS,
    COMPARED,
    COMPONENT,
    COMPONENTS,
    EVENTS,
    GOING,
    MEASURED,
    TEMPLATES,
    Case,
    Expression,
    Field,
    Program,
    Quantity,
    dimension_of,
    head_of,
    leans,
    number,
    of,
    type_of,
    with_parts,
    words_of,
)

OPEN = Program((of("way", "all"),))
"""What is taken to have been asked where nothing was."""

_NUMBERED = (*COMPARED, "+", "-", "*", "/", "percent-of", "min", "max", "abs",
             "negate", "round", "unit", "per", "nearest", "low", "high", "sigma",
             "floor", "ceil")  # fmt: skip
"""What takes a number: of what was no number it is how far that goes."""

_MEASURES = (*GOING, "limit")
"""What may be measured of the same motion instead."""

_ENDS = ("low", "high", "sigma")
"""What is told of a number's spread; one takes the place of another."""

STRUCTURED = (*TEMPLATES, "list", "table")
"""Forms of one answer; the next is told in words again, while a word or a number stays one."""

_PLACED = ("within", "at", *CLIPS)


def resumed(program: Program, before: Program) -> Program:
    """Return a program with what it leans on spelled out.

    A view is added to those that were asked for before, so that the same again takes it back; a
    span or a clip takes the place of the last one. Without anything before, what moves is asked
    for; beside a fact alone nothing is.

    Args:
        program: What is asked now.
        before: What was asked last, itself resumed.
    """
    if before.answers:
        answers = (_of_subject(answer, before.answers[0]) for answer in program.answers)
        program = replace(program, answers=tuple(answers))
    if not leans(program):
        return program
    if not before.answers:
        if program.facts and all(answer == of("again") for answer in program.answers):
            return replace(program, answers=())
        before = OPEN
    answers = []
    for answer in program.answers:
        is_about_all = any(each.word == "again" for each in answer)
        for last in before.answers if is_about_all else before.answers[:1]:
            answers.append(_asked(_spelled(_spoken(answer, last), last)))
    is_template = before.form in STRUCTURED and not any(map(_is_filled_again, answers))
    form = before.form if program.form == "sentence" and not is_template else program.form
    spelled = replace(program, answers=tuple(dict.fromkeys(answers)), form=form)
    return normal(spelled)


def _is_filled_again(answer: Expression) -> bool:
    """Tell whether a template with keys of its own is filled, which stays one."""
    head = head_of(answer)
    return head.word == "record" and any(field.key for field in head.arguments[0])


def _asked(answer: Expression) -> Expression:
    """Return what can be asked: of a span, as "when was that?" may speak of, both of its ends."""
    if type_of(answer) != "span":
        return answer
    return of("record", (Field(of("begin", answer)), Field(of("end", answer))))


def _of_subject(answer: Expression, last: Expression) -> Expression:
    """Return "how far?" or "how fast?" of what was spoken of last."""
    head, subject = head_of(answer), _subject(last)
    if head.word in (">", "<", "~") and head.arguments[0] == of("amount", "move"):
        return _of_measure(head, head_of(last)) or answer
    is_open = head.word == "extent" or head in (of("speed", "move"), of("top-speed", "move"))
    if not is_open or subject is None:
        return answer
    answer = _of_another(answer, subject if subject in ("x", "y") else COMPONENT[subject].value)
    return normal(_seen_as(answer, last))


def _seen_as(answer: Expression, last: Expression) -> Expression:
    """Return an answer with the views that stand around the last one, if it has none of its own."""
    if last.word not in EDIT_WORDS or answer.word in EDIT_WORDS:
        return answer
    words = []
    while last.word in EDIT_WORDS:
        words.append(last.word)
        last = last.arguments[-1]
    for word in reversed(words):
        answer = of(word, answer)
    return answer


def _of_measure(comparison: Expression, last: Expression) -> Expression | None:
    """Return "more than 20?" as of the number that was asked about last; None where none was."""
    bare = comparison.arguments[1].value
    measure = _as_number(last, "") if last.word in COMPARED else last
    if type_of(measure) != "number" or not isinstance(bare, Quantity) or bare.unit:
        return None
    before = (each.value.unit for each in last if isinstance(each.value, Quantity))
    return of(comparison.word, measure, number(replace(bare, unit=next(before, ""))))


def _spoken(value: Any, last: Expression) -> Any:
    """Return an expression, or a part of one, with what was spoken of in the place of "it"."""
    fits = {"it": spoken_of, "then": _moment_of, "those": _events_of}
    if isinstance(value, Expression) and value.word in fits:
        return fits[value.word](last)
    return with_parts(value, lambda part: _spoken(part, last))


def _spelled(
    expression: Expression, last: Expression, wanted: str = "answer", unit: str = ""
) -> Expression:
    """Return an expression with the last one in the place of "again".

    Args:
        expression: What is asked now.
        last: What was asked last.
        wanted: The type that is wanted in its place.
        unit: The kind of unit that a number is wanted in.
    """
    word = expression.word
    if word == "again":
        return _fitted(last, wanted, unit)
    record, is_whole = head_of(last), wanted == "answer"
    if is_whole and word == record.word == "record":
        return _around(last, of("record", _with_more(expression.arguments[0], record)))
    is_of_many = is_whole and record.word in ("record", "each", "each-clip")
    if is_of_many and word in ("unit", "round", "per") and expression.arguments[1].word == "again":
        return _refined(last, expression)
    if word in ("instead", "with"):
        what, inner = expression.arguments[0], _spelled(expression.arguments[1], last, wanted, unit)
        if word == "with":
            return _with_number(inner, what)
        return _of_another(inner, what, is_whole=is_whole)
    if word == "plain" and expression.arguments[0].word == "again":
        return _fitted(head_of(last), wanted, unit)
    if word in _PLACED and any(each.word == "again" for each in expression.arguments[-1]):
        last = _unplaced(last, is_clip=word.startswith("of-"))
    if word == last.word == "each-clip" or (word in _ENDS and last.word in _ENDS):
        (last,) = last.arguments
    unit = _unit_of(expression) if word in _NUMBERED else unit
    takes = ACCEPTED[wanted if word in ACCEPTED[wanted] else type_of(expression)].get(word, ())
    arguments = tuple(
        _argument(each, last, type_, unit)
        for each, type_ in zip(expression.arguments, takes, strict=True)
    )
    return replace(expression, arguments=arguments)


def _around(last: Expression, head: Expression) -> Expression:
    """Return an expression with the views, clips and spans that stand around the last one."""
    if last == head_of(last):
        return head
    *before, inner = last.arguments
    return replace(last, arguments=(*before, _around(inner, head)))


def _with_more(fields: tuple[Field, ...], last: Expression) -> tuple[Field, ...]:
    """Return the fields of the last record where "again" stands, and others beside them."""
    more: list[Field] = []
    for each in fields:
        spelled = _spelled(each.answer, last)
        is_again = each.key is None and spelled.word == "record"
        more += spelled.arguments[0] if is_again else [replace(each, answer=spelled)]
    return tuple(more)


def _refined(answer: Expression, expression: Expression) -> Expression:
    """Return what was asked, all of it that has such, in the unit or decimals that are wanted."""
    head = head_of(answer)
    if head.word == "record":
        fields = (
            replace(each, answer=_refined(each.answer, expression)) for each in head.arguments[0]
        )
        return _around(answer, of("record", tuple(fields)))
    if head.word == "each":
        events, inner = head.arguments
        return _around(answer, of("each", events, _refined(inner, expression)))
    if head.word == "each-clip":
        return _around(answer, of("each-clip", _refined(head.arguments[0], expression)))
    if type_of(answer) != "number":
        return answer
    is_fit = expression.word == "round" or head.word in ("speed", "top-speed")
    if expression.word == "unit":
        is_fit = expression.arguments[0] in (units_of(answer) or ())
    return _spelled(expression, answer) if is_fit else answer


def _argument(value: Any, last: Expression, wanted: str, unit: str) -> Any:
    if isinstance(value, Expression):
        return _spelled(value, last, wanted, unit)
    wanted, unit = {"cases": ("bool", ""), "fields": ("answer", "")}.get(wanted, (wanted, unit))
    return with_parts(value, lambda part: _argument(part, last, wanted, unit))


def _fitted(last: Expression, wanted: str, unit: str) -> Expression:
    """Return what was asked last as what is wanted in its place."""
    if wanted == "answer":
        return last
    if last.word == "each-clip":  # of both, of which one may be more
        return _fitted(last.arguments[0], wanted, unit)
    if last.word == "if":
        condition, *branches = last.arguments
        return of("if", condition, *(_fitted(each, wanted, unit) for each in branches))
    if last.word in AROUND:
        *outer, inner = last.arguments
        return of(last.word, *outer, _fitted(inner, wanted, unit))
    if type_of(last) == wanted:
        return last
    if wanted == "number":
        return _as_number(last, unit)
    if wanted == "bool":
        return of(_subject(last) or "move")
    if wanted == "way":
        asked = _subject(last)
        return of("way", asked if asked in ASKED else "all")
    fits = {"time": _moment_of, "events": _events_of, "span": spoken_of, "event": spoken_of}
    return fits[wanted](last) if wanted in fits else last


def _unit_of(expression: Expression) -> str:
    """Return the kind of unit that a number is wanted in: "angle", "length", "time" or ""."""
    units = [expression.arguments[0]] if expression.word == "unit" else []
    units += [each.value.unit for each in expression if isinstance(each.value, Quantity)]
    return next(filter(None, map(dimension_of, units)), "")


def _as_number(last: Expression, kind: str) -> Expression:
    """Return what was asked as a number: of a way or a truth how far it goes."""
    if type_of(last) == "time":
        return of("clock", last)
    if kind == "time":
        return of("length", spoken_of(last))
    if last.word in COMPARED:
        return next((each for each in last.arguments if each.value is None), last.arguments[0])
    if last.word in MEASURED:
        return of("amount", last.word)
    asked = last.arguments[0] if last.word == "way" else None
    if asked in (*COMPONENTS, "x", "y"):
        return of("amount", asked)
    return of("amount", {"angle": "turn", "length": "slide"}.get(kind, "move"))


def _unplaced(last: Expression, *, is_clip: bool) -> Expression:
    """Return what was asked without the span, or the clip, that another takes the place of."""
    if last.word in ((*CLIPS, "each-clip") if is_clip else ("within", "at")):
        return _unplaced(last.arguments[-1], is_clip=is_clip)
    if last.word in (*EDIT_WORDS, *_PLACED):
        *outer, inner = last.arguments
        return of(last.word, *outer, _unplaced(inner, is_clip=is_clip))
    return last


def _of_another(expression: Expression, what: str, *, is_whole: bool = True) -> Expression:
    """Return an expression of another kind of motion, of another way, or measured otherwise."""
    word = expression.word
    if what in _MEASURES:
        if word == "happens" and is_whole:
            return of(what, _named(expression.arguments[0]) or "move")
        if word in ("way", "extent", "kind", "story"):
            named = expression.arguments[:1] if word == "way" else ()
            return of(what, *(each if each in MEASURED else "move" for each in named or ("move",)))
        if word in MEASURED and is_whole:
            return of(what, word)
        word = what if word in _MEASURES else word
    elif word in ("way", "story"):
        return of("way", what) if what in ASKED else of(what)
    elif word == "extent":
        return of("amount", what)
    elif word in MEASURED:
        word = what
    elif word.removesuffix(EVENTS) in MEASURED:
        word = f"{what}{EVENTS}"
    is_whole = is_whole and word in AROUND
    arguments = _exchanged(expression.arguments, what, is_whole=is_whole)
    if word == "unit":  # "turn" is a unit as well
        arguments = (*expression.arguments[:1], *arguments[1:])
    return replace(expression, word=word, arguments=arguments)


def _exchanged(value: Any, what: str, *, is_whole: bool = False) -> Any:
    if isinstance(value, Field):
        return replace(value, answer=_of_another(value.answer, what))
    if isinstance(value, Expression):
        other = _of_another(value, what, is_whole=is_whole)
        return other if is_whole or type_of(other) == type_of(value) else value
    if isinstance(value, str):
        return what if value in MEASURED and what in MEASURED else value
    is_whole = is_whole and isinstance(value, tuple)
    return with_parts(value, lambda part: _exchanged(part, what, is_whole=is_whole))


def _with_number(expression: Expression, number: Expression) -> Expression:
    """Return an expression with another number in the place of its first one."""
    if expression.value is not None:
        return number
    return replace(expression, arguments=_renumbered(expression.arguments, number))


def _renumbered(arguments: tuple[Any, ...], number: Expression) -> tuple[Any, ...]:
    """Return arguments, cases or fields with another number in the place of their first one."""
    changed = list(arguments)
    for place, each in enumerate(arguments):
        inner = {Case: "holds", Field: "answer"}.get(type(each))
        asked = each if inner is None else getattr(each, inner)
        if isinstance(asked, tuple):
            changed[place] = _renumbered(asked, number)
        elif isinstance(asked, Expression) and any(part.value is not None for part in asked):
            asked = _with_number(asked, number)
            changed[place] = asked if inner is None else replace(each, **{inner: asked})
            break
        if changed[place] != each:
            break
    return tuple(changed)


_SPOKEN = {
    "touch": of("contact"),
    "none": of("last", of(f"none{EVENTS}")),
    **{word: of("largest", of(f"turn{EVENTS}")) for word in ("tighten", "loosen")},
}
"""What is spoken of where it is asked whether that is so."""


def spoken_of(expression: Expression) -> Expression:
    """Return the event or the span that an answer speaks of: its own, or what it measures."""
    for each in expression:
        if each.value is None and head_of(each).word != "if" and type_of(each) in ("event", "span"):
            return each
    for each in expression:
        if each.word in _SPOKEN:
            return _SPOKEN[each.word]
        if each.word.endswith(EVENTS) or _named(each) is not None:
            return of("largest", _events_of(each))
    return of("largest", of(f"move{EVENTS}"))


def _named(expression: Expression) -> str | None:
    """Return what kind of motion a primitive is of; None where it names none."""
    words = (expression.word.removesuffix(EVENTS), *expression.arguments)
    return next((word for word in words if isinstance(word, str) and word in COMPONENT), None)


def _subject(expression: Expression) -> str | None:
    """Return what kind of motion an expression speaks of first; None where of none."""
    return next((word for word in words_of(expression) if word in COMPONENT), None)


def _events_of(expression: Expression) -> Expression:
    """Return all that happens of the kind that an answer speaks of."""
    for each in expression:
        if head_of(each).word != "if" and type_of(each) == "events":
            return each
        if (kind := each.word if each.word in _SPOKEN else _named(each)) is not None:
            kind = "turn" if kind in ("tighten", "loosen") else kind
            return of(f"{kind}{EVENTS}")
    return of(f"move{EVENTS}")


def _moment_of(expression: Expression) -> Expression:
    """Return the moment that an answer speaks of: its own, or when that begins."""
    for each in expression:
        if each.value is None and head_of(each).word != "if" and type_of(each) == "time":
            return each
        if each.word in ("peak", "top-speed"):
            return of(f"{each.word}-time", *each.arguments)
    return of("begin", spoken_of(expression))
