"""Where frames come from; what is late is dropped and counted, what does not open is told."""

import threading

import cv2
import numpy as np
import pytest

from geotlm_lm.core.errors import MissingDependency, UnreadableClip
from geotlm_lm.recordings import policy, streams
from geotlm_lm.recordings.policy import Source, SourceFrame
from geotlm_lm.recordings.streams import LatestFrames, Recording, StreamFrame, open_source
from tests.recordings.fake_camera import FakeCamera
from tests.recordings.test_read import levels, write_video


@pytest.fixture
def film(tmp_path):
    """A lossless video of 9 frames at 20 per second, frame k of grey level 10 k."""
    return write_video(tmp_path / "film.avi", levels(9), 20)


def test_a_recording_gives_every_frame_with_its_time(film):
    source = open_source(str(film))
    frames = list(source)
    assert source.fps == 20.0
    assert [frame.time_s for frame in frames] == pytest.approx([0.05 * k for k in range(9)])
    assert [int(frame.image.mean()) for frame in frames] == [10 * k for k in range(9)]
    assert source.dropped == 0
    given = open_source(str(film), fps=10)
    assert (given.fps, given.is_rate_assumed) == (10, False)
    assert [frame.time_s for frame in given][-1] == pytest.approx(0.8)
    (film.parent / "broken.avi").write_bytes(b"RIFF no frames")
    for name, sentence in {"gone.avi": "no such file", "broken.avi": "no frame of it can"}.items():
        with pytest.raises(UnreadableClip, match=f"{name}: {sentence}"):
            open_source(str(film.parent / name))


def test_the_times_of_an_array_read_at_a_stride_are_those_of_the_recording(tmp_path, monkeypatch):
    frames = np.random.default_rng(0).integers(0, 255, (20, 24, 32, 3)).astype(np.uint8)
    np.savez(tmp_path / "clip.npz", frames=frames, fps=40.0)
    monkeypatch.setattr(policy, "KEPT_BYTES", 6 * frames[0].nbytes)
    source = open_source(str(tmp_path / "clip.npz"))
    assert [one.time_s for one in source] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    assert source.fps == 10


def test_a_recording_at_its_rate_gives_the_same_frames_to_a_reader_in_time(film):
    source = open_source(str(film), at_its_rate=True)
    assert [int(frame.image.mean()) for frame in source] == [10 * k for k in range(9)]
    assert source.dropped == 0


def test_the_oldest_frames_are_dropped_and_counted_when_the_reader_is_late():
    buffer = LatestFrames(capacity=4)
    for number in range(10):
        buffer.put(StreamFrame(np.zeros((8, 8, 3), np.uint8), float(number), number))
    buffer.close()
    assert [frame.time_s for frame in buffer] == [6.0, 7.0, 8.0, 9.0]
    assert buffer.dropped == 6


@pytest.mark.parametrize("name", ["97", "/dev/video97"])
def test_a_camera_that_does_not_open_is_told_with_what_to_do(name):
    with pytest.raises(MissingDependency) as caught:
        open_source(name)
    assert str(caught.value).startswith(f"Camera {name} does not open (")
    assert str(caught.value).endswith(
        "); plug the sensor in, close other programs that use it, see that your user is in the "
        "group 'video', or give a recording's path."
    )


def test_frames_of_a_video_have_their_own_times_and_these_its_rate(film, monkeypatch):
    """A video whose header takes its time base for its rate, and whose frames slow down."""
    image, stamps_ms = np.zeros((24, 32, 3), np.uint8), (500, 540, 580, 620, 660, 860, 1060)
    monkeypatch.setattr(
        streams,
        "streamed_source",
        lambda *_: Source(
            "film",
            lambda _: (SourceFrame(lambda: image, float(stamp)) for stamp in stamps_ms),
            header_fps=1000.0,
        ),
    )
    monkeypatch.setattr(policy, "RATED_FRAMES", 5)
    source = open_source(str(film))
    assert source.fps == pytest.approx(25)
    assert source.notes == (
        "The frame rate 25 was taken from the frames' times; the header says 1000.",
    )
    times = [frame.time_s for frame in source]
    assert times == pytest.approx([0, 0.04, 0.08, 0.12, 0.16, 0.36, 0.56])
    given = open_source(str(film), fps=10)
    assert (given.fps, given.notes) == (10, ())
    assert [frame.time_s for frame in given][-1] == pytest.approx(0.6)


@pytest.fixture
def camera(monkeypatch):
    """Return what makes the camera 0 one of some frames."""

    def plug(count, error=None):
        frames = np.full((count, 24, 32, 3), (10, 20, 30), np.uint8)
        fake = FakeCamera(frames, 30.0, pace=100, error=error)
        monkeypatch.setattr(cv2, "VideoCapture", lambda *source: fake)
        return open_source("0")

    return plug


@pytest.mark.parametrize(
    ("error", "reason"), [(None, "s"), (cv2.error("the driver is gone"), r".*the driver is gone.*")]
)
def test_a_camera_gives_rgb_frames_until_it_stops(camera, monkeypatch, error, reason):
    monkeypatch.setattr(LatestFrames, "__iter__", until_closed(LatestFrames.__iter__))
    stream = camera(3, error)
    assert stream.fps == 30.0
    frames = iter(stream)
    assert [next(frames).image[0, 0].tolist() for _ in range(3)] == [[30, 20, 10]] * 3
    with pytest.raises(MissingDependency, match=rf"^Camera 0 stopped giving .*{reason}; check"):
        next(frames)


def test_a_recording_that_fails_while_it_plays_does_not_leave_the_reader_waiting(film, monkeypatch):
    def fail(self):
        raise UnreadableClip("film.avi: is gone.")
        yield

    monkeypatch.setattr(Recording, "__iter__", fail)
    monkeypatch.setattr(LatestFrames, "__iter__", until_closed(LatestFrames.__iter__))
    with pytest.raises(UnreadableClip, match="film.avi: is gone"):
        list(open_source(str(film), at_its_rate=True))


@pytest.mark.parametrize("source", ["a camera", "a recording"])
def test_a_reader_that_stops_ends_the_thread_that_brings_the_frames(film, camera, source):
    before = threading.active_count()
    stream = camera(1000) if source == "a camera" else open_source(str(film), at_its_rate=True)
    frames = iter(stream)
    next(frames)
    assert threading.active_count() == before + 1
    frames.close()
    assert threading.active_count() == before


def until_closed(read):
    """Return `read`, which then fails where nothing closes the buffer within two seconds."""

    def reading(self):
        timer = threading.Timer(2, self.close, [TimeoutError("the buffer stayed open")])
        timer.daemon = True
        timer.start()
        return read(self)

    return reading
