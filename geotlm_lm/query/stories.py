"""What happens one after another, in a sentence: the times, ways and amounts of events."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, Motion
from geotlm_lm.query.phrases import amount_phrase, joined, way_phrase, where_phrase
from geotlm_lm.query.values import Recording, Shown, Value
from geotlm_lm.track.events import MOVING, TOGETHER_S, EventKind

MOST_TOLD, MOST_MOVING = 4, 3
"""Events of a story that are told: of more, the largest motions, and where contact begins and ends
as far as there is room."""

SMALL = 0.2
"""Share of the longest path below which a motion is left out of a story."""


@dataclass(frozen=True)
class Narrator:
    """Says where, when and in which order something happens in one recording and frame.

    Args:
        recording: The file, for its times and for questions on itself.
        frame: In which the recording's facts hold.
        named: The point of view that was named before, in words.
    """

    recording: Recording
    frame: FrameSpec = FrameSpec()
    named: str | None = None

    def where(self, value: Value, ways: Sequence[Motion]) -> str:
        """Return ", in the camera image" and the like; nothing where it was named before."""
        where = where_phrase(value.edit, self.frame)
        is_named = where == self.named or not any(way in DIRECTED for way in ways)
        return "" if is_named else f", {where}"

    def moment(self, time_s: float) -> str:
        """Return a time: "1.24 s", or a frame's number of a recording without a rate."""
        if self.recording.rate_hz is None:
            return f"frame {self.frames(time_s)}"
        whole, part = f"{time_s:.{self.recording.decimals}f}".split(".")
        return f"{whole}.{part.rstrip('0') or '0'} s"

    def frames(self, time_s: float) -> int:
        """Return a time in frames."""
        return round(time_s / (self.recording.step_s or 1.0))

    def span(self, times: tuple[float, float]) -> str:
        """Return from when to when: "from 1.2 s to 3.4 s"."""
        begin, end = map(self.moment, times)
        if begin == end:
            return f"at {begin}"
        return f"from {begin.removesuffix(' s')} to {end.removeprefix('frame ')}"

    def who(self, value: Value) -> str:
        """Return whose motion is told."""
        return "the sensor" if value.edit.sensor else "it"

    def story(self, value: Value, shown: Sequence[Shown], of: Sequence[Shown] = ()) -> str:
        """Return events in order, the frame where a way is named, and how many more moved."""
        if not shown:
            return ""
        shown = sorted(shown, key=_told_at)
        text = f"{self.who(value)} {self._event(shown[0])}"
        for before, each in pairwise(shown):
            event = self._event(each)
            is_same = before.kind is each.kind and each.kind in MOVING
            text += f", {event.partition(' ')[2]}" if is_same else f"; {event}"
        ways = [each.way for each in shown if each.kind in MOVING]
        return text + self.where(value, ways) + _left_out(shown, of)

    def _event(self, shown: Shown) -> str:
        if shown.kind is EventKind.TOUCH:
            return f"touches at {self.moment(shown.begin_s)}"
        when = self.span((shown.begin_s, shown.end_s))
        if shown.kind is EventKind.STICK:
            return f"is held still {when}"
        if shown.kind is EventKind.RELEASE:
            is_over = f"is let go at {self.moment(shown.end_s)}"
            return is_over if shown.is_edge else f"is pressed less {when}"
        if shown.kind is EventKind.PRESS:
            return f"presses in {when}"
        far = f" {amount_phrase(shown.amount)}" if shown.amount is not None else ""
        return f"{shown.kind.value}s {way_phrase(shown)}{far} {when}"


def most(shown: Sequence[Shown], count: int) -> list[Shown]:
    """Return the events that matter most, by when they begin."""
    ends = (EventKind.TOUCH, EventKind.RELEASE)
    moving = [each for each in shown if each.kind in MOVING]
    longest = max((each.path_px for each in moving), default=0.0)
    large = [each for each in moving if each.path_px >= SMALL * longest]
    large = sorted(large, key=lambda each: -each.path_px)[: min(count, MOST_MOVING)]
    begun = [each for each in shown if each.kind in ends]
    # The first touch, then the last release, then those between.
    begun = [*begun[:1], *begun[:0:-1]]
    kept = [*large, *begun][:count] or shown[:count]
    return [each for each in shown if each in kept]


def consecutive(value: Value) -> list[Shown]:
    """Return the motions that an answer rests on where some follow others."""
    moving = most([each for each in value.shown if each.kind in MOVING], MOST_TOLD)
    is_over = min((each.end_s for each in moving), default=0.0) - TOGETHER_S
    return moving if any(each.begin_s >= is_over for each in moving) else []


def is_from_to(shown: Shown, times: tuple[float, ...]) -> bool:
    """Tell whether an event begins and ends at about two times."""
    ends = zip(times, (shown.begin_s, shown.end_s), strict=True)
    return all(abs(one - other) <= TOGETHER_S for one, other in ends)


def _left_out(shown: Sequence[Shown], of: Sequence[Shown]) -> str:
    """Return how many turns and slides a story leaves out: "; and 19 more turns"."""
    counts = [
        (kind, sum(each.kind is kind for each in of) - sum(each.kind is kind for each in shown))
        for kind in MOVING
    ]
    more = [f"{count} more {kind.value}{'s' * (count > 1)}" for kind, count in counts if count > 0]
    return f"; and {joined(more)}" if more else ""


def _told_at(shown: Shown) -> float:
    """Return when an event is: of the end of contact, its end."""
    return shown.end_s if shown.kind is EventKind.RELEASE else shown.begin_s
