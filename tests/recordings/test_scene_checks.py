"""A camera that moves, blank frames, and pictures of no gel move no object."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.twist import Component
from geotlm_lm.doctor.examine import examine
from geotlm_lm.recordings.scene_checks import DOUBLED, MOVING, SHARP, scene_of
from geotlm_lm.simulation.touch import Touch, simulate_touch
from geotlm_lm.track.events import MOVING as MOVING_EVENTS
from geotlm_lm.track.tracker import Tracker, track_of

IDLE, HELD, FPS = 12, 40, 25.0
ROWS, COLUMNS = 240, 320


def noisy(frames, seed=0):
    rng = np.random.default_rng(seed)
    frames = [frame + rng.normal(0, 0.8, frame.shape) for frame in frames]
    return Clip(np.clip(np.rint(frames), 0, 255).astype(np.uint8), fps=FPS)


def shifted(frame, right_px, down_px, border=cv2.BORDER_REPLICATE):
    matrix = np.float64([[1, 0, right_px], [0, 1, down_px]])
    return cv2.warpAffine(frame, matrix, (COLUMNS, ROWS), borderMode=border)


@pytest.fixture(scope="module")
def held():
    """Return frames of a simulated touch that is held: nothing moves but to press and to lift."""
    touch = simulate_touch(Touch("key", seed=1), preset="draft", with_drift=False).clip
    shown = [touch.background] * IDLE + [touch.frames[0]] * HELD + [touch.background] * IDLE
    return [cv2.resize(frame, (COLUMNS, ROWS), interpolation=cv2.INTER_AREA) for frame in shown]


def scene(seed, kind):
    """Return a picture of a room, or of a printed page, twice as large as a frame."""
    rng = np.random.default_rng(seed)
    size = (2 * ROWS, 2 * COLUMNS)
    if kind == "print":
        speckle = cv2.GaussianBlur(rng.normal(0, 1, size), (0, 0), 4)
        return np.where(speckle > 0, 210, 90)[..., None] * np.ones(3)
    picture = np.full((*size, 3), 128.0)
    for _ in range(60):
        middle, radius = rng.integers(0, size[1], 2).tolist(), int(rng.integers(8, 80))
        colour = rng.integers(0, 255, 3).tolist()
        cv2.circle(picture, middle, radius, colour, -1)
    return picture


def panned(picture, step_px):
    places = [round(step_px * max(k - IDLE, 0)) for k in range(50)]
    return noisy([picture[100 : 100 + ROWS, at : at + COLUMNS] for at in places])


@pytest.mark.parametrize(("right_px", "down_px"), [(7, 0), (0, -5), (-9, 6)])
@pytest.mark.parametrize("border", [cv2.BORDER_REPLICATE, cv2.BORDER_CONSTANT])
@pytest.mark.parametrize("last", [IDLE + 25, 999])
def test_a_jump_of_the_whole_picture_moves_no_object(held, right_px, down_px, border, last):
    moved = [
        shifted(frame, right_px, down_px, border) if IDLE + 10 <= place <= last else frame
        for place, frame in enumerate(held)
    ]
    track = track_of(noisy(moved))
    assert not [event for event in track.events if event.kind in MOVING_EVENTS]
    far, last = round(np.hypot(right_px, down_px)), min(last, len(held) - 1)
    assert track.notes == (
        f"The whole picture moves by {far} px in frames {IDLE + 10} to {last}, lights and rim with "
        f"it: the camera moved, not the object.",
    )


def test_a_stream_is_steadied_as_a_recording_is(held):
    clip = noisy([shifted(f, 7, 0) if 20 <= k <= 30 else f for k, f in enumerate(held)])
    tracker = Tracker()
    for number, frame in enumerate(clip.frames):
        tracker.feed(frame, number / FPS)
    track = tracker.finish()
    assert track.scene.jumps == track_of(clip).scene.jumps
    assert not [event for event in track.events if event.kind in MOVING_EVENTS]
    findings = {finding.subject: finding for finding in examine(clip)}
    assert findings["camera"].verdict == "fault"
    assert "frames 20 to 30" in findings["camera"].measured
    assert findings["gel"].verdict == "fine"


def test_markers_that_the_gel_takes_along_are_no_jump():
    y, x = np.mgrid[:ROWS, :COLUMNS]
    shading = 90 + 60 * np.exp(-((x - 160) ** 2 + (y - 110) ** 2) / 15000)

    def gel(right_px):
        dots = np.hypot((x - right_px) % 32 - 16, y % 32 - 16) < 4
        return np.where(dots, 0.4, 1.0)[..., None] * shading[..., None] * [0.8, 1, 0.9]

    steps = [0] * IDLE + [3] * 10 + [6] * 10
    assert scene_of(noisy([gel(px) for px in steps])).notes == ()


@pytest.mark.parametrize("level", [0, 255])
@pytest.mark.parametrize("at_end", [False, True])
def test_blank_frames_at_an_end_touch_and_release_nothing(held, level, at_end):
    blank = [np.full_like(held[0], level)] * 8
    clip = noisy(held + blank if at_end else blank + held)
    plain = track_of(noisy(held))
    timed = zip(clip.frames, np.arange(len(clip)) / FPS, strict=True)
    for track in (track_of(clip), track_of(timed)):
        assert [event.kind for event in track.events] == [event.kind for event in plain.events]
        assert track.notes == ("8 frames show no picture of the gel and are left out.",)


@pytest.mark.parametrize(
    ("kind", "step_px", "suspicion"),
    [("room", 0, SHARP), ("room", 3, SHARP), ("print", 3, MOVING)],
)
def test_what_is_no_gel_is_suspected_and_nothing_is_sure(kind, step_px, suspicion):
    clip = panned(scene(1, kind), step_px)
    if kind == "print":  # fainter than a room, so that only its motion tells
        clip = replace(clip, frames=(128 + (clip.frames.astype(float) - 128) / 5).astype(np.uint8))
    track = track_of(clip)
    assert track.notes[0] == suspicion
    assert max((event.probability for event in track.events), default=0) <= 0.5
    assert np.abs(track.contact - 0.5).max() < 0.01
    assert [f.subject for f in examine(clip) if f.measured == suspicion] == ["gel"]


def test_two_views_in_one_picture_are_suspected(held):
    halves = [np.hstack([frame[:, 80:240], frame[:, 80:240][:, ::-1]]) for frame in held]
    rough = cv2.GaussianBlur(np.random.default_rng(2).normal(0, 40, (ROWS, 160)), (0, 0), 4)
    dirt = np.hstack([rough, rough[:, ::-1]])[..., None]
    assert track_of(noisy([frame + dirt for frame in halves])).scene.suspicion == DOUBLED


def test_a_gel_is_not_suspected(held):
    track = track_of(noisy(held))
    assert track.scene.notes == ()
    assert track.net(Component.TURN).mean == pytest.approx(0, abs=1)
