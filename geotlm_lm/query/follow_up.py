"""Follow-ups: "and mirrored?", "in radians", "and the sensor?" stand for what was asked before."""

from __future__ import annotations

from dataclasses import replace

from geotlm_lm.core.edit import Edit
from geotlm_lm.query.types import UNITS, Ask, Part, Query, Subject

_OPEN = Query((Part(Ask("way")),))
"""What is taken to have been asked where nothing was."""


def resumed(query: Query, before: Query) -> Query:
    """Return a query whose "again" parts are spelled out.

    A change is added to those that were asked for before, so that the same again takes it back; of
    which clip, half or span it is is replaced. Without anything before the motion is asked for;
    beside a fact alone nothing is.

    Args:
        query: What is asked now.
        before: What was asked last, itself resumed.
    """
    if not before.parts and not (query.facts and all(map(_is_bare, query.parts))):
        before = _OPEN
    parts: list[Part] = []
    for part in query.parts:
        is_again = part.ask.kind == "again"
        parts += [_changed(one, part) for one in before.parts] if is_again else [part]
    form = before.form if query.form == "sentence" and parts != list(query.parts) else query.form
    return replace(query, parts=tuple(parts), form=form)


def _is_bare(part: Part) -> bool:
    """Tell whether a part asks for what was asked before, and for no change of it."""
    plain = Part(Ask("again"), Edit(), Subject())
    return part in (plain, replace(plain, ask=Ask("again", is_plain=True)))


def _changed(before: Part, now: Part) -> Part:
    edit = (Edit() if now.ask.is_plain else before.edit).then(now.edit)
    if now.ask.mover is not None:
        edit = replace(edit, sensor=now.ask.mover == "sensor")
    subject = before.subject if now.subject == Subject() else now.subject
    return Part(_in_unit(before.ask, now.ask.unit), edit, subject)


def _in_unit(ask: Ask, unit: str | None) -> Ask:
    """Return an ask whose amount is told in a unit; of what was no amount the amount."""
    if unit is None:
        return ask
    if ask.kind == "amount":
        return replace(ask, unit=unit)
    return Ask("amount", of="turn" if unit in UNITS["angle"] else "slide", unit=unit)
