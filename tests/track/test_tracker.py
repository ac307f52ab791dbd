"""A stream is tracked frame by frame, whatever befalls its frames and however long it is."""

import tracemalloc
from dataclasses import replace
from itertools import cycle, islice

import numpy as np
import pytest

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import Component
from geotlm_lm.recordings.idle import CONTACT_UNKNOWN
from geotlm_lm.simulation.scene import Body, Path, Scene
from geotlm_lm.simulation.simulate import simulate
from geotlm_lm.track.events import EventFinder, EventKind, Moment
from geotlm_lm.track.export import Exported
from geotlm_lm.track.tracker import Tracker, track_of
from tests.recordings.dotted import dotted, dotted_recording
from tests.track.recordings import frame as disc
from tests.track.recordings import recording, there_and_back

FPS, IDLE, TURN, REST = 25.0, 12, 20, 12
STEP_DEG = 1.5


def pictures(turn_deg):
    """Return frames of a gel on which a textured patch turns."""
    import cv2

    rng = np.random.default_rng(3)
    patch = cv2.GaussianBlur(rng.normal(0, 160, (240, 320)), (0, 0), 5)
    y, x = np.mgrid[:240, :320]
    window = np.clip((70 - np.hypot(x - 160, y - 120)) / 12, 0, 1)
    for turn in turn_deg:
        frame = np.full((240, 320), 110.0)
        if turn is not None:
            matrix = cv2.getRotationMatrix2D((160, 120), -turn, 1.0)
            frame += window * 3 * cv2.warpAffine(patch, matrix, (320, 240))
        frame += rng.normal(0, 1.0, frame.shape)
        yield np.repeat(np.clip(frame, 0, 255).astype(np.uint8)[..., None], 3, axis=2)


@pytest.fixture(scope="module")
def frames():
    there = (STEP_DEG * np.arange(TURN + 1)).tolist()
    turn = [0.0] * REST + there + [there[-1]] * REST
    return list(pictures([None] * IDLE + turn + [None] * IDLE))


def fed(frames, times=None):
    tracker = Tracker()
    ended = []
    for k, frame in enumerate(frames):
        ended += tracker.feed(frame, k / FPS if times is None else times[k])
    return tracker.finish(), ended


@pytest.fixture(scope="module")
def track(frames):
    return fed(frames)[0]


def turns(track):
    return [one for one in track.events if one.kind is EventKind.TURN]


def test_a_turn_is_told_with_its_size_and_its_ends(track):
    (turn,) = turns(track)
    assert turn.amount.holds(STEP_DEG * TURN)
    assert abs(turn.amount.mean - STEP_DEG * TURN) < 3
    assert abs(turn.begin - (IDLE + REST)) <= 5
    assert abs(turn.end - (IDLE + REST + TURN)) <= 5


def test_events_come_in_order_from_touch_to_release(track):
    kinds = [one.kind for one in track.events]
    assert kinds[0] is EventKind.TOUCH
    assert kinds[-1] is EventKind.RELEASE
    assert EventKind.STICK in kinds


def test_a_stream_and_a_recording_are_tracked_alike(frames, track):
    again = track_of(((frame, k / FPS) for k, frame in enumerate(frames)))
    assert [(e.kind, e.begin, e.end) for e in again.events] == [
        (e.kind, e.begin, e.end) for e in track.events
    ]


def test_spans_add_up(track):
    middle = IDLE + REST + TURN // 2
    halves = [track.between(0, middle), track.between(middle, len(track) - 1)]
    whole = track.net(Component.TURN).mean
    assert sum(one.net(Component.TURN).mean for one in halves) == pytest.approx(whole, abs=1e-4)
    assert all(len(turns(one)) == 1 for one in halves)
    assert track.between(0, middle / FPS, unit="s").net_twist == halves[0].net_twist


def test_dropped_repeated_and_late_frames_change_no_amount_and_are_noted(frames, track):
    kept = [k for k in range(len(frames)) if k % 7 != 3]
    bad = [frames[k] for k in kept]
    times = [k / FPS for k in kept]
    bad.insert(30, bad[29].copy())
    times.insert(30, (times[29] + times[30]) / 2)
    bad.insert(40, bad[10])
    times.insert(40, times[10])
    found, _ = fed(bad, times)
    assert found.net(Component.TURN).mean == pytest.approx(track.net(Component.TURN).mean, abs=2)
    assert any("repeat" in note for note in found.notes)
    assert any("no later" in note for note in found.notes)


def test_a_gap_in_the_frames_is_noted_once_and_events_keep_their_times(frames, track):
    missed = range(IDLE + REST + 4, IDLE + REST + 16)
    kept = [k for k in range(len(frames)) if k not in missed]
    found, _ = fed([frames[k] for k in kept], [k / FPS for k in kept])
    (turn,), (whole,) = turns(found), turns(track)
    assert turn.amount.mean == pytest.approx(STEP_DEG * TURN, abs=3)
    assert turn.begin_s == pytest.approx(whole.begin_s, abs=0.2)
    assert turn.end_s == pytest.approx(whole.end_s, abs=0.2)
    assert found.notes == (
        f"No frame came for 0.52 s before frame {missed[0]}: what happened meanwhile is not known.",
    )


def test_times_that_go_back_for_good_count_on_and_are_noted_once(frames, track):
    back = IDLE + REST + 6
    times = [k / FPS - (100 if k >= back else 0) for k in range(len(frames))]
    found, _ = fed(frames, times)
    assert found.net(Component.TURN).mean == pytest.approx(track.net(Component.TURN).mean, abs=2)
    assert found.times_s[-1] == pytest.approx(track.times_s[-1])
    assert [one.kind for one in found.events] == [one.kind for one in track.events]
    assert found.notes == (
        "2 frames were no later than those before and left out.",
        f"The frames' times go back before frame {back + 2}; they count on from there.",
    )


def test_frames_without_a_time_are_left_out(frames):
    found, _ = fed(frames[:9], [0.0, 0.04, np.nan, 0.12, np.inf, 0.2, 0.2, 0.28, 0.32])
    assert found.numbers.tolist() == [0, 1, 3, 5, 7, 8]


def test_frames_that_come_twice_or_in_bursts_tell_the_same_motion(frames, track):
    twice = [frames[k // 2] for k in range(2 * len(frames))]
    bursts = [k for k in range(len(frames)) if k % 15 < 10]
    for found in (
        fed(twice, [k / (2 * FPS) for k in range(len(twice))])[0],
        fed([frames[k] for k in bursts], [k / FPS for k in bursts])[0],
    ):
        (turn,), (whole,) = turns(found), turns(track)
        assert turn.amount.mean == pytest.approx(whole.amount.mean, abs=3)
        assert turn.begin_s == pytest.approx(whole.begin_s, abs=0.2)
        assert turn.end_s == pytest.approx(whole.end_s, abs=0.2)


@pytest.mark.parametrize("fps", [10.0, 60.0])
def test_the_rate_of_the_frames_changes_no_total(track, fps):
    seconds = [
        0,
        IDLE / FPS,
        (IDLE + REST) / FPS,
        (IDLE + REST + TURN) / FPS,
        (IDLE + 2 * REST + TURN) / FPS,
    ]
    times = np.arange(0, len(track) / FPS, 1 / fps)
    angles = np.interp(times, seconds, [0, 0, 0, STEP_DEG * TURN, STEP_DEG * TURN])
    is_touched = (times >= seconds[1]) & (times < seconds[-1])
    made = pictures([angle if on else None for angle, on in zip(angles, is_touched, strict=True)])
    found, _ = fed(made, times)
    net = found.net(Component.TURN)
    assert net.holds(STEP_DEG * TURN)
    assert net.mean == pytest.approx(track.net(Component.TURN).mean, abs=3)
    (turn,), (whole,) = turns(found), turns(track)
    assert turn.begin_s == pytest.approx(whole.begin_s, abs=0.2)
    assert turn.end_s == pytest.approx(whole.end_s, abs=0.2)


def test_a_flash_and_a_covered_lens_change_nothing_and_are_noted(frames, track):
    bad = list(frames)
    for place in (4, IDLE + REST + 5, IDLE + REST + 6):
        bad[place] = np.full_like(frames[0], 255 * (place % 2))
    found, _ = fed(bad)
    assert found.net(Component.TURN).mean == pytest.approx(track.net(Component.TURN).mean, abs=2)
    assert [one.kind for one in found.events] == [one.kind for one in track.events]
    assert found.notes == ("3 frames show no picture of the gel and are left out.",)


@pytest.mark.parametrize(("gain", "offset"), [(1.3, 5), (0.7, -3), (1.1, 0)])
@pytest.mark.parametrize("place", [IDLE - 4, IDLE + REST // 2, IDLE + REST + TURN // 2])
def test_an_exposure_that_steps_for_good_is_no_event_and_is_noted(
    frames, track, gain, offset, place
):
    later = [np.clip(np.rint(gain * one + offset), 0, 255) for one in frames[place:]]
    tracker = Tracker()
    for k, frame in enumerate([*frames[:place], *later]):
        tracker.feed(frame.astype(np.uint8), k / FPS)
    found = tracker.finish()
    assert len(found) == len(frames)
    assert found.net(Component.TURN).mean == pytest.approx(track.net(Component.TURN).mean, abs=2)
    assert [one.kind for one in found.events] == [one.kind for one in track.events]
    assert tracker.idle.mean() == pytest.approx(110 * gain + offset, abs=2)
    told = [note for note in found.notes if "exposure" in note]
    assert told == [
        f"The exposure of the whole picture changes once, first in frame {place}, and is followed; "
        f"lock the camera's exposure."
    ]


def test_light_that_ramps_while_the_object_turns_is_followed(frames, track):
    gains = np.interp(np.arange(len(frames)), [IDLE + REST + 4, IDLE + REST + 20], [1, 1.35])
    found, _ = fed(
        [
            np.rint(g * one).clip(0, 255).astype(np.uint8)
            for g, one in zip(gains, frames, strict=True)
        ]
    )
    assert len(found) == len(frames)
    assert found.net(Component.TURN).mean == pytest.approx(track.net(Component.TURN).mean, abs=2)
    assert [one.kind for one in found.events] == [one.kind for one in track.events]


def test_nothing_seen_of_the_gel_is_said():
    rng = np.random.default_rng(0)
    noise = rng.integers(0, 255, (20, 60, 80, 3), dtype=np.uint8)
    track, events = fed(noise)
    assert events == []
    assert not track.is_touched.any()
    assert any("No untouched gel" in note for note in track.notes)


def test_contact_is_not_known_against_a_guessed_gel_with_dots():
    deeper = dotted_recording([20, 22, 25, 28, 31, 34, 37, 40, 40, 40])
    track = track_of(deeper)
    assert not track.is_contact_known
    assert CONTACT_UNKNOWN in track.notes
    assert {event.kind for event in track.events} <= {EventKind.TURN, EventKind.SLIDE}
    assert Exported(track).totals()["touched_s"] is None
    given = track_of(deeper, idle=dotted(0))
    assert given.is_contact_known
    assert given.events[0].kind is EventKind.TOUCH
    begun = track_of(dotted_recording([0] * 8 + [10, 20, 30, 40, 40, 40, 40, 40]))
    assert begun.is_contact_known
    assert begun.events[0].kind is EventKind.TOUCH
    assert abs(begun.events[0].begin - 8) <= 1


@pytest.mark.parametrize("span", [(-1, 5), (0, 10**6), (5, 5), (9, 3)])
def test_frames_outside_the_recording_are_refused_and_never_clamped(track, span):
    said = f"^Frames {span[0]}:{span[1]} were asked for, expected FIRST < LAST within 0:"
    with pytest.raises(UsageError, match=said):
        track.between(*span)


ROW_BYTES = 1024
"""Bytes a frame may cost: a row of 112 in a table that doubles, and its share of the events."""


@pytest.mark.slow
def test_what_is_held_of_a_frame_is_its_row_and_the_events():
    small = [np.ascontiguousarray(one[::2, ::2]) for one in there_and_back().frames]
    tracker, held = Tracker(), {}
    tracemalloc.start()
    twice = np.repeat(small, 2, axis=0)  # a repeated frame costs no alignment
    for number, image in enumerate(islice(cycle(twice), 1501)):
        tracker.feed(image, number / FPS)
        held[number] = tracemalloc.get_traced_memory()[0] if number in (500, 1500) else 0
    tracemalloc.stop()
    assert held[1500] - held[500] < 1000 * ROW_BYTES
    assert len(tracker.finish().events) > 30


def test_a_turn_may_last_for_minutes_and_quicken():
    finder, events, turn = EventFinder(), [], 0.0
    for place in range(6000):
        speed_deg_s = np.interp(place, [50, 3000, 5900, 5901], [3, 4, 40, 0]) * (place > 50)
        turn += speed_deg_s / FPS
        way = np.array([turn, 0, 0, 0])
        doubt = np.eye(4) * 1e-6 * place
        events += finder.push(Moment(place, place, place / FPS, 0.99, True, way, doubt, 50.0))
    events += finder.finish()
    (told,) = (one for one in events if one.kind is EventKind.TURN)
    assert told.amount.mean == pytest.approx(turn, rel=0.15)


def slid_out(far_mm, name="screw_head"):
    """Return an object that is pressed in and slides out of the image to the right."""
    places = np.arange(80)
    depth = np.interp(places, [12, 20], [-0.3, 0.7])
    right = np.interp(places, [25, 62], [0.0, far_mm])
    still = (0.0,) * len(places)
    path = Path(tuple(depth.tolist()), tuple(right.tolist()), still, still)
    scene = Scene(Body(name, texture_um=10.0), path, Motion.RIGHT)
    return simulate([scene], seed=11)[0].clip.frames


def test_a_contact_that_leaves_the_image_neither_turns_nor_comes_back():
    track = track_of((image, k / FPS) for k, image in enumerate(slid_out(12.0)))
    assert track.of(Component.TURN) == ()
    assert abs(track.net(Component.TURN).mean) < 3
    (slide,) = track.of(Component.SLIDE)
    assert slide.twist.right_px > 60
    assert np.diff(track.path_from_start[:, 1]).min() > -1
    assert track.events[-1].kind is EventKind.RELEASE
    assert not track.is_touched[-1]


def test_a_gel_that_is_touched_from_first_to_last_is_tracked_all_the_same():
    angles = np.interp(np.arange(60), [15, 40], [0, 30]).tolist()
    track = track_of(recording(angles, [1.0] * 60))
    (turn,) = track.of(Component.TURN)
    assert turn.amount.mean == pytest.approx(30, abs=5)
    assert turn.begin_s == pytest.approx(15 / FPS, abs=0.2)
    assert turn.end_s == pytest.approx(40 / FPS, abs=0.2)
    assert track.is_touched.all()


def test_such_a_stream_without_a_known_gel_tells_no_motion_that_is_none():
    """What is there at the start is taken for the gel; at rest nothing may be told."""
    still = Clip(np.stack([disc(depth=1.0, seed=k) for k in range(40)]), fps=FPS)
    tracker = Tracker()
    for number, image in enumerate(still.frames):
        tracker.feed(image, number / FPS)
    assert tracker.finish().events == ()


def test_before_the_first_frame_a_track_is_empty_and_doubts_nothing():
    track = Tracker().so_far
    assert len(track) == 0
    assert track.path_deviations.shape == (0, 4)


def test_a_recording_that_is_ended_is_tracked_as_far_as_its_frames_before():
    clip = there_and_back()
    track = track_of(clip, follow=lambda tracker: tracker.time_s >= 1.0)
    before = clip.select([k for k in range(len(clip)) if k / clip.fps <= 1.0])
    assert np.array_equal(track.numbers, before.frame_numbers)
    assert track.notes[-1] == f"Stopped at 1.0 s of {(len(clip) - 1) / clip.fps:.1f} s."
    least = track_of(clip, follow=lambda _: True)
    assert len(least) == 5
    untimed = track_of(replace(clip, fps=None), follow=lambda _: True)
    assert untimed.notes[-1] == f"Stopped at frame 4 of {len(clip) - 1}."
