"""Frames in, one by one, events out as they end, and a Track at the last: the one way of tracking.

What is kept of each frame is some forty numbers; of pictures, the key frame's and those of half a
second. Nothing is looked at twice but the four frames of a block that the model is asked about.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from copy import copy
from dataclasses import astuple, replace

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.alignment.dots import activity_grey, is_marked, without_dots
from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.core.process import Progress, silent
from geotlm_lm.recordings.idle import (
    CONTACT_UNKNOWN,
    FAINT_IMPRINT,
    estimate_background,
    find_idle,
    imprints_of,
    shows_contact,
    strength_of,
)
from geotlm_lm.recordings.policy import FrameClock
from geotlm_lm.recordings.scene_checks import SceneChecker, SceneReport, scene_of
from geotlm_lm.track.angles import KeyAngles, detail_of
from geotlm_lm.track.block import Believe, Block, Row
from geotlm_lm.track.events import COLUMNS, Event, EventFinder, EventKind, Moment
from geotlm_lm.track.exposure import IdleTracker
from geotlm_lm.track.keyframes import Floats, KeyFrames, Residuals, Step, small_green
from geotlm_lm.track.summed import Shown, Whole, track_of_clip
from geotlm_lm.track.track import Track, decided

LET_GO = 0.8
"""Share of the faintest imprint below which contact ends: it begins at that itself."""

STRENGTH_SPREAD = 0.15
"""Spread of the logarithm of an imprint's strength at which contact is as likely as not."""

ASSUMED_FPS = 25.0

END_FRAMES, TOUCHED_SHARE = 5, 0.8
"""Frames at either end, and their share of the usual imprint from which on they are touched too."""

DOUBTED = 0.01
"""What is left of the distance of contact from an even chance where the pictures may be no gel's:
less would say that nothing touches."""

NO_IDLE = "No untouched gel was seen, so nothing could be tracked; start while nothing touches."

LOST_SHARE = 0.02
"""Share of frames without a readable motion from which a note tells it."""

BLOCK_ROWS = 256
"""Rows for which a copied table has room at first: more than a block of a fast camera."""

_ROW = np.dtype(
    [
        ("numbers", np.int64),
        ("times_s", np.float64),
        ("contact", np.float32),
        ("strength_grey", np.float32),
        ("twists", np.float32, 4),
        ("covariances", np.float32, (4, 4)),
        ("radius_px", np.float32),
        ("turn_shares", np.float32),
    ]
)
"""What is kept of a frame, 112 bytes, under the names of `Track`."""


class Table:
    """Rows of frames, in an array that doubles."""

    def __init__(self) -> None:
        self._count, self._rows = 0, np.zeros(1024, _ROW)
        self.way, self.doubt, self.turned_deg = np.zeros(4), np.zeros((4, 4)), (0.0, 0.0)
        """Sums of all twists and covariances so far; of turns there and back, and their doubt."""

    def __len__(self) -> int:
        return self._count

    def add(
        self, row: Row, twist: NDArray, covariance: NDArray, contact: float, turn_share: float
    ) -> int:
        """Keep a frame and return its place."""
        if self._count == len(self._rows):
            self._rows = np.concatenate([self._rows, np.zeros_like(self._rows)])
        self._rows[self._count] = (
            row.number, row.time_s, contact, row.strength_grey, twist, covariance, row.radius_px,
            turn_share,
        )  # fmt: skip
        self.way, self.doubt = self.way + twist, self.doubt + covariance
        turned, doubted = self.turned_deg
        step_deg = abs(float(twist[0]))
        self.turned_deg = (turned + step_deg, doubted + step_deg * turn_share)
        self._count += 1
        return self._count - 1

    def copied(self) -> Table:
        """Return the same rows, with room for some more."""
        other = copy(self)
        other._rows = np.concatenate([self._rows[: self._count], np.zeros(BLOCK_ROWS, _ROW)])
        return other

    def arrays(self) -> dict[str, NDArray]:
        """Return the columns, as of `Track`."""
        return {
            name: self._rows[name][: self._count].astype(np.int64 if name == "numbers" else float)
            for name in _ROW.names
        }


class Tracker:
    """Follows one recording or stream.

    Args:
        believe: The model's belief of four frames (`block.believer`); None measures only: the depth
            is not known then.
        idle: The untouched gel, uint8 RGB; None learns it while nothing touches.
        is_contact_known: Whether contact is told by that gel; else it is guessed, of one with dots.
        scene: What was noticed about the frames, which are steadied by it; None looks at them.
        whole: The belief of a clip, by which a recording of four frames or fewer is told; None
            measures it as any other.
    """

    def __init__(
        self,
        believe: Believe | None = None,
        *,
        idle: Frames | None = None,
        is_contact_known: bool = True,
        scene: SceneReport | None = None,
        whole: Whole | None = None,
    ) -> None:
        self._believe, self._idle = believe, IdleTracker(idle)
        self._is_contact_known = is_contact_known
        self._whole = whole
        self._shown: list[Shown] = []
        self._waiting: list[Event] = []
        self._table, self._finder, self._block = Table(), EventFinder(), Block()
        self._events: list[Event] = []
        self._keys: KeyFrames | None = None
        self._angles = KeyAngles()
        self._gels: tuple[Floats, Floats] | None = None
        self._bare: Frames | None = None  # as of `without_dots`
        self._before: Frames | None = None
        self._clock, self._checker, self._known_scene = FrameClock(), SceneChecker(), scene
        self._time_s, self._number = 0.0, -1
        self._stepped: list[int] = []
        self._flashed = self._repeated = self._lost = 0

    @property
    def time_s(self) -> float:
        """When the last frame that was taken in was taken, on the track's clock."""
        return self._time_s

    @property
    def idle(self) -> Frames | None:
        """The untouched gel as learnt so far; None while it is being learnt."""
        return self._idle.background

    @property
    def _scene(self) -> SceneReport:
        return self._checker.report if self._known_scene is None else self._known_scene

    @property
    def way(self) -> NDArray[np.float64]:
        """Motion since the first frame as it stands: turn, right, down, inward, (4,).

        The last half second of it is measured alone; the model may correct it yet.
        """
        way = self._finder.way_going_on + self._block.way
        for event in self._events:
            if event.component is not None and event.kind is not EventKind.SLIP:
                part = COLUMNS[event.component]
                way[part] += astuple(event.twist)[part]
        return way

    @property
    def so_far(self) -> Track:
        """The track as far as it is settled: to the end of the last event, or half a second ago."""
        shape = (0, 0) if self._before is None else self._before.shape[:2]
        scene, arrays = self._scene, self._table.arrays()
        arrays["contact"] = self._contact_of(arrays["contact"])
        raw = Track(**arrays, events=(), frame_size=shape, notes=(*scene.notes, *self._notes()),
                    scene=scene, is_contact_known=self.is_contact_known)  # fmt: skip
        return decided(raw, self._doubted(self._events), self._finder.going_on)

    @property
    def is_contact_known(self) -> bool:
        """Whether the untouched gel is known by now, without which nothing tells contact."""
        return self._is_contact_known and self.idle is not None

    def now(self) -> Track:
        """Return the track up to the last frame, as if it ended there; nothing is changed.

        The last half second is measured alone: how deep it went is not asked of the model yet.
        """
        fork = copy(self)
        fork._believe, fork._whole = None, None
        fork._table, fork._finder = self._table.copied(), self._finder.copied()
        fork._events = [*self._events]
        fork._settled()
        fork._events += fork._told(fork._finder.finish())
        return fork.so_far

    def feed(self, frame: Frames, time_s: float, number: int | None = None) -> list[Event]:
        """Take in the next frame and return the events that are over.

        Args:
            frame: uint8, shape (rows, columns, 3), RGB; all of one size.
            time_s: When it was taken; a frame that is no later than the one before is left out, as
                is one that is far brighter or darker than the idle gel. Of a clock that is set back
                the times count on.
            number: Of the frame in its recording; None counts on.

        Raises:
            UnreadableClip: If it is of another size than the frames before.
        """
        self._number = self._number + 1 if number is None else number
        taken_s = self._clock.time_of(time_s, self._number)
        if taken_s is None:
            return []
        self._time_s = taken_s
        if self._known_scene is None:
            steady = self._checker.steadied(frame, self._number, lambda: self.idle)
            if steady is None:
                return []
            frame = steady
        if len(self._shown) <= FRAME_COUNT:
            self._shown.append((Row(self._number, taken_s, 0.0, 0.0, False), frame))
        exposure = self._idle.follow_exposure(frame)
        if exposure is not None:
            self._stepped.append(self._number)
            self._block.expose(exposure)
            if self._keys is not None:
                self._gels = self._small_gels()
        if not self._idle.is_exposed_alike:
            self._flashed += 1
            return []
        row = self._measured(frame)
        self._before = frame
        if self._is_short:
            self._shown[-1] = (row, frame)
        ended = self._block.rows and not row.is_touched and self._block.rows[-1].is_touched
        events = self._settled() if ended else []
        if ended:
            self._angles = KeyAngles()
        self._block.add(row, frame)
        if row.step is not None:
            turn = self._angles.follow(
                row.step,
                taken_s,
                row.strength_grey,
                lambda: detail_of(frame, self._bare),
                is_due=self._block.is_long,
            )
            if turn is not None:
                self._block.correct(turn)
        if not row.is_touched or self._block.is_long:
            events += self._settled()
            if row.is_touched:
                self._block.frames = [(row.time_s, frame)]
        self._waiting += events
        if self._is_short:
            return []
        events, self._waiting = self._waiting, []
        return self._doubted(events)

    def finish(self) -> Track:
        """Return the track of all frames; the last events are those that the end cuts off."""
        if self._is_short and len(self._shown) > 1:
            clip = Clip(np.stack([frame for _, frame in self._shown]), background=self.idle)
            track = track_of_clip(self._shown, self._whole(clip), self._scene.notes)
            doubted = tuple(self._doubted(list(track.events)))
            contact = self._contact_of(track.contact)
            return replace(track, scene=self._scene, events=doubted, contact=contact)
        self._settled()
        self._events += self._told(self._finder.finish())
        return self.so_far

    @property
    def _is_short(self) -> bool:
        """Whether it is a clip of few frames yet, told by what is believed of it as a whole."""
        return self._whole is not None and len(self._shown) <= FRAME_COUNT

    def _measured(self, frame: Frames) -> Row:
        strength = self._idle.strength(frame)
        least = FAINT_IMPRINT * (1 if self._keys is None else LET_GO)
        contact = 0.0 if strength is None else _contact(strength)
        if strength is None or strength < least:
            self._keys = None
            return Row(self._number, self._time_s, strength or 0.0, contact, False)
        step, radius = self._step(frame), self._keys.place.radius_px
        return Row(self._number, self._time_s, strength, contact, True, step, radius)

    def _step(self, frame: Frames) -> Step | None:
        """Return how the contact moved since the frame before; None in its first frame."""
        if self._keys is None:
            self._gels = self._small_gels()
            self._keys = KeyFrames(self._residuals(frame), *frame.shape[:2])
            return None
        if np.array_equal(frame, self._before):
            self._repeated += 1
            return None
        step = self._keys.next(self._residuals(frame))
        self._lost += step.is_lost
        return step

    def _small_gels(self) -> tuple[Floats, Floats]:
        """Return what is taken off frames to see where they are touched, and how that moves."""
        idle = self._idle.background
        self._bare, seen = without_dots(idle), small_green(idle)
        return seen, seen if self._bare is idle else small_green(self._bare)

    def _residuals(self, frame: Frames) -> Residuals:
        green, (seen, moving) = small_green(frame), self._gels
        return Residuals(green - seen, green - moving)

    def _settled(self) -> list[Event]:
        """Write the block down and return the events that are over by then."""
        block, self._block = self._block, Block()
        if not block.rows:
            return []
        believe = self._believe if block.rows[-1].is_touched else None
        twists, covariances, contact = block.settled(believe, lambda: self._idle.background)
        events = []
        shares = block.turn_shares
        for row, twist, covariance, share in zip(
            block.rows, twists, covariances, shares, strict=True
        ):
            sure = row.contact * contact
            place = self._table.add(row, twist, covariance, sure, share)
            way, doubt = self._table.way, self._table.doubt
            moment = Moment(place, row.number, row.time_s, sure, row.is_touched, way, doubt,
                            row.radius_px, self._table.turned_deg)  # fmt: skip
            events += self._told(self._finder.push(moment))
        self._events += events
        return events

    def _told(self, events: list[Event]) -> list[Event]:
        known = self._is_contact_known
        return [event for event in events if known or not event.is_of_contact]

    def _contact_of(self, contact: NDArray) -> NDArray:
        return 0.5 + DOUBTED * (contact - 0.5) if self._scene.suspicion else contact

    def _doubted(self, events: list[Event]) -> list[Event]:
        """Return events at most as probable as not where the pictures may not be a gel's."""
        if not events or not self._scene.suspicion:
            return events
        return [replace(event, probability=0.5 * event.probability) for event in events]

    def _notes(self) -> tuple[str, ...]:
        notes = [] if self.idle is not None else [NO_IDLE]
        notes += [] if self._is_contact_known else [CONTACT_UNKNOWN]
        notes += self._clock.notes()
        if self._flashed:
            notes.append(
                f"{self._flashed} frames are much brighter or darker than the idle gel and left "
                f"out; lock the camera's exposure."
            )
        if self._stepped:
            times = "once" if len(self._stepped) == 1 else f"{len(self._stepped)} times"
            notes.append(
                f"The exposure of the whole picture changes {times}, first in frame "
                f"{self._stepped[0]}, and is followed; lock the camera's exposure."
            )
        if self._repeated:
            notes.append(f"{self._repeated} frames repeat the one before.")
        frames = len(self._table)
        if self._lost > LOST_SHARE * frames:
            notes.append(
                f"In {self._lost} of {frames} frames the imprint was lost: how it moved there is "
                f"not known."
            )
        return tuple(notes)


Follow = Callable[[Tracker], bool | None]
"""Looks at a track that is growing and changes nothing; what returns True ends it there."""


def unfollowed(_: Tracker) -> None:
    """Look at nothing."""


def track_of(
    source: Clip | Iterable[tuple[Frames, float]],
    believe: Believe | None = None,
    *,
    idle: Frames | None = None,
    whole: Whole | None = None,
    progress: Progress = silent,
    scene: SceneReport | None = None,
    follow: Follow = unfollowed,
) -> Track:
    """Return the track of a recording; arguments and errors as of `Tracker`.

    The source is a clip, whose idle gel is looked for first, or frames with their times. Progress
    is told, and `follow` called, after each frame of a clip. One that `follow` ends has five frames
    at least, and a note where that was.
    """
    if not isinstance(source, Clip):
        tracker = Tracker(believe, idle=idle, whole=whole)
        for frame, time_s in source:
            tracker.feed(frame, time_s)
        return tracker.finish()
    if scene is None:
        scene = scene_of(source)
        source = scene.steadied(source)
    gel, is_known = idle if idle is not None else source.background, True
    if gel is None:
        gel, is_known = gel_of(source)
    tracker = Tracker(believe, idle=gel, is_contact_known=is_known, scene=scene, whole=whole)
    numbered = zip(source.frames, source.frame_numbers, strict=True)
    for done, (frame, number) in enumerate(numbered, start=1):
        tracker.feed(frame, source.second_of(number, ASSUMED_FPS), number)
        is_ended = follow(tracker)
        progress("tracking", done, len(source))
        if is_ended and FRAME_COUNT < done < len(source):
            track = tracker.finish()
            return replace(track, notes=(*track.notes, _ended(source, number)), is_cut=True)
    return tracker.finish()


def _ended(clip: Clip, number: int) -> str:
    last = clip.frame_numbers[-1]
    if not clip.is_timed:
        return f"Stopped at frame {number} of {last}."
    ends = (clip.second_of(each, ASSUMED_FPS) for each in (number, last))
    return "Stopped at {:.1f} s of {:.1f} s.".format(*ends)


def gel_of(clip: Clip) -> tuple[Frames | None, bool]:
    """Return the idle gel of a recording, and whether it tells contact.

    It is guessed where it is not seen: contact is known then as of `shows_contact`. None where it
    can be learnt from the first frames: they show less of an imprint than others.
    """
    grey = activity_grey(clip.frames)
    idle = find_idle(clip, grey)
    if idle is not None:
        return idle, True
    guess = estimate_background(clip.frames)
    strength = strength_of(imprints_of(grey, guess))
    at_ends = min(np.median(strength[:END_FRAMES]), np.median(strength[-END_FRAMES:]))
    if at_ends <= TOUCHED_SHARE * np.median(strength) and not is_marked(grey):
        return None, True
    return guess, shows_contact(grey, guess)


def _contact(strength: float) -> float:
    beyond = math.log(max(strength, 1e-6) / FAINT_IMPRINT) / STRENGTH_SPREAD
    return 1 / (1 + math.exp(-min(max(beyond, -30.0), 30.0)))
