"""Follow-ups: what leans on what was asked before is spelled out.

"And mirrored?", "in radians?", "more than 20 degrees?" hold `again` in the place of what was asked
last, "how long was that?" and "what came after it?" hold `it` in the place of what it spoke of.
Both are exchanged for that itself: the state of a conversation is expressions.
"""

from __future__ import annotations

from dataclasses import replace

from geotlm_lm.core.edit import EDIT_WORDS
from geotlm_lm.query.program import (
    COMPONENTS,
    EVENTS,
    MEASURED,
    UNITS,
    WAYS,
    Case,
    Expression,
    Field,
    Program,
    head_of,
    normal,
    of,
    type_of,
)

OPEN = Program((of("way", "all"),))
"""What is taken to have been asked where nothing was."""

_NUMBERED = (">", "<", "=", "~", "in-range", "+", "-", "*", "/", "percent-of", "min", "max", "abs",
             "negate", "round", "unit", "per")  # fmt: skip
"""What takes a number: of what was no number it is how far that goes."""

STRUCTURED = ("json", "csv", "pairs", "list", "table")
"""Forms of one answer; the next is told in words again, while a word or a number stays one."""

_PLACED = ("within", "at", "of-first", "of-second", "of-previous")


def resumed(program: Program, before: Program) -> Program:
    """Return a program with what it leans on spelled out.

    A view is added to those that were asked for before, so that the same again takes it back; a
    span or a clip takes the place of the last one. Without anything before, what moves is asked
    for; beside a fact alone nothing is.

    Args:
        program: What is asked now.
        before: What was asked last, itself resumed.
    """
    if not any(_leans(answer) for answer in program.answers):
        return program
    if not before.answers:
        if program.facts and all(answer == of("again") for answer in program.answers):
            return replace(program, answers=())
        before = OPEN
    answers = []
    for answer in program.answers:
        is_about_all = _leans(answer) and any(each.word == "again" for each in answer)
        for last in before.answers if is_about_all else before.answers[:1]:
            answers.append(_asked(_spelled(answer, last)))
            if not _leans(answer):
                break
    is_kept = program.form == "sentence" and before.form not in STRUCTURED
    form = before.form if is_kept else program.form
    spelled = replace(program, answers=tuple(dict.fromkeys(answers)), form=form)
    return normal(spelled)


def _asked(answer: Expression) -> Expression:
    """Return what can be asked: of a span, as "when was that?" may speak of, both of its ends."""
    if type_of(answer) != "span":
        return answer
    return of("record", (Field(of("begin", answer)), Field(of("end", answer))))


def _leans(expression: Expression) -> bool:
    return any(each.word in ("again", "it") for each in expression)


def _spelled(expression: Expression, last: Expression, wants: str | None = None) -> Expression:
    """Return an expression with the last one in the place of "again", its event in that of "it"."""
    word = expression.word
    if word == "again":
        return _as_number(last, wants) if wants is not None else last
    if word == "it":
        return spoken_of(last)
    if word == "plain" and expression.arguments[0].word == "again":
        return _bare(last)
    if word in _PLACED and any(each.word == "again" for each in expression.arguments[-1]):
        last = _unplaced(last, is_clip=word.startswith("of-"))
    wants = wants if word not in _NUMBERED else _unit_of(expression)
    arguments = tuple(_argument(each, last, wants) for each in expression.arguments)
    return replace(expression, arguments=arguments)


def _argument(value, last: Expression, wants: str | None):
    if isinstance(value, Expression):
        return _spelled(value, last, wants)
    if isinstance(value, tuple):
        return tuple(_argument(each, last, None) for each in value)
    if isinstance(value, Case):
        return replace(value, holds=_spelled(value.holds, last))
    return (
        replace(value, answer=_spelled(value.answer, last)) if isinstance(value, Field) else value
    )


def _unit_of(expression: Expression) -> str:
    """Return the kind of unit that a number is wanted in: "angle", "length", "time" or ""."""
    units = [expression.arguments[0]] if expression.word == "unit" else []
    units += [each.value.unit for each in expression if hasattr(each.value, "unit")]
    for unit in units:
        for kind, names in UNITS.items():
            if unit.partition("/")[0] in names:
                return kind
    return ""


def _as_number(last: Expression, kind: str) -> Expression:
    """Return what was asked as a number: of a way or a truth how far it goes."""
    if last.word == "if":
        condition, *branches = last.arguments
        return of("if", condition, *(_as_number(branch, kind) for branch in branches))
    if type_of(last) == "number":
        return last
    if last.word in (*EDIT_WORDS, *_PLACED):
        *outer, inner = last.arguments
        return of(last.word, *outer, _as_number(inner, kind))
    if type_of(last) == "time":
        return of("clock", last)
    if kind == "time":
        return of("length", spoken_of(last))
    if last.word in MEASURED:
        return of("amount", last.word)
    asked = last.arguments[0] if last.word == "way" else None
    if asked in (*COMPONENTS, "x", "y"):
        return of("amount", asked)
    return of("amount", {"angle": "turn", "length": "slide"}.get(kind, "move"))


def _bare(last: Expression) -> Expression:
    """Return what was asked without its views, clips and spans."""
    return head_of(last)


def _unplaced(last: Expression, *, is_clip: bool) -> Expression:
    """Return what was asked without the span, or the clip, that another takes the place of."""
    words = ("of-first", "of-second", "of-previous") if is_clip else ("within", "at")
    if last.word in words:
        return _unplaced(last.arguments[-1], is_clip=is_clip)
    if last.word in (*EDIT_WORDS, *_PLACED):
        *outer, inner = last.arguments
        return of(last.word, *outer, _unplaced(inner, is_clip=is_clip))
    return last


def spoken_of(expression: Expression) -> Expression:
    """Return the event or the span that an answer speaks of: its own, or what it measures."""
    for each in expression:
        if each.value is None and each.word != "if" and type_of(each) in ("event", "span"):
            return each
    for each in expression:
        if each.word.endswith(EVENTS):
            return of("largest", each)
        named = [each.word, *(word for word in each.arguments if isinstance(word, str))]
        for word in named:
            if word in (*COMPONENTS, *WAYS, "x", "y"):
                return of("largest", of(f"{word}{EVENTS}"))
    return of("largest", of(f"move{EVENTS}"))
