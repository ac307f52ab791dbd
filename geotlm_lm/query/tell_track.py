"""Put what happens in a recording into words: what, how far, and from when to when."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from geotlm_lm.core.labels import DIRECTED, Motion
from geotlm_lm.query.amounts import Recording
from geotlm_lm.query.bounds import timings
from geotlm_lm.query.decision import Decision
from geotlm_lm.query.happenings import Happening, as_contact
from geotlm_lm.query.phrases import amount_phrase, in_frame
from geotlm_lm.track.events import TOGETHER_S, EventKind

MOST_TOLD = 6
"""Events told one after another; of more, the largest."""

_ENDS = (EventKind.TOUCH, EventKind.RELEASE)
_NOUNS = {
    "turn": ("turn", "turns"),
    "slide": ("slide", "slides"),
    "press": ("press", "presses"),
    "touch": ("touch", "touches"),
    "still": ("rest", "rests"),
    "lost": ("release", "releases"),
    "reverses": ("turn back", "turns back"),
}
_NEVER = {
    "turn": "it does not turn",
    "slide": "it does not slide",
    "press": "it does not press in",
    "touch": "nothing touches",
    "made": "nothing touches",
    "lost": "it is not let go",
    **dict.fromkeys(("move", "starts", "stops"), "it neither turns nor slides"),
    "still": "it is never held still",
    "reverses": "it never turns back",
}

_COUNTED = {
    **dict.fromkeys(("touch", "made"), "it is touched"),
    **dict.fromkeys(("none", "lost"), "it is let go"),
    "still": "it is held still",
    "starts": "it starts to move",
    "stops": "it stops",
    "reverses": "it turns back",
}
_LASTING = {
    **dict.fromkeys(("touch", "made"), "it is touched"),
    **dict.fromkeys(("none", "lost"), "nothing touches"),
    "still": "it is held still",
    "move": "it turns or slides",
    "turn": "it turns",
    "slide": "it slides",
    "press": "it is pressed in",
}


def counts_phrase(decision: Decision, recording: Recording) -> str:
    """Return what a claim or a choice bounds: "it turns back 2 times"; else nothing."""
    parts = []
    for (kind, atom), value in zip(timings(decision.part.ask), decision.times, strict=False):
        if not value:
            parts.append(_NEVER.get(atom, "that does not happen"))
        elif kind == "how-often":
            parts.append(f"{_COUNTED[atom]} {value:g} {'time' if value == 1 else 'times'}")
        else:
            parts.append(f"{_LASTING.get(atom, 'that is so')} for {_lasting(value, recording)}")
    return " and ".join(parts)


def _lasting(time_s: float, recording: Recording) -> str:
    """Return a duration: "1.2 s", or frames of a recording without a rate."""
    if recording.rate_hz is not None:
        return moment(time_s, recording)
    return f"{frames(time_s, recording)} frames"


def times_phrase(begin_s: float, end_s: float, recording: Recording) -> str:
    """Return from when to when: "from 1.2 s to 3.4 s", or in frames."""
    begin, end = moment(begin_s, recording), moment(end_s, recording)
    if begin == end:
        return f"at {begin}"
    return f"from {begin} to {end.removeprefix('frame ')}"


def moment(time_s: float, recording: Recording) -> str:
    """Return a time or a duration: "1.24 s", or a frame's number of a recording without a rate.

    No frame is told by the time of another: there are as many decimals as that takes.
    """
    if recording.rate_hz is None:
        return f"frame {frames(time_s, recording)}"
    step_s = recording.step_s or 1 / recording.rate_hz
    decimals = max(1, math.ceil(-math.log10(step_s) - 1e-9))
    whole, part = f"{time_s:.{decimals}f}".split(".")
    return f"{whole}.{part.rstrip('0') or '0'} s"


def frames(time_s: float, recording: Recording) -> int:
    """Return a time or a duration in frames."""
    return round(time_s / (recording.step_s or 1.0))


def tell_times(decision: Decision, recording: Recording) -> str:
    """Return what answers when, how long, how often and in which order."""
    ask = decision.part.ask
    found = largest(decision.happenings)
    if ask.kind == "order":
        return _order(decision, found, recording)
    proposition = as_contact(ask.proposition)
    said = proposition.literals[0]
    is_plain = len(proposition.literals) == 1 and not said.denied
    atom = said.atom if is_plain and said.bound is None else ""
    if ask.kind == "how-often":
        count = int(decision.times[0])
        nouns = _NOUNS.get(said.atom if is_plain else "", ("time", "times"))
        told = f"{count or 'no'} {nouns[count != 1]}"
        return f"{told}: {story(decision, found, recording)}" if found else told
    if not decision.times or (ask.kind == "how-long" and not decision.times[0]):
        return f"{_NEVER.get(atom, 'that does not happen')} in this recording"
    if ask.kind == "how-long":
        long = _lasting(decision.times[0], recording)
        return f"for {long}" + (f": {story(decision, found, recording)}" if found else "")
    at = moment(decision.times[0], recording)
    if not found and atom == "touch":
        return f"{'it touches from' if ask.edge == 'begin' else 'it is touched until'} {at}"
    if len(decision.times) == 2:
        return times_phrase(*decision.times, recording)
    return f"at {at}" + (f": {story(decision, found, recording)}" if found else "")


def largest(found: Sequence[Happening]) -> list[Happening]:
    """Return what is told of many events: where contact begins and ends, and the largest."""
    kept = sorted(found, key=lambda one: (one.kind not in _ENDS, -one.path_px))[:MOST_TOLD]
    return [one for one in found if one in kept]


def _order(decision: Decision, found: Sequence[Happening], recording: Recording) -> str:
    if not found:
        return "it neither moves nor presses in this recording"
    word = {True: "yes: ", False: "no: ", None: ""}[decision.verdict]
    return f"{word}{story(decision, found, recording)}"


def story(decision: Decision, found: Sequence[Happening], recording: Recording) -> str:
    """Return events one after another, and the frame where a way is named."""
    who = "the sensor" if decision.edit.sensor else "it"
    told, text = list(found), ""
    touch = next((one for one in told if one.kind is EventKind.TOUCH), None)
    for before, one in pairwise([None, *told]):
        clause = _clause(one, who, recording)
        if before is None:
            text = clause
        elif before is touch and one.kind is EventKind.PRESS and _together(before, one):
            pressed = _verb(one, "")
            text += f" and {pressed}{',' * (',' in pressed)} until {moment(one.end_s, recording)}"
        else:
            is_meanwhile = one.begin_s < before.end_s - TOGETHER_S
            text += f"{'; meanwhile' if is_meanwhile else ', then'} {clause}"
    is_directed = any(one.way in DIRECTED and one.kind is not EventKind.TOUCH for one in told)
    return text + in_frame(decision) * is_directed


def _together(before: Happening, one: Happening) -> bool:
    return abs(one.begin_s - before.begin_s) <= TOGETHER_S


def _clause(one: Happening, who: str, recording: Recording) -> str:
    if one.begin_s == one.end_s or one.kind is EventKind.TOUCH:
        return f"{_verb(one, who)} at {moment(one.begin_s, recording)}"
    return f"{_verb(one, who)}, {times_phrase(one.begin_s, one.end_s, recording)}"


def _verb(one: Happening, who: str) -> str:
    if one.kind is EventKind.TOUCH:
        return "it touches"
    if one.kind is EventKind.STICK:
        return "it is held still"
    far = (
        "" if one.amount is None or not one.amount.mean else f", about {amount_phrase(one.amount)}"
    )
    if one.kind in (EventKind.PRESS, EventKind.RELEASE):
        verb = "presses in" if one.way is Motion.PRESS else "lifts off"
        return f"{'it ' * bool(who)}{verb}{far if one.way is Motion.PRESS else ''}"
    return f"{who} {one.kind.value}s {one.way.value}{far}"
