"""A stream that goes on and on, and contacts that leave the image or never end."""

import tracemalloc
from itertools import cycle, islice

import numpy as np
import pytest

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import Component
from geotlm_lm.simulation.scene import Body, Path, Scene
from geotlm_lm.simulation.simulate import simulate
from geotlm_lm.track.events import EventFinder, EventKind, Moment
from geotlm_lm.track.tracker import Tracker, track_of
from tests.track.recordings import frame, recording, there_and_back

FPS = 25.0
ROW_BYTES = 1024
"""Bytes a frame may cost: a row of 112 in a table that doubles, and its share of the events."""


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
    still = Clip(np.stack([frame(depth=1.0, seed=k) for k in range(40)]), fps=FPS)
    tracker = Tracker()
    for number, image in enumerate(still.frames):
        tracker.feed(image, number / FPS)
    assert tracker.finish().events == ()
