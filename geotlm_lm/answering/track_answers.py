"""Answer what only a whole recording tells: what happened when, in which order, how often."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from geotlm_lm.answering.abstention import neutral_answer
from geotlm_lm.answering.answer import Answer
from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.measured_motion import MeasuredMotion
from geotlm_lm.answering.track_wording import (
    TrackWording,
    times_of,
)
from geotlm_lm.conversation.track_questions import Doing, TrackAsk, asked_doing, track_ask
from geotlm_lm.conversation.wording import capitalised, frame_phrase
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED
from geotlm_lm.track.events import MOVING, TOGETHER_S, Event, EventKind
from geotlm_lm.track.whole import main_event, path_of_event, together_s

TOLD = (EventKind.TOUCH, EventKind.PRESS, *MOVING, EventKind.STICK, EventKind.RELEASE)
"""Events of a story; a slip is a turn or slide that is told already."""

_DONE = {
    Doing.HOLD: EventKind.TOUCH,
    Doing.LET_GO: EventKind.RELEASE,
    Doing.SLIP: EventKind.SLIP,
    Doing.STILL: EventKind.STICK,
    Doing.PRESS: EventKind.PRESS,
    Doing.TURN: EventKind.TURN,
    Doing.SLIDE: EventKind.SLIDE,
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
_GOING = {
    EventKind.TURN: "turns",
    EventKind.SLIDE: "slides",
    EventKind.SLIP: "slips",
    EventKind.STICK: "is held still",
    EventKind.PRESS: "presses in",
    EventKind.RELEASE: "lifts off",
}

_DENIED = {
    EventKind.TOUCH: "Nothing touches",
    EventKind.PRESS: "It does not press in",
    EventKind.TURN: "It does not turn",
    EventKind.SLIDE: "It does not slide",
    EventKind.SLIP: "It does not slip from a rest",
    EventKind.STICK: "It is never held still",
    EventKind.RELEASE: "It is not let go",
}


def answer_of_track(encoded: Encoded, question: str, frame: FrameSpec) -> Answer | None:
    """Return the answer that a recording's track gives; None where the motion as a whole does.

    Args:
        encoded: The recording, or a span of it.
        question: What is asked.
        frame: In which to tell.
    """
    track, ask = encoded.track, track_ask(question)
    if track is None or ask is None:
        return None
    told, doing = _Telling(encoded, frame), asked_doing(question)
    kinds = () if doing is None else (_DONE[doing],)
    if ask in (TrackAsk.STORY, TrackAsk.FIRST, TrackAsk.LAST, TrackAsk.NEXT):
        return told.story(ask)
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


class _Telling:
    """Answers about the events of one recording, in a frame."""

    def __init__(self, encoded: Encoded, frame: FrameSpec) -> None:
        self.encoded, self.track, self.frame = encoded, encoded.track, frame
        self.words = TrackWording(encoded, frame)
        is_part = encoded.whole_track is not None and encoded.whole_track is not encoded.track
        self.whole = "this part of the recording" if is_part else "the recording"

    def story(self, ask: TrackAsk) -> Answer:
        """Tell events in their order, the first, the last, or what follows the first."""
        events = self.words.in_order([one for one in self.track.events if one.kind in TOLD])
        if not events and not self.track.is_touched.any():
            return self._plain(f"Nothing touches in {self.whole}.", 1 - self._touching())
        if not events:
            return self._plain(f"It neither moves nor presses in {self.whole}.", self._touching())
        told = self.words.largest(events)
        if ask is TrackAsk.FIRST:
            told = self._first(told)
        elif ask is TrackAsk.LAST:
            told = self._last(told)
        elif ask is TrackAsk.NEXT:
            told = [one for one in told if one not in self._first(told)] or told
        directed = [one for one in told if one.motion in DIRECTED]
        where = f", {frame_phrase(self.frame)}" if directed else ""
        main = max(directed, key=self._path, default=told[0])
        sure = min(one.probability for one in told)
        return self._answer(f"{capitalised(self.words.story(told))}{where}.", sure, main)

    def when(self, kinds: Sequence[EventKind], *, is_end: bool) -> Answer:
        """Tell when something began, or ended."""
        if kinds == (EventKind.TOUCH,):
            return self._contact(is_end=is_end)
        found = self._of(kinds)
        if not found:
            return self._nothing(kinds)
        if kinds == (EventKind.RELEASE,):
            at, text = self.words.time(found[-1].end_s), self.words.clause(found[-1])
            return self._answer(f"{capitalised(text)}.", found[-1].probability, found[-1], at)
        one = max(found, key=lambda each: each.end) if is_end else found[0]
        at = self.words.time(one.end_s if is_end else one.begin_s)
        clause = capitalised(self.words.clause(one, with_time=False))
        text = f"{clause}, until {at}." if is_end else f"{clause}, from {at} on."
        return self._answer(text, one.probability, one, decided=at)

    def duration(self, kinds: Sequence[EventKind]) -> Answer:
        """Tell how long something went on."""
        if kinds == (EventKind.TOUCH,):
            spans = self.track.contacts()
            if not spans:
                return self._nothing(kinds)
            long = self.words.long(sum(last - first for first, last in spans))
            ends = f"from {self.words.time(spans[0][0])} to {self.words.time(spans[-1][1])}"
            often = f"{len(spans)} times, " if len(spans) > 1 else ""
            return self._plain(f"It is touched for {long}, {often}{ends}.", self._touching(), long)
        found = self._of(kinds)
        if not found:
            return self._nothing(kinds)
        long = self.words.long(together_s(found))
        same = all(one.kind is found[0].kind for one in found)
        what = _GOING[found[0].kind] if same else "moves"
        text = f"It {what} for {long}, {times_of(self.encoded, found)}."
        sure = min(one.probability for one in found)
        return self._answer(text, sure, max(found, key=self._path), decided=long)

    def fastest(self, kinds: Sequence[EventKind]) -> Answer:
        """Tell when it was fastest, and how fast."""
        found = [one for one in self._of(kinds) if one.kind in MOVING]
        main = main_event(self.track)
        one = main if main in found else max(found, key=self._path, default=None)
        if one is None:
            return self._nothing(kinds)
        time_s, speed = self.track.fastest(one.component)
        unit, per_px = self.words.length_of(one)
        named = {"px": "pixels", "mm": "millimetres"}[unit]
        if one.kind is EventKind.TURN:
            named, per_px = "degrees", 1.0
        at, way = self.words.time(time_s), self.frame.tell(one.motion)
        text = f"It is fastest at {at}: about {abs(speed) * per_px:.2g} {named} per second"
        return self._answer(f"{text}, {way.value}.", one.probability, one, decided=at)

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
        clauses = self.words.story(self.words.largest(events))
        decided = ("yes" if count else "no") if asks_whether else str(count)
        return self._answer(f"{before}. {capitalised(clauses)}.", sure, events[0], decided=decided)

    def count(self, kinds: Sequence[EventKind]) -> Answer:
        """Tell how often something happened."""
        found = [one for one in self.track.events if one.kind in kinds]
        names = _NOUNS[kinds[0]] if len(kinds) == 1 else ("motion", "motions")
        if not found:
            return self._plain(f"No {names[0]} in {self.whole}.", self._touching(), decided="0")
        number = f"{len(found)} {names[len(found) > 1]}"
        clauses = self.words.story(self.words.largest(found))
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
            text = f"Yes, it slips{after}: {self.words.clause(one)}."
            return self._answer(text, one.probability, one, decided="yes")
        moved = [one for one in self.track.events if one.kind in MOVING]
        moved = self.words.largest(moved)[-1:]
        how = self.words.clause(moved[0]) if moved else "nor does it move otherwise"
        text = f"No, it does not slip from a rest; {how}"
        sure = min((one.probability for one in moved), default=self._touching())
        return self._answer(f"{text}.", sure, moved[0] if moved else None, decided="no")

    def _contact(self, *, is_end: bool) -> Answer:
        spans = self.track.contacts()
        if not spans:
            return self._nothing((EventKind.TOUCH,))
        time_s = spans[-1][1] if is_end else spans[0][0]
        at = self.words.time(time_s)
        ends = "the last frame" if time_s == self.track.times_s[-1] else at
        text = f"It is touched until {ends}." if is_end else f"It touches from {at} on."
        return self._plain(text, self._touching(), decided=at)

    def _first(self, events: Sequence[Event]) -> list[Event]:
        """Return a touch and what presses in with it, else the largest of what begins first."""
        begun = [one for one in events if one.begin_s <= events[0].begin_s + TOGETHER_S]
        if events[0].kind is EventKind.TOUCH:
            return [one for one in begun if one.kind in (EventKind.TOUCH, EventKind.PRESS)]
        return [max(begun, key=self._path)]

    def _last(self, events: Sequence[Event]) -> list[Event]:
        """Return what ends last: that it lifts off, else the largest."""
        end_s = max(one.end_s for one in events)
        ended = [one for one in events if one.end_s >= end_s - TOGETHER_S]
        lifted = [one for one in ended if one.kind is EventKind.RELEASE]
        return lifted[-1:] or [max(ended, key=self._path)]

    def _path(self, event: Event) -> float:
        return path_of_event(self.track, event)

    def _of(self, kinds: Sequence[EventKind]) -> list[Event]:
        return [one for one in self.track.events if one.kind in (kinds or MOVING)]

    def _nothing(self, kinds: Sequence[EventKind]) -> Answer:
        sure = self._touching() if kinds != (EventKind.TOUCH,) else 1 - self._touching()
        denied = _DENIED[kinds[0]] if len(kinds) == 1 else "It does not move"
        return self._plain(f"{denied} in {self.whole}.", sure, decided="none")

    def _touching(self) -> float:
        return float(self.track.contact.max(initial=0.0))

    def _plain(self, text: str, sure: float, decided: str | None = None) -> Answer:
        return self._answer(text, sure, None, decided)

    def _answer(
        self, text: str, sure: float, event: Event | None, decided: str | None = None
    ) -> Answer:
        motion = None if event is None else self.frame.tell(event.motion)
        amount = None
        if event is not None and event.component is not None:
            amount = self.words.amount(event)
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
