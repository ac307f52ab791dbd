"""Put decisions into words: short, what is asked first, the frame named once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from geotlm_lm.core.labels import DIRECTED, Motion, MotionClass
from geotlm_lm.core.twist import WAYS, Component
from geotlm_lm.query import types as t
from geotlm_lm.query.amounts import Measure, Recording
from geotlm_lm.query.decision import ContactArea, Decision
from geotlm_lm.query.phrases import (
    WORDS,
    amount_phrase,
    in_frame,
    joined,
    limit_phrase,
    movement_phrase,
    undoing_phrase,
    where_phrase,
)
from geotlm_lm.query.replies import replies
from geotlm_lm.query.say_back import proposition_words
from geotlm_lm.query.tell_track import (
    counts_phrase,
    largest,
    moment,
    story,
    tell_times,
    times_phrase,
)

_DENIED = {
    Component.TURN: "turn",
    Component.SLIDE: "slide",
    Component.PRESS: "press in or lift off",
}
_REST = {Motion.STILL: "it touches but does not move", Motion.NONE: "nothing touches the gel"}
_KINDS = {
    Component.TURN: MotionClass.ROTATION,
    Component.SLIDE: MotionClass.SLIDE,
    Component.PRESS: MotionClass.PRESS,
}
SECOND_CLIP = ("the first", "the second")
TIMED = ("when", "how-long", "how-often", "order")
SEPARATE = (*TIMED, "recording", "place", "why", "how-sure", "alternatives")
"""Asks that of two clips are told of each by itself."""

OFF_CENTRE_SHARE = 1 / 6
"""Share of the image's side from its middle beyond which a place is no longer the middle's."""


def tell(decision: Decision, recording: Recording | None = None) -> str:
    """Return a decision as a sentence or two.

    Args:
        decision: What is told.
        recording: The file, for its times and for questions on itself.
    """
    ask, recording = decision.part.ask, decision.recording or recording or Recording()
    if decision.missing is not None:
        return replies()["missing"][decision.missing]
    if ask.kind == "unanswerable":
        return replies()["untold"][ask.topic]
    if ask.kind == "talk":
        return replies()["talk"][ask.topic]
    if ask.kind == "setup":
        return f"I tell it in this frame: {decision.frame.sentence()}."
    is_of_two = decision.part.subject.clip in t.OF_SEVERAL
    teller = _of_several if is_of_two else _TELLERS.get(ask.kind)
    return replies()["help"] if teller is None else _sentence(teller(decision, recording))


def _of_several(decision: Decision, recording: Recording) -> str:
    """Return what two clips show: side by side, or each by itself."""
    ask = decision.part.ask
    is_motion = all(one.movements or one.rest for one in decision.each)
    if is_motion and ask.kind not in SEPARATE:
        return _compare(decision, recording)
    teller = _TELLERS[ask.kind]
    parts = [
        f"{who}: {teller(replace(one, verdict=None), one.recording or recording).rstrip('.')}"
        for who, one in zip(SECOND_CLIP, decision.each, strict=True)
    ]
    return {True: "yes: ", False: "no: ", None: ""}[decision.verdict] + "; ".join(parts)


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}" + "." * (text[-1:] not in ".?!")


def _clause(decision: Decision, recording: Recording) -> str:
    """Return what moves, what of the asked does not, and the frame where a way is named."""
    edit = decision.edit
    who = "the sensor" if edit.sensor else "it"
    limits = dict(decision.limits)
    denied = " or ".join(
        _DENIED[each] + limit_phrase(limits.get(each, ())) for each in decision.denied
    )
    if decision.still_axis is not None:
        denied = f"slide {WORDS[decision.still_axis]}"
    moving = {one.component for one in decision.movements}
    is_instead = decision.still_axis or not set(asked_components(decision)) & moving
    if decision.rest is not None:
        if denied and limits and decision.rest is Motion.STILL:
            return f"{who} does not {denied}"
        rest = _rest(decision)
        return f"{who} does not {denied}: {rest}" if denied else rest
    is_directed = any(one.way in DIRECTED for one in decision.movements)
    if edit.undo and denied and is_instead:
        return f"{who} does not {denied}: nothing of that is to be undone"
    if edit.undo:  # a command is acted on, and says its frame each time
        said = undoing_phrase(decision.movements, edit)
        return said + f", {where_phrase(decision)}" * is_directed
    where = in_frame(decision) * is_directed
    told = f"{who} {_all_of([_movement(one, recording) for one in decision.movements])}{where}"
    if decision.part.ask.of == "thread" and decision.options:
        told = f"it {t.THREAD_ATOMS[decision.options[0]]}s: {told}"
    for one in decision.movements:
        if one.back_and_forth is not None:
            told += f"; there and back {amount_phrase(one.back_and_forth)}"
    if not denied:
        return told
    return f"{who} does not {denied}; {told}" if is_instead else f"{told}; {who} does not {denied}"


def _rest(decision: Decision) -> str:
    """Return that nothing moves, and by how much it may all the same."""
    told = _REST[decision.rest]
    if decision.rest is not Motion.STILL:
        return told
    if not decision.is_contact_known:
        told = told.removeprefix("it touches but ")
        told = f"it {told}"
    return told + limit_phrase(dict(decision.limits).get(Component.SLIDE, ()))


def _way(decision: Decision, recording: Recording) -> str:
    """Return what moves; of a recording of several motions what happens one after another."""
    if not decision.happenings:
        return _clause(decision, recording)
    return story(decision, largest(decision.happenings), recording)


def _all_of(parts: Sequence[str]) -> str:
    """Return phrases that hold commas as a list."""
    *others, last = parts
    return f"{', '.join(others)}, and {last}" if others else last


def asked_components(decision: Decision) -> tuple[Component, ...]:
    """Return the components that are asked about and count."""
    of = decision.part.ask.of
    if of in t.COMPONENT_ATOMS:
        return (t.COMPONENT_ATOMS[of],)
    return tuple(
        one.component for one in decision.movements if one.component not in decision.denied
    ) * (decision.verdict is not None)


def _movement(move, recording: Recording) -> str:
    text = movement_phrase(move)
    return text if move.times is None else f"{text}, {times_phrase(*move.times, recording)}"


def _claim(decision: Decision, recording: Recording) -> str:
    told = _judged(decision, recording)
    if decision.verdict is None:  # it is of two clips together
        return told
    word = "yes" if decision.verdict else "no"
    # A bare "no" to a denial could be read either way.
    if decision.part.ask.proposition.denies:
        word += ", that is so" if decision.verdict else ", that is not so"
    return f"{word}: {told}"


def _judged(decision: Decision, recording: Recording) -> str:
    """Return what a claim or a choice rests on: counts and durations first, where it has any."""
    counted = counts_phrase(decision, recording)
    if not counted:
        return _clause(decision, recording)
    if decision.happenings:
        return f"{counted}; {story(decision, largest(decision.happenings), recording)}"
    return f"{counted}; {_clause(decision, recording)}" if decision.movements else counted


def _choice(decision: Decision, recording: Recording) -> str:
    options = decision.part.ask.options
    chosen = [options[at] for at in decision.options]
    labels = [one.label for one in chosen if one.label]
    told = _judged(decision, recording)
    if decision.part.ask.denied:
        names = (
            joined([proposition_words(one.proposition) for one in chosen])
            if chosen
            else "none of them"
        )
        return f"not {names}: {told}"
    if not chosen:
        return f"none of these: {told}"
    if len(options) == 2 and len(chosen) == 2:
        told = f"both: {told}"
    if any(one.proposition.literals[0] == t.Literal("touch") for one in chosen):
        told = f"it touches: {told}"
    if any(one.proposition.literals[0].atom in t.THREAD_ATOMS for one in chosen):
        told = f"it {chosen[0].proposition.literals[0].atom}s: {told}"
    return f"{joined(labels)}: {told}" if labels else told


def _amount(decision: Decision, recording: Recording) -> str:
    if decision.area is not None:
        return f"about {decision.area.share:.0%} of the image is touched"
    if not decision.amounts or decision.still_axis is not None:
        return _clause(decision, recording)
    told = joined([f"about {_spanned(one, decision)}" for one in decision.amounts])
    if decision.part.ask.measure == "path":
        told += " there and back together"
    if decision.rest is not None:
        return f"{told}; {_rest(decision)}"
    moves = [one for one in decision.movements]
    if decision.part.ask.measure == "peak":
        told += f", at {moment(decision.times[0], recording)}"
    names = joined([one.way.value for one in moves])
    times = [one.times for one in moves if one.times is not None]
    when = f", {times_phrase(*times[0], recording)}" if len(times) == 1 else ""
    return f"{told}: {names}{in_frame(decision).removeprefix(',')}{when}"


def _spanned(amount: Measure, decision: Decision) -> str:
    """Return an amount and its span, in brackets where several stand side by side."""
    if len(decision.amounts) == 1:
        return amount_phrase(amount, with_span=True)
    low, high = amount.span
    return f"{amount_phrase(amount)} ({low:g} to {high:g})"


def _kind(decision: Decision, recording: Recording) -> str:
    if decision.rest is not None:
        name = {Motion.STILL: "a still contact", Motion.NONE: "no contact"}[decision.rest]
        return name + f": {_rest(decision)}" * bool(decision.limits)
    kinds = [_KINDS[one.component].value for one in decision.movements]
    return f"a {' and a '.join(kinds)}: {_clause(decision, recording)}"


def _how_sure(decision: Decision, recording: Recording) -> str:
    return f"about {decision.probability:.0%}: {_clause(decision, recording)}"


def _alternatives(decision: Decision, recording: Recording) -> str:
    ways = [way for ways in WAYS.values() for way in ways]
    told = {one.way for one in decision.movements}
    ranked = sorted(zip(decision.chances, ways, strict=True), key=lambda one: -one[0])
    chance, way = next(one for one in ranked if one[1] not in told)
    return f"next likeliest is {way.value}, {chance:.0%}; {_clause(decision, recording)}"


def _why(decision: Decision, recording: Recording) -> str:
    return " ".join([*decision.reasons, f"Therefore: {_clause(decision, recording)}"])


def _place(decision: Decision, _: Recording) -> str:
    area, word = decision.area, {True: "yes: ", False: "no: ", None: ""}[decision.verdict]
    return (
        f"{word}in the {place_words(area)} of the image, its middle at {area.across:.0%} of the "
        f"width and {area.down:.0%} of the height; it covers about {area.share:.0%}"
    )


def place_words(area: ContactArea) -> str:
    """Return the part of the image that the middle of the contact lies in: "upper left"."""
    places = ((area.down, "upper", "lower"), (area.across, "left", "right"))
    named = [
        one if share < 0.5 else other
        for share, one, other in places
        if abs(share - 0.5) > OFF_CENTRE_SHARE
    ]
    return " ".join(named) if len(named) == 2 else f"{named[0]} middle" if named else "middle"


def _compare(decision: Decision, recording: Recording) -> str:
    word = {True: "yes: ", False: "no: ", None: ""}[decision.verdict]
    if decision.part.ask.relation in ("which-more", "which-less"):
        word = f"{' and '.join(SECOND_CLIP[at] for at in decision.options) or 'neither'}: "
    if decision.amounts and len(decision.amounts) == len(decision.each):
        parts = [f"about {amount_phrase(one)}" for one in decision.amounts]
    else:
        parts = [_of_one(one) for one in decision.each]
    told = "; ".join(f"{who} {one}" for who, one in zip(SECOND_CLIP, parts, strict=True))
    ways = [move.way for one in decision.each for move in one.movements]
    is_directed = not decision.amounts and any(way in DIRECTED for way in ways)
    return f"{word}{told}" + in_frame(decision) * is_directed


def _of_one(decision: Decision) -> str:
    """Return what one of two clips shows as a predicate."""
    if decision.rest is not None:
        return {Motion.STILL: "touches but does not move", Motion.NONE: "is untouched"}[
            decision.rest
        ]
    if decision.still_axis is not None:
        return f"does not slide {WORDS[decision.still_axis]}"
    return _all_of([movement_phrase(one) for one in decision.movements])


def _which(decision: Decision, _: Recording) -> str:
    chosen = " and ".join(SECOND_CLIP[at] for at in decision.options) or "neither"
    parts = [f"{who} {_of_one(one)}" for who, one in zip(SECOND_CLIP, decision.each, strict=True)]
    return f"{chosen}: {'; '.join(parts)}{in_frame(decision)}"


def _recording(decision: Decision, recording: Recording) -> str:
    topic, frame = decision.part.ask.topic, decision.frame
    rate = recording.rate_hz
    duration_s = recording.duration_s or (recording.frames / rate if rate else None)
    found = {
        "frames": f"{recording.frames} frames",
        "size": f"{recording.columns} x {recording.rows} pixels",
        "used": f"frames {', '.join(map(str, recording.used))}",
        "rate": f"{rate:g} frames per second" if rate else None,
        "interval": f"{1000 / rate:.3g} ms" if rate else None,
        "duration": duration_s and f"{duration_s:.3g} s",
        "scale": frame.mm_per_px and f"{frame.mm_per_px:g} mm per pixel",
    }[topic]
    lacking = "scale" if topic == "scale" else "rate"
    return replies()["missing"][lacking] if found is None else found


_TELLERS: dict[str, Callable[[Decision, Recording], str]] = {
    **dict.fromkeys(TIMED, tell_times),
    "recording": _recording,
    "way": _way,
    "why": _why,
    "kind": _kind,
    "claim": _claim,
    "choice": _choice,
    "amount": _amount,
    "place": _place,
    "how-sure": _how_sure,
    "alternatives": _alternatives,
    "compare": _compare,
    "which-clip": _which,
}
