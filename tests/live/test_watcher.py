"""The sliding window: what is perceived when, and the events of streams whose motions are known."""

import numpy as np
import pytest

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.labels import DIRECTED, Motion
from geotlm_lm.live.events import MotionEvent
from geotlm_lm.live.watcher import SAMPLE_S, WITHOUT_DIRECTION, Watcher, Window, model_reader
from tests.live.stream import FPS, LIFT_S, TOUCH_S, TURN_END_S, TURN_START_S, stream
from tests.track.test_idle_tracker import gel, touched


class Scripted:
    """Says stillness, and remembers what it was asked."""

    def __init__(self):
        self.clips, self.among = [], []

    def __call__(self, clip, among):
        self.clips.append(clip)
        self.among.append(tuple(among))
        return Window(Motion.STILL, 1.0)


def watch(watcher, frames, fps=FPS):
    events = []
    for number, frame in enumerate(frames):
        events += watcher.push(frame, number / fps)
    return events + watcher.finish()


def test_the_model_is_left_out_while_nothing_touches():
    read, frames = Scripted(), gel()
    watcher = Watcher(read)
    watch(watcher, [next(frames) for _ in range(40)])
    assert read.clips == []
    assert watcher.account.frames == 40


def test_a_window_carries_the_idle_gel_and_asks_no_direction_where_untouched_in_part():
    read, frames = Scripted(), gel()
    watch(
        Watcher(read),
        [next(frames) for _ in range(12)] + [touched(next(frames)) for _ in range(18)],
    )
    assert read.among[0] == WITHOUT_DIRECTION
    assert read.among[-1] == tuple(Motion)
    assert not set(WITHOUT_DIRECTION) & set(DIRECTED)
    clip = read.clips[-1]
    assert len(clip) == 4
    assert np.abs(clip.background.astype(float) - next(frames)).mean() < 3


@pytest.mark.parametrize("fps", [10.0, 25.0, 60.0])
def test_samples_are_equally_far_apart_at_any_rate(fps):
    read, frames = Scripted(), gel()
    rest = [next(frames) for _ in range(8)]
    watcher = Watcher(read)
    watch(watcher, rest + [touched(next(frames)) for _ in range(round(2 * fps))], fps)
    apart = np.diff([sample.time_s for sample in watcher._samples])
    assert apart == pytest.approx(np.full(len(apart), apart[0]), abs=1.01 / fps)
    assert SAMPLE_S - 1 / fps <= apart.mean() <= SAMPLE_S + 1 / fps


def test_samples_keep_their_rate_however_long_the_stream_is():
    frames = gel()
    watcher = Watcher(Scripted())
    watch(watcher, [next(frames) for _ in range(200)])
    apart = np.diff([sample.time_s for sample in watcher._samples])
    assert len(apart) > 60
    assert apart == pytest.approx(np.full(len(apart), SAMPLE_S))  # every third frame of 25 a second


def test_the_clip_of_a_motion_knows_how_long_it_took():
    frames = gel()
    watcher = Watcher(Scripted())
    watch(watcher, [next(frames) for _ in range(60)])
    event = MotionEvent("end", Motion.LEFT, 1.0, 2.0, 0.0, -9.0, 0.0, 0.9)
    clip = watcher.clip_of(event)
    assert (len(clip) - 1) / clip.fps == pytest.approx(0.96)  # nine samples, 0.12 s apart
    assert clip.frame_numbers == tuple(range(len(clip)))


def test_a_press_that_is_named_late_began_where_the_imprint_began_to_grow():
    frames, began, named = gel(), 20, 38
    watcher = Watcher(lambda clip, among: Window(kinds[0], 1.0))
    kinds, events = [Motion.STILL], []
    for number in range(60):
        frame = next(frames)
        deep = min(max(number - began, 0) / 25, 1.0)
        if deep > 0:
            frame[40:80, 60:70] += np.uint8(60 * deep)
        if number >= named:
            kinds = [Motion.PRESS]
        events += watcher.push(frame, number / FPS)
    assert events[0].motion is Motion.PRESS
    assert events[0].start_s == pytest.approx(began / FPS, abs=2 * SAMPLE_S)


STREAMS = {
    "a turn of the key to the left": ("key", {"turn_deg": -25.0}, Motion.COUNTERCLOCKWISE),
    "a turn of the nut to the right": ("hex_nut", {"turn_deg": 30.0}, Motion.CLOCKWISE),
    "a slide of the cap": ("bottle_cap", {"turn_deg": 0.0, "slide_mm": 2.0}, Motion.RIGHT),
}
TRUE_PX = 2.0 / (20.3 / 224)
"""How far the cap slides, in pixels of our square."""


@pytest.mark.parametrize("name", STREAMS)
def test_the_events_of_a_simulated_stream_are_told_in_order_time_and_size(answerer, name):
    body, path, motion = STREAMS[name]
    watcher = Watcher(model_reader(answerer))
    events = watch(watcher, stream(body, **path).frames)
    over = [event for event in events if event.phase == "end"]
    assert [event.motion for event in over] == [Motion.PRESS, motion, Motion.RELEASE]
    assert len(events) == 6
    pressed, moved, released = over
    # A window's readings are a sample apart, and a press is felt before it is seen in full.
    assert pressed.start_s == pytest.approx(TOUCH_S, abs=1.5 * SAMPLE_S)
    assert moved.start_s == pytest.approx(TURN_START_S, abs=1.5 * SAMPLE_S)
    assert moved.end_s == pytest.approx(TURN_END_S, abs=1.5 * SAMPLE_S)
    assert released.end_s == pytest.approx(LIFT_S, abs=1.5 * SAMPLE_S)
    if motion is Motion.CLOCKWISE:
        assert moved.rotation_deg == pytest.approx(30.0, rel=0.2)
    if motion is Motion.RIGHT:
        assert moved.slide_x_px == pytest.approx(TRUE_PX, rel=0.15)
        assert abs(moved.slide_y_px) < 0.1 * TRUE_PX
        encoded = answerer.encode(watcher.clip_of(moved))
        assert answerer.ask(encoded, "Which way is it sliding?").direction is Motion.RIGHT
        speed = answerer.ask(encoded, "How fast?").amount
        assert speed.unit == "px/s"
        assert speed.value == pytest.approx(TRUE_PX / (TURN_END_S - TURN_START_S), rel=0.25)


def test_a_flash_ends_no_stream():
    """What no camera shows is refused by the model; the stream reads it as nothing and goes on."""

    class Refusing:
        def encode(self, clip):
            raise UnreadableClip(f"{clip.name}: is overexposed")

    window = model_reader(Refusing())(Clip(np.zeros((4, 16, 16, 3), np.uint8)), tuple(Motion))
    assert (window.motion, window.probability, window.encoded) == (Motion.NONE, 0.0, None)
