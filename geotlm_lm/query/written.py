"""Write values in the form that was asked for: a word, a number, a template, JSON, a list."""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import zip_longest
from typing import Any

from geotlm_lm.core.labels import Motion
from geotlm_lm.query.phrases import (
    KIND_WORDS,
    amount_phrase,
    joined,
    label_of,
    phrase,
    way_phrase,
)
from geotlm_lm.query.program import BARE, Case, head_of, measure_of, type_of
from geotlm_lm.query.telling import Teller, Wording
from geotlm_lm.query.values import (
    Amount,
    Choice,
    Moved,
    Placed,
    Record,
    Shown,
    Times,
    Truth,
    Unknown,
    Value,
)
from geotlm_lm.track.events import MOVING

POSITIVE = (Motion.CLOCKWISE, Motion.RIGHT, Motion.DOWN, Motion.PRESS)
_BETWEEN = {"pairs": "=", "yaml": ": "}
_AROUND = {"tuple": "()", "brackets": "[]"}
_PARTED = {"csv": ",", "semicolons": ";", "tabs": "\t", "pipes": "|"}
_CODE = re.compile(r"-?(?:0|[1-9]\d{0,8})")
"""A label that is a number in JSON; "01" is a word."""

UNKNOWN = "unknown"
"""Stands alone where a value alone is wanted and is withheld."""

_WRITTEN = {"dict": repr, "json": json.dumps}


def worded(
    values: Sequence[Value],
    form: str,
    teller: Teller,
    sure: float = 1.0,
    guesses: Sequence[float | None] = (),
) -> Wording:
    """Return values in a form of `program.FORMS`; what has no such form is told in full.

    Args:
        values: Of everything that was asked.
        form: Wanted.
        teller: Of the recording.
        sure: Probability of the whole answer, for JSON.
        guesses: How probable each value is of which a sentence says that it is not sure, None of
            others; empty for none.
    """
    if form in _WRITTEN:
        return Wording(_WRITTEN[form](as_json(values, teller, sure)), teller.named)
    if form in (*_PARTED, *_BETWEEN, *_AROUND, "markdown", "tags"):
        return Wording(_template(values, form, teller), teller.named)
    if form in ("list", "table"):
        return _listed(values, form, teller)
    texts, named = [], teller.named
    for value, chance in zip_longest(values, guesses):
        short = shortened(value, form, teller)
        own = replace(teller, named=named)
        wording = own.tell(value) if short is None else Wording(short, named)
        text = wording.text
        if len(values) > 1 and isinstance(value, Times) and short is None and value.times_s:
            asked = phrase(value.of)  # of several times each by its name
            text = f"{asked[:1].upper()}{asked[1:]}: {text[:1].lower()}{text[1:]}"
        text = text if chance is None else guessed(text, chance)
        if not (_denies_all(value) and text in texts):  # which way and how far it does not turn
            texts.append(text)
        named = wording.named
    return Wording(" ".join(texts), named)


def _denies_all(value: Value) -> bool:
    """Tell whether a way or an amount is that nothing of what was asked moves."""
    is_told = isinstance(value, (Moved, Amount)) and value.moved is not None
    return is_told and bool(value.moved.denied) and not value.moved.movements


LEAST_GUESS = 0.05
"""Probability below which an answer is no guess."""


def guessed(text: str, chance: float) -> str:
    """Return an answer as the guess that it is; one that is no more than possible is not given."""
    if chance < LEAST_GUESS:
        return "I cannot tell for sure, nor is any answer likely."
    if not text[:2].isupper():  # such as an own label, GO
        text = f"{text[:1].lower()}{text[1:]}"
    return f"I cannot tell for sure, {chance:.0%}: {text}"


def shortened(value: Value, form: str, teller: Teller) -> str | None:
    """Return a value in a short form; None where it has none."""
    if isinstance(value, Unknown) and form in BARE:
        return UNKNOWN
    if not value.is_known or form in ("sentence", "one-sentence"):
        return None
    if isinstance(value, Record) and form in ("one-zero", "true-false", "number", "sign"):
        parts = [shortened(each, form, teller) for _, each in value.fields]
        return ", ".join(parts) if parts and None not in parts else None
    if form == "one-zero":
        return str(int(value.holds)) if isinstance(value, Truth) else None
    if form == "true-false":
        return str(value.holds) if isinstance(value, Truth) else None
    if form == "sign":
        is_moving = isinstance(value, Moved) and value.movements and value.still_axis is None
        way = value.movements[0].way if is_moving else None
        return None if way is None else "+" if way in POSITIVE else "-"
    if form == "number":
        return _number(value)
    word = decided(value, teller)
    if word is None and isinstance(value, Record) and form in BARE:
        words = [shortened(each, "bare", teller) for _, each in value.fields]
        word = "; ".join(words) if words and None not in words else None
    if word is None or (form == "yes-no" and not isinstance(value, Truth)):
        return None
    return word if form == "bare" else f"{word[:1].upper()}{word[1:]}."


def _is_story(value: Value) -> bool:
    return isinstance(value, Moved) and head_of(value.of).word == "story"


def _is_unmoved(value: Value) -> bool:
    """Tell whether how far something goes came to nothing: it does not move."""
    return isinstance(value, Moved) and type_of(value.of) == "number"


def _number(value: Value) -> str | None:
    if _is_unmoved(value):
        decimals = (int(each.arguments[0]) for each in value.of if each.word == "round")
        return f"{0:.{next(decimals, 0)}f}"
    if isinstance(value, Amount):
        return value.amount.figure
    if isinstance(value, Times) and len(value.times_s) == 1:
        return f"{value.times_s[0]:g}"
    return f"{value.probability:.2g}" if head_of(value.of).word == "sure" else None


def decided(value: Value, teller: Teller) -> str | None:
    """Return the word that a value comes to, such as "yes", "clockwise" or "12 deg"."""
    if isinstance(value, Truth):
        return "yes" if value.holds else "no"
    if isinstance(value, Choice):
        return _chosen(value)
    if isinstance(value, Amount):
        return value.amount.word if value.amount.unit else value.amount.figure
    if isinstance(value, Times):
        return joined([teller.moment(each) for each in value.times_s]) if value.times_s else "never"
    if isinstance(value, Record):
        words = [decided(each, teller) for _, each in value.fields]
        return "; ".join(words) if words and all(words) else None
    return _motion(value) if isinstance(value, Moved) else None


def _chosen(value: Choice) -> str | None:
    head = head_of(value.of)
    if head.word == "alternatives":
        return None
    if head.word in ("which-clip", "which-more", "which-less"):
        return " and ".join(("first", "second")[place] for place in value.chosen) or "neither"
    cases: tuple[Case, ...] = head.arguments[0]
    chosen = [cases[place] for place in value.chosen]
    return " and ".join(label_of(case) for case in chosen) or "none"


def _motion(value: Moved) -> str | None:
    head = head_of(value.of)
    if head.word in ("why", "sure", "alternatives"):
        return f"{value.probability:.0%}" if head.word == "sure" else None
    if value.tightens is not None:
        return "tightens" if value.tightens else "loosens"
    if head.arguments == ("thread",) and value.movements and not value.denied:
        return "tightens and loosens"
    if head.word == "kind" and value.shown and not value.movements:
        return value.shown[0].kind.value
    if head.word == "kind" and value.movements:
        return " and ".join(KIND_WORDS[move.component] for move in value.movements)
    if head.word == "extent" and value.movements:
        amounts = [move.amount for move in value.movements if move.amount is not None]
        return joined([amount.word for amount in amounts]) if amounts else None
    if value.still_axis is not None or (value.denied and not value.edit.undo):
        return Motion.STILL.value
    if value.movements:
        return value.movements[0].way.value
    return None if value.rest is None else value.rest.value


# Templates


def plain(value: Value, teller: Teller) -> Any:
    """Return a value as plain JSON: true, 26.0, "clockwise"; null where it cannot be told."""
    if not value.is_known:
        return None
    if _is_unmoved(value):
        return 0.0
    if isinstance(value, Truth):
        return value.holds
    if isinstance(value, Amount):
        return value.amount.value
    if isinstance(value, Times):
        times = [round(each, 3) for each in value.times_s]
        return times[0] if len(times) == 1 else times
    if isinstance(value, Record):
        if any(key for key, _ in value.fields):
            return {key or str(place): plain(each, teller)
                    for place, (key, each) in enumerate(value.fields, 1)}  # fmt: skip
        return [plain(each, teller) for _, each in value.fields]
    if isinstance(value, Placed):
        return {name: round(getattr(value, name), 3) for name in ("across", "down", "share")}
    if _is_story(value):
        return [_event(each) for each in value.shown]
    if isinstance(value, Moved) and head_of(value.of).word == "sure":
        return round(value.probability, 3)
    word = decided(value, teller)
    is_code = isinstance(value, Choice) and word is not None and _CODE.fullmatch(word)
    return int(word) if is_code else word


def _event(shown: Shown) -> dict[str, Any]:
    row = {"kind": shown.kind.value, "way": shown.way.value,
            "begin_s": round(shown.begin_s, 3), "end_s": round(shown.end_s, 3)}  # fmt: skip
    if shown.amount is not None:
        row |= {"value": shown.amount.value, "unit": shown.amount.unit}
    return row


def _fields(values: Sequence[Value]) -> list[tuple[str | None, Value]]:
    fields: list[tuple[str | None, Value]] = []
    for value in values:
        fields += value.fields if isinstance(value, Record) else [(None, value)]
    return fields


def as_json(values: Sequence[Value], teller: Teller, sure: float) -> Any:
    """Return values as plain JSON: under the keys of a template where one was given."""
    if not isinstance(values[0], Moved) and (rows := _rows(values)):
        return [{key: _plain_cell(each, teller) for key, each in row.items()} for row in rows]
    fields = _fields(values)
    if fields and all(key for key, _ in fields):
        return {key: plain(value, teller) for key, value in fields}
    names = [key or name_of(value) for key, value in fields]
    row = {
        name if names.count(name) == 1 else f"{name}_{place}": plain(value, teller)
        for place, (name, (_, value)) in enumerate(zip(names, fields, strict=True), 1)
    }
    return row | {"probability": round(sure, 3)}


def name_of(value: Value) -> str:
    """Return the key of a value that was given none: "turn_deg", "moves", "time_s"."""
    head = measure_of(head_of(value.of))
    if isinstance(value, Amount):
        names = [each for each in head.arguments if isinstance(each, str)]
        unit = value.amount.unit.replace("/", "_per_").replace("percent", "")
        return "_".join([*(names or [head.word.replace("-", "_")]), *([unit] if unit else [])])
    if isinstance(value, Times):
        return f"{head.word}_s" if head.word in ("begin", "end") else "time_s"
    if isinstance(value, Choice):
        return "chosen"
    return {"way": "way", "kind": "kind", "story": "events", "sure": "probability"}.get(
        head.word, head.word.replace("-", "_")
    )


def _rows(values: Sequence[Value]) -> list[dict[str, Any]]:
    """Return a story, or a record of each event, as rows of cells by column; else none."""
    if len(values) != 1:
        return []
    (value,) = values
    if _is_story(value):
        return [dict.fromkeys(("kind", "way", "begin_s", "end_s", "value", "unit")) | _event(each)
                for each in value.shown]  # fmt: skip
    parts = [each for _, each in value.fields] if isinstance(value, Record) else []
    if not parts or not all(isinstance(each, Record) for each in parts):
        return []
    rows = [{key or name_of(each): each for key, each in part.fields} for part in parts]
    has_keys = any(key for part in parts for key, _ in part.fields)
    if has_keys or not value.shown or "events" in rows[0]:
        return rows
    # What is of several kinds is told with its own.
    named = ({"kind": each.kind.value, "way": _way_of(each)} for each in value.shown)
    return [each | {key: cell for key, cell in row.items() if key not in each}
            for each, row in zip(named, rows, strict=True)]  # fmt: skip


def _way_of(shown: Shown) -> str | None:
    return shown.way.value if shown.kind in MOVING else None


def _template(values: Sequence[Value], form: str, teller: Teller) -> str:
    is_parted = form in (*_PARTED, "markdown")
    if is_parted and (rows := _rows(values)):
        cells = [[_cell(each, teller) for each in row.values()] for row in rows]
        return _parted([[*rows[0]], *cells], form)
    fields = _fields(values)
    words = [_cell(value, teller) for _, value in fields]
    if form in _AROUND:
        return ", ".join(words).join(_AROUND[form])
    keys = [key or name_of(value) for key, value in fields]
    if form == "tags":
        pairs = zip(keys, words, strict=True)
        return "\n".join(f"<{key}>{word}</{key}>" for key, word in pairs)
    if form in _BETWEEN:
        return "\n".join(
            f"{key}{_BETWEEN[form]}{word}" for key, word in zip(keys, words, strict=True)
        )
    has_keys = form == "markdown" or any(key for key, _ in fields)
    return _parted([keys, words] if has_keys else [words], form)


def _parted(rows: Sequence[Sequence[Any]], form: str) -> str:
    """Return rows of cells as CSV, parted as the form says, or as a table of Markdown."""
    if form == "markdown":
        ruled = [rows[0], ["---"] * len(rows[0]), *rows[1:]]
        cells = ([("" if cell is None else str(cell)) for cell in row] for row in ruled)
        return "\n".join(f"| {' | '.join(row)} |" for row in cells)
    text = io.StringIO()
    csv.writer(text, delimiter=_PARTED[form], lineterminator="\n").writerows(rows)
    return text.getvalue().rstrip("\n")


def _plain_cell(cell: Any, teller: Teller) -> Any:
    return plain(cell, teller) if isinstance(cell, Value) else cell


def _cell(value: Any, teller: Teller) -> Any:
    if not isinstance(value, Value):
        return value
    if _is_story(value):
        return "; ".join(f"{each.kind.value} {_way_of(each) or ''}".strip() for each in value.shown)
    cell = plain(value, teller)
    if cell is None:
        return ""
    if isinstance(cell, bool):
        return "1" if cell else "0"
    if isinstance(value, Amount):
        return value.amount.figure
    if isinstance(cell, list):
        return ", ".join(map(str, cell))
    return f"{cell:.10g}" if isinstance(cell, float | int) else str(cell)


def _line_part(part: Any, teller: Teller) -> str:
    if isinstance(part, Value) and not _is_story(part):
        return decided(part, teller) or ""
    return _cell(part, teller) or ""


def _listed(values: Sequence[Value], form: str, teller: Teller) -> Wording:
    """Return values, a record's or a story's parts, each on a line of its own."""
    lines: list[list[str]] = []
    for value in values:
        if _is_story(value) and value.shown:
            for each in value.shown:
                far = "" if each.amount is None else amount_phrase(each.amount)
                way = way_phrase(each) if each.kind in MOVING else ""
                lines.append([teller.span((each.begin_s, each.end_s)), each.kind.value, way, far])
        elif isinstance(value, Record) and _rows([value]):
            lines += [[_line_part(each, teller) for each in row.values()]
                      for row in _rows([value])]  # fmt: skip
        elif isinstance(value, Record):
            lines += [[key or "", _line_part(each, teller)] for key, each in value.fields]
        else:
            lines.append([teller.tell(value).text])
    if form == "table":
        return Wording("\n".join(" | ".join(line) for line in lines), teller.named)
    texts = [" ".join(part for part in line if part) for line in lines]
    return Wording("\n".join(f"{k}. {text}" for k, text in enumerate(texts, 1)), teller.named)
