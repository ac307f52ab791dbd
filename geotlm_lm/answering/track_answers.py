"""Answer what only a whole recording tells: what happened when, in which order, how often."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from geotlm_lm.answering.abstention import neutral_answer
from geotlm_lm.answering.amounts import Amount, Measure
from geotlm_lm.answering.answer import Answer
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.measured_motion import MeasuredMotion, pixel_scale
from geotlm_lm.conversation.motion_answers import asked_components
from geotlm_lm.conversation.track_questions import Doing, TrackAsk, asked_doing, track_ask
from geotlm_lm.conversation.wording import capitalised, frame_phrase
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, Motion
from geotlm_lm.core.tolerance import TOLERANCES
from geotlm_lm.core.twist import Component
from geotlm_lm.track.events import MOVING, Event, EventKind
from geotlm_lm.track.track import Track
from geotlm_lm.track.whole import main_event

TOLD = (EventKind.TOUCH, EventKind.PRESS, *MOVING, EventKind.STICK, EventKind.RELEASE)
"""Events of a story; a slip is a turn or slide that is told already."""

MOST_TOLD = 12
"""Events told one by one; of a longer recording the largest."""

_KINDS = {Component.TURN: EventKind.TURN, Component.SLIDE: EventKind.SLIDE}
_DONE = {
    Doing.HOLD: EventKind.TOUCH,
    Doing.LET_GO: EventKind.RELEASE,
    Doing.SLIP: EventKind.SLIP,
    Doing.STILL: EventKind.STICK,
    Doing.PRESS: EventKind.PRESS,
}
_NOUNS = {
    EventKind.TOUCH: ("touch", "touches"),
    EventKind.PRESS: ("press", "presses"),
    EventKind.TURN: ("turn", "turns"),
    EventKind.SLIDE: ("slide", "slides"),
    EventKind.STICK: ("rest", "rests"),
    EventKind.SLIP: ("slip", "slips"),
    EventKind.RELEASE: ("release", "releases"),
}
NOTHING = "Nothing of that happens in the recording."


def answer_of_track(encoded: Encoded, question: str, frame: FrameSpec) -> Answer | None:
    """Return the answer that a recording's track gives; None where the motion as a whole does.

    Args:
        encoded: The recording, or a span of it.
        question: What is asked.
        frame: In which to tell.
    """
    track, ask = encoded.track, track_ask(question)
    if track is None:
        return None
    told = _Telling(encoded, frame)
    kinds = _asked_kinds(question)
    if ask is None:
        return None
    if ask in (TrackAsk.STORY, TrackAsk.FIRST, TrackAsk.LAST, TrackAsk.NEXT):
        return told.story(ask, [one for one in track.events if one.kind in TOLD])
    if ask is TrackAsk.SLIPPED:
        return told.slipped()
    if ask is TrackAsk.FASTEST:
        return told.fastest(kinds)
    if ask is TrackAsk.TURNED_BACK:
        return told.turned_back(question)
    if ask is TrackAsk.COUNT:
        return told.count(kinds or MOVING)
    if ask is TrackAsk.DURATION:
        return told.duration(kinds)
    return told.when(kinds, is_end=ask is TrackAsk.ENDED)


def goes_both_ways(track: Track, components: Sequence[Component]) -> list[Event]:
    """Return the turns and slides asked about where some of them go against others; else none."""
    kinds = [_KINDS[one] for one in components if one in _KINDS] or MOVING
    events = [one for one in track.events if one.kind in kinds]
    ways: dict[EventKind, set[Motion]] = {}
    for event in events:
        ways.setdefault(event.kind, set()).add(motion_of(event))
    return events if any(len(found) > 1 for found in ways.values()) else []


def story_of(encoded: Encoded, events: Sequence[Event], frame: FrameSpec) -> Answer:
    """Return the answer that tells events one after another."""
    return _Telling(encoded, frame).story(TrackAsk.STORY, events)


def motion_of(event: Event) -> Motion:
    """Return which of the ten words an event is, in the camera image."""
    if event.kind is EventKind.TOUCH:
        return Motion.PRESS
    if event.kind is EventKind.STICK:
        return Motion.STILL
    return event.twist.way(event.component)


def times_of(encoded: Encoded, events: Sequence[Event]) -> str:
    """Return from when to when events went on: "from 1.2 s to 3.4 s", or in frames."""
    first, last = min(events, key=lambda one: one.begin), max(events, key=lambda one: one.end)
    if encoded.clip.fps is None:
        return f"from frame {first.begin} to {last.end}"
    return f"from {first.begin_s:.2g} s to {last.end_s:.3g} s"


def _asked_kinds(question: str) -> tuple[EventKind, ...]:
    """Return the kinds of events that a question is about; none where it is about any motion."""
    doing = asked_doing(question)
    if doing is not None:
        return (_DONE[doing],)
    return tuple(_KINDS[one] for one in asked_components(question) if one in _KINDS)


class _Telling:
    """Puts the events of one recording into words, in a frame."""

    def __init__(self, encoded: Encoded, frame: FrameSpec) -> None:
        self.encoded, self.track, self.frame = encoded, encoded.track, frame

    def story(self, ask: TrackAsk, events: Sequence[Event]) -> Answer:
        """Tell events in their order, the first, the last, or what follows the first."""
        if not events:
            return self._plain("Nothing touches in the recording.", 1 - self._touching())
        named = sorted(events, key=lambda one: (one.begin, one.kind is not EventKind.TOUCH))
        if ask is TrackAsk.FIRST:
            named = named[:1]
        elif ask is TrackAsk.LAST:
            named = named[-1:]
        elif ask is TrackAsk.NEXT:
            named = named[1:] or named
        if len(named) > MOST_TOLD:
            named = [one for one in named if one.kind in MOVING][:MOST_TOLD] or named[:MOST_TOLD]
        clauses = [self._clause(one) for one in named]
        text = clauses[0] if len(clauses) == 1 else ", then ".join(clauses)
        directed = [one for one in named if motion_of(one) in DIRECTED]
        where = f", {frame_phrase(self.frame)}" if directed else ""
        main = max(directed, key=lambda one: abs(one.amount.mean), default=named[0])
        sure = min(one.probability for one in named)
        return self._answer(f"{capitalised(text)}{where}.", sure, main)

    def when(self, kinds: Sequence[EventKind], *, is_end: bool) -> Answer:
        """Tell when something began, or ended."""
        if kinds == (EventKind.TOUCH,):
            return self._contact(is_end=is_end)
        found = self._of(kinds)
        if not found:
            return self._nothing(kinds)
        one = found[-1] if is_end else found[0]
        at = self._time(one.end_s if is_end else one.begin_s, one.end if is_end else one.begin)
        clause = self._clause(one, with_time=False)
        text = f"{'Until' if is_end else 'From'} {at}{' on' * (not is_end)}: {clause}."
        return self._answer(text, one.probability, one, decided=at)

    def duration(self, kinds: Sequence[EventKind]) -> Answer:
        """Tell how long something went on."""
        if kinds == (EventKind.TOUCH,):
            spans = self.track.contacts()
            if not spans:
                return self._nothing(kinds)
            long = sum(last - first for first, last in spans)
            text = f"It is touched for {self._long(long)}"
            text += f", {len(spans)} times" if len(spans) > 1 else self._span(*spans[0])
            return self._plain(f"{text}.", self._touching(), decided=self._long(long))
        found = self._of(kinds)
        if not found:
            return self._nothing(kinds)
        long = sum(one.seconds for one in found)
        what = "holds still" if found[0].kind is EventKind.STICK else "goes on"
        times = times_of(self.encoded, found)
        text = f"It {what} for {self._long(long)}, {times}."
        sure = min(one.probability for one in found)
        return self._answer(text, sure, found[0], decided=self._long(long))

    def fastest(self, kinds: Sequence[EventKind]) -> Answer:
        """Tell when it was fastest, and how fast."""
        found = self._of(kinds)
        main = main_event(self.track)
        one = max(found, key=lambda each: abs(each.amount.mean), default=None)
        one = main if one is None or (main in found) else one
        if one is None or one.kind not in MOVING:
            return self._nothing(kinds)
        time_s, speed = self.track.fastest(one.component)
        unit, scale = pixel_scale(self.encoded, self.frame)
        speed = abs(speed)
        if one.kind is EventKind.SLIDE:
            way = np.array([one.twist.right_px, one.twist.down_px])
            speed *= float(np.linalg.norm(scale @ way) / max(np.linalg.norm(way), 1e-9))
        names = {"deg": "degrees", "px": "pixels", "mm": "millimetres"}
        named = names["deg" if one.kind is EventKind.TURN else unit]
        place = int(np.searchsorted(self.track.times_s, time_s))
        at = self._time(time_s, int(self.track.numbers[place]))
        way = self.frame.tell(motion_of(one))
        text = f"Fastest at {at}: about {speed:.2g} {named} per second, {way.value}."
        return self._answer(text, one.probability, one, decided=at)

    def turned_back(self, question: str) -> Answer:
        """Tell how often it turned back; to a yes-or-no question, whether."""
        events = [one for one in self.track.events if one.kind is EventKind.TURN]
        count = self.track.turned_back()
        how_often = "It never turns back" if count == 0 else f"It turns back {_times(count)}"
        sure = min((one.probability for one in events), default=self._touching())
        asks_whether = not question.lower().startswith(("how", "number", "count"))
        verdict = "Yes: " if count else "No: "
        before = (verdict + how_often[0].lower() + how_often[1:]) if asks_whether else how_often
        if not events:
            return self._plain(f"{before}; it does not turn.", sure, decided="no")
        clauses = ", then ".join(self._clause(one) for one in events[:MOST_TOLD])
        decided = ("yes" if count else "no") if asks_whether else str(count)
        return self._answer(f"{before}. {capitalised(clauses)}.", sure, events[0], decided=decided)

    def count(self, kinds: Sequence[EventKind]) -> Answer:
        """Tell how often something happened."""
        found = [one for one in self.track.events if one.kind in kinds]
        if kinds == (EventKind.TOUCH,):
            found = found or []
        names = _NOUNS[kinds[0]] if len(kinds) == 1 else ("motion", "motions")
        if not found:
            return self._plain(f"No {names[0]} in the recording.", self._touching(), decided="0")
        number = f"{len(found)} {names[len(found) > 1]}"
        clauses = ", then ".join(self._clause(one) for one in found[:MOST_TOLD])
        sure = min(one.probability for one in found)
        text = f"{capitalised(number)}: {clauses}."
        return self._answer(text, sure, found[0], decided=str(len(found)))

    def slipped(self) -> Answer:
        """Tell whether it slipped before it was let go."""
        slips = self._of((EventKind.SLIP,))
        released = self._of((EventKind.RELEASE,))
        if slips:
            one = slips[-1]
            after = " before it is let go" if released and one.begin < released[-1].end else ""
            text = f"Yes, it slips{after}: {self._clause(one)}."
            return self._answer(text, one.probability, one, decided="yes")
        moved = [one for one in self.track.events if one.kind in MOVING]
        text = "No, it does not slip from a rest"
        text += f"; {self._clause(moved[-1])}" if moved else " nor move at all while it is touched"
        sure = min((one.probability for one in moved), default=self._touching())
        return self._answer(f"{text}.", sure, moved[-1] if moved else None, decided="no")

    def _contact(self, *, is_end: bool) -> Answer:
        spans = self.track.contacts()
        if not spans:
            return self._nothing((EventKind.TOUCH,))
        time_s = spans[-1][1] if is_end else spans[0][0]
        place = int(np.searchsorted(self.track.times_s, time_s))
        at = self._time(time_s, int(self.track.numbers[place]))
        ends = "the last frame" if place == len(self.track) - 1 else at
        text = f"It is touched until {ends}." if is_end else f"It touches from {at} on."
        return self._plain(text, self._touching(), decided=at)

    def _of(self, kinds: Sequence[EventKind]) -> list[Event]:
        return [one for one in self.track.events if one.kind in (kinds or MOVING)]

    def _nothing(self, kinds: Sequence[EventKind]) -> Answer:
        sure = self._touching() if kinds != (EventKind.TOUCH,) else 1 - self._touching()
        return self._plain(NOTHING, sure, decided="none")

    def _clause(self, event: Event, *, with_time: bool = True) -> str:
        """Return an event as a clause: "it turns clockwise, about 58 degrees, from 1 s to 3 s"."""
        times = self._times(event) if with_time else ""
        if event.kind is EventKind.TOUCH:
            return f"it touches{times}"
        if event.kind is EventKind.STICK:
            return f"it is held still{times}"
        if event.kind is EventKind.RELEASE and event.begin == event.end:
            return f"it lets go{times}"
        verbs = {EventKind.PRESS: "it presses in", EventKind.RELEASE: "it lifts off"}
        amount = f", {self.amount(event).phrase}" if abs(event.amount.mean) > 0 else ""
        if event.kind in verbs:
            return f"{verbs[event.kind]}{amount if event.kind is EventKind.PRESS else ''}{times}"
        who = "the sensor" if self.frame.actor == "sensor" else "it"
        verb = "slips" if event.kind is EventKind.SLIP else event.component.value + "s"
        return f"{who} {verb} {self.frame.tell(motion_of(event)).value}{amount}{times}"

    def amount(self, event: Event) -> Amount:
        """Return how far an event goes, in the unit that is told."""
        far, deviation = abs(event.amount.mean), event.amount.deviation
        if event.component is Component.TURN:
            return Measure(far, deviation, "deg", TOLERANCES["deg"], "turning").amount()
        if event.component is Component.PRESS:
            return Measure(far, deviation, "mm", TOLERANCES["mm"], "pressing in").amount()
        unit, scale = pixel_scale(self.encoded, self.frame)
        way = np.array([event.twist.right_px, event.twist.down_px])
        per_px = float(np.linalg.norm(scale @ way) / max(np.linalg.norm(way), 1e-9))
        tolerance = TOLERANCES["px"] * per_px
        return Measure(far * per_px, deviation * per_px, unit, tolerance, "sliding").amount()

    def _times(self, event: Event) -> str:
        if event.begin == event.end:
            return f" at {self._time(event.begin_s, event.begin)}"
        return f", {times_of(self.encoded, [event])}"

    def _time(self, time_s: float, number: int) -> str:
        return f"frame {number}" if self.encoded.clip.fps is None else f"{time_s:.3g} s"

    def _long(self, seconds: float) -> str:
        if self.encoded.clip.fps is None:
            step = np.median(np.diff(self.track.times_s)) / np.median(np.diff(self.track.numbers))
            return f"{round(seconds / float(step))} frames"
        return f"{seconds:.2g} s"

    def _span(self, first_s: float, last_s: float) -> str:
        places = np.searchsorted(self.track.times_s, [first_s, last_s])
        numbers = self.track.numbers[np.minimum(places, len(self.track) - 1)]
        first, last = (
            self._time(t, int(n)) for t, n in zip((first_s, last_s), numbers, strict=True)
        )
        return f", from {first} to {last}"

    def _touching(self) -> float:
        return float(self.track.contact.max(initial=0.0))

    def _plain(self, text: str, sure: float, decided: str | None = None) -> Answer:
        return self._answer(text, sure, None, decided)

    def _answer(
        self, text: str, sure: float, event: Event | None, decided: str | None = None
    ) -> Answer:
        motion = None if event is None else self.frame.tell(motion_of(event))
        amount = None
        if event is not None and event.component is not None:
            amount = self.amount(event)
        answer = neutral_answer(self.encoded, text, "order", self.frame)
        options = {} if decided is None else {decided: sure}
        return replace(
            answer,
            direction=motion,
            confidence=float(sure),
            abstained=False,
            options=options,
            decided=decided or (motion and motion.value),
            amount=amount,
            motion=MeasuredMotion.of(self.encoded, self.frame),
            notes=(*answer.notes, *self.track.notes),
        )


def _times(count: int) -> str:
    return {1: "once", 2: "twice"}.get(count, f"{count} times")
