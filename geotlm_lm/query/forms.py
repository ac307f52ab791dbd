"""Answers in the form that was asked for, and as programs read them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import Component
from geotlm_lm.query import types as t
from geotlm_lm.query.amounts import Recording
from geotlm_lm.query.bounds import timings
from geotlm_lm.query.decision import Decision
from geotlm_lm.query.happenings import Happening
from geotlm_lm.query.phrases import frame_phrase, joined, where_phrase
from geotlm_lm.query.say_back import proposition_words
from geotlm_lm.query.tell import SEPARATE, tell
from geotlm_lm.query.tell_track import frames, moment


def decided(decision: Decision, recording: Recording) -> str | None:
    """Return the word that an answer comes to, such as "yes", "clockwise" or "12 deg"."""
    ask = decision.part.ask
    if decision.missing is not None or ask.kind in ("why", "unanswerable", "talk", "help"):
        return None
    if decision.verdict is not None:
        return "yes" if decision.verdict else "no"
    if decision.part.subject.clip in t.OF_SEVERAL:
        words = [decided(one, one.recording or recording) for one in decision.each]
        return "; ".join(words) if all(words) else None
    if ask.kind == "which-clip" or ask.relation in ("which-more", "which-less"):
        return " and ".join(("first", "second")[at] for at in decision.options) or "neither"
    if ask.of == "thread":
        return f"{t.THREAD_ATOMS[decision.options[0]]}s" if decision.options else _motion(decision)
    if ask.kind == "choice":
        chosen = [ask.options[at] for at in decision.options]
        return (
            " and ".join(one.label or proposition_words(one.proposition) for one in chosen)
            or "none"
        )
    if ask.kind in ("when", "how-long") and decision.times:
        return moment(decision.times[0], recording)
    if ask.kind == "how-often":
        return f"{decision.times[0]:g}"
    if decision.amounts:
        return decision.amounts[0].word
    if decision.still_axis is not None:
        return Motion.STILL.value
    if decision.area is not None:
        return f"{decision.area.share:.0%}"
    if ask.kind == "kind" and decision.movements:
        kinds = {Component.TURN: "rotation"}
        return " and ".join(
            kinds.get(one.component, one.component.value) for one in decision.movements
        )
    return _motion(decision)


def _motion(decision: Decision) -> str | None:
    if decision.movements:
        return decision.movements[0].way.value
    return None if decision.rest is None else decision.rest.value


def in_form(
    decisions: Sequence[Decision],
    form: str,
    recording: Recording,
    *,
    sure: float = 1.0,
    keys: Sequence[str] = (),
) -> str:
    """Return decisions in a form of `types.FORMS`; arguments are those of `told_in_form`."""
    return told_in_form(decisions, form, recording, sure=sure, keys=keys)[0]


def told_in_form(
    decisions: Sequence[Decision],
    form: str,
    recording: Recording,
    *,
    sure: float = 1.0,
    keys: Sequence[str] = (),
    named: str | None = None,
) -> tuple[str, str | None]:
    """Return decisions in a form of `types.FORMS`, and the point of view that was named last.

    What has no such form is told in full. A point of view is named where it is not the last named.

    Args:
        decisions: Of every part of a query.
        form: Wanted.
        recording: The file.
        sure: Probability of the whole answer, for JSON.
        keys: Of JSON that holds just these, a decision each.
        named: The point of view that was named before, in words.
    """
    if form == "json" and keys:
        values = (_value(one, recording) for one in decisions)
        return json.dumps(dict(zip(keys, values, strict=True))), named
    if form == "json":
        return json.dumps(as_json(decisions, recording, sure)), named
    told = []
    for one in decisions:
        where = where_phrase(one)
        text = _short(one, form, recording)
        text = text or tell(replace(one, is_frame_known=where == named), recording)
        named = where if where in text else named
        told.append(text)
    if form == "list" and len(told) > 1:
        return "\n".join(f"- {one}" for one in told), named
    return " ".join(told), named


def _short(decision: Decision, form: str, recording: Recording) -> str | None:
    word = decided(decision, recording)
    if word is None or decision.missing is not None:
        return None
    if decision.part.ask.kind == "how-sure":
        percent = f"{decision.probability:.0%}."
        number = f"{decision.probability:.2g}"
        return {"number": number, "word": percent, "brief": percent}.get(form)
    if form == "word" and decision.part.ask.kind == "choice":
        chosen = [decision.part.ask.options[at] for at in decision.options]
        word = " and ".join(map(_one_word, chosen)) or "none"
    if form in ("word", "brief", "letter", "yes-no"):
        is_fitting = form != "yes-no" or decision.verdict is not None
        return f"{word[:1].upper()}{word[1:]}" + "." if is_fitting else None
    if form == "number" and not decision.each:
        return f"{decision.amounts[0].value:g}" if decision.amounts else _count(decision, recording)
    if form == "sign" and decision.movements and decision.still_axis is None:
        positive = (Motion.CLOCKWISE, Motion.RIGHT, Motion.DOWN, Motion.PRESS)
        return "+" if decision.movements[0].way in positive else "-"
    return None


def _one_word(option: t.Option) -> str:
    literal, *others = option.proposition.literals
    words = _ONE_WORD if not (others or literal.denied or literal.bound) else {}
    return option.label or words.get(literal.atom) or proposition_words(option.proposition)


_ONE_WORD = {atom: way.value for atom, way in t.WAY_ATOMS.items()} | {
    "still": Motion.STILL.value,
    "none": Motion.NONE.value,
}


def _count(decision: Decision, recording: Recording) -> str | None:
    if not decision.times:
        return None
    kind, _ = _timed(decision)[0]
    is_time = recording.rate_hz is None and kind != "how-often"
    return f"{frames(decision.times[0], recording) if is_time else decision.times[0]:g}"


def _value(decision: Decision, recording: Recording) -> bool | float | str | None:
    """Return what a decision comes to; an amount whose unit nobody named holds it."""
    ask = decision.part.ask
    if decision.verdict is not None:
        return decision.verdict
    if ask.kind == "how-sure":
        return round(decision.probability, 3)
    is_number = ask.kind == "how-often" or (ask.kind == "amount" and ask.unit is not None)
    if is_number and (number := _short(decision, "number", recording)) is not None:
        return float(number)
    if ask.kind in ("way", "kind") and ask.of != "thread" and len(decision.movements) > 1:
        return joined([one.way.value for one in decision.movements])
    return decided(decision, recording)


def as_json(decisions: Sequence[Decision], recording: Recording, sure: float) -> dict[str, Any]:
    """Return decisions as plain values: every component that moves, verdicts, times."""
    found: dict[str, Any] = {}
    for one in decisions:
        ask = one.part.ask
        if one.missing is not None:
            found["missing"] = tell(one, recording)
        if one.verdict is not None:
            found["verdict"] = one.verdict
        for move in one.movements:
            name = move.component.value
            found[name] = move.way.value
            if move.amount is not None:
                found[f"{name}_{move.amount.unit}"] = move.amount.value
        for component in one.denied:
            found[component.value] = None
        if one.still_axis is not None:
            found[one.still_axis] = None
        if one.rest is not None:
            found["motion"] = one.rest.value
        for amount in one.amounts:
            unit = amount.unit.replace("/", "_per_")
            found[f"{amount.atom}_{unit}"] = amount.value
        found |= _times(one, recording)
        if ask.kind in ("choice", "compare", "which-clip") and one.options:
            found["chosen"] = decided(one, recording)
        if ask.kind == "order":
            found["events"] = [_event(event, recording) for event in one.happenings]
        if ask.kind in SEPARATE and one.each:
            found["each"] = [
                as_json((of_one,), of_one.recording or recording, of_one.probability)
                for of_one in one.each
            ]
        if one.area is not None:
            found["contact_share"] = round(one.area.share, 4)
    where = next((frame_phrase(one.edit) for one in decisions if one.movements), None)
    return found | ({"frame": where} if where else {}) | {"probability": round(sure, 3)}


def _timed(decision: Decision) -> list[tuple[str, str]]:
    """Return the ask and the atom of each time that is told."""
    ask = decision.part.ask
    return timings(ask) or [(ask.kind, "")]


def _times(decision: Decision, recording: Recording) -> dict[str, float]:
    timed, found = _timed(decision), {}
    for (kind, atom), time_s in zip(timed, decision.times, strict=False):
        is_count = kind == "how-often" or recording.rate_hz is not None
        names = _TIMED if is_count else _IN_FRAMES
        name = f"{atom}_" * (len(timed) > 1) + names.get(kind, names[""])
        found[name] = round(time_s, 3) if is_count else frames(time_s, recording)
    return found


_TIMED = {"how-often": "count", "how-long": "seconds", "": "time_s"}
_IN_FRAMES = {"how-long": "frames", "": "at_frame"}
"""Names of times by what is asked, where a frame rate is known and where none is."""


def _event(event: Happening, recording: Recording) -> dict[str, Any]:
    told = {"kind": event.kind.value, "way": event.way.value}
    if event.amount is not None:
        told |= {"value": event.amount.value, "unit": event.amount.unit}
    if recording.rate_hz is None:
        begin, end = frames(event.begin_s, recording), frames(event.end_s, recording)
        return told | {"begin_frame": begin, "end_frame": end}
    return told | {"begin_s": round(event.begin_s, 3), "end_s": round(event.end_s, 3)}
