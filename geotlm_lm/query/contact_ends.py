"""The begin and end of a contact that a recording shows, and those that lie outside it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geotlm_lm.query import program as p
from geotlm_lm.query.evaluate import Context, Untold, contact_unknown, evaluate, placed
from geotlm_lm.query.program import Expression
from geotlm_lm.query.worlds import COUNT, Happening, Worlds
from geotlm_lm.track.events import EventKind

_CONTACT = ("contact", f"contact{p.EVENTS}", f"touch{p.EVENTS}")
_EDGES = {"begin": "begin", "first-time": "begin", "end": "end", "last-time": "end"}
"""Words for a moment, and which end of what they speak of it is."""

_OUTSIDE = {"begin": "touched", "end": "held"}
"""Why it is not known when a contact begins or ends."""


def require_seen(context: Context, time: Expression) -> None:
    """Refuse a moment that the recording does not show: when what outlasts it is let go.

    Raises:
        Untold: If it is the begin or the end of a contact and lies outside.
    """
    edge, context = placed(time, context)
    name = _EDGES.get(edge.word)
    if name is None or not _is_of_contact(edge.arguments[0], context):
        return
    if not context.worlds.belief.is_contact_known:
        raise contact_unknown(context)
    at = np.broadcast_to(evaluate(edge, context), (COUNT,))
    known = at[np.isfinite(at)]
    limit = unseen_ends(context.worlds).get(name)
    if limit is not None and known.size and abs(float(np.median(known)) - limit) <= 1e-9:
        raise Untold(_OUTSIDE[name], limit)


def unseen_ends(worlds: Worlds) -> dict[str, float]:
    """Return which ends of contact the recording does not show, and when it begins or ends."""
    if not worlds.contacts:
        return {}
    begin, end = worlds.contacts[0][0], worlds.contacts[-1][1]
    is_let_go = any(
        each.kind is EventKind.RELEASE
        and each.event is not None
        and each.event.is_let_go
        and each.end_s >= worlds.end_s
        for each in worlds.happenings
    )
    limits = {"begin": worlds.begin_s} if begin <= worlds.begin_s else {}
    return limits if end < worlds.end_s or is_let_go else limits | {"end": worlds.end_s}


def _is_of_contact(of_what: Expression, context: Context) -> bool:
    """Tell whether a span is a contact, or a part of one."""
    while of_what.arguments and isinstance(of_what.arguments[-1], Expression):
        of_what = of_what.arguments[-1]
    if of_what.word == "here":
        return tuple(map(float, map(np.mean, context.span))) in context.worlds.contacts
    return of_what.word in (*_CONTACT, "touch")


def seen_times(
    context: Context, times: Expression, happenings: Sequence[Happening]
) -> tuple[float, ...]:
    """Return when happenings begin or end, but for an end of contact that the recording lacks.

    Raises:
        Untold: If no time is left.
    """
    name = times.word.removesuffix("s")
    every = [each.begin_s if name == "begin" else each.end_s for each in happenings]
    is_of_contact = _is_of_contact(times.arguments[0], context)
    limit = unseen_ends(context.worlds).get(name) if is_of_contact else None
    seen = tuple(each for each in every if each != limit)
    if every and not seen:
        raise Untold(_OUTSIDE[name], limit)
    return seen if name == "end" else tuple(every)


def require_over(context: Context, *times: Expression) -> None:
    """Refuse a time up to the end of what outlasts the recording."""
    for time in times:
        if _EDGES.get(placed(time, context)[0].word) == "end":
            require_seen(context, time)
