"""One simulated recording as an array, a bag, a data set, a video and a camera: one track."""

from contextlib import suppress

import cv2
import numpy as np
import pytest

from geotlm_lm.core.errors import MissingDependency
from geotlm_lm.core.twist import Component
from geotlm_lm.recordings.read import read_clip
from geotlm_lm.recordings.streams import open_source
from geotlm_lm.track.tracker import track_of
from tests.recordings.fake_camera import FakeCamera
from tests.track.recordings import there_and_back

CLIP = there_and_back()

NEAR_DEG, NEAR_S = 1.0, 0.13
"""How far a track may differ: by what a codec changes, and by three frames."""

CAMERA_S = 0.4
"""By the machine's clock, which other work may hold up."""


def array(folder):
    np.savez_compressed(folder / "run.npz", frames=CLIP.frames, fps=CLIP.fps)
    return track_of(read_clip(folder / "run.npz"))


def bag(folder):
    bags = pytest.importorskip("tests.recordings.bag_files", reason="needs the extra ros")
    return track_of(read_clip(bags.raw_bag(folder / "run", CLIP.frames)))


def data_set(folder):
    pytest.importorskip("pyarrow", reason="needs pyarrow, of the extra lerobot")
    pytest.importorskip("av", reason="needs av, of the extra lerobot")
    from geotlm_lm.data_sets.lerobot import episode_clip, read_data_set
    from tests.data_sets.lerobot_files import CAMERA, write_data_set

    found = read_data_set(write_data_set(folder / "set", [CLIP, CLIP]))
    return track_of(episode_clip(found, found.episode(1), CAMERA))


def video(folder):
    pytest.importorskip("av", reason="needs av, of the extra lerobot, to write a video")
    from tests.data_sets.lerobot_files import write_video

    write_video(folder / "run.mp4", CLIP.frames)
    return track_of(read_clip(folder / "run.mp4"))


def camera(_):
    frames = []
    with pytest.MonkeyPatch.context() as patch:
        fake = FakeCamera(CLIP.frames[..., ::-1], CLIP.fps, pace=CLIP.fps)
        patch.setattr(cv2, "VideoCapture", lambda *_: fake)
        with suppress(MissingDependency):  # said when it stops giving frames
            for one in open_source("0"):
                frames.append((one.image, one.time_s))
    return track_of(frames)


def told(track):
    """Return what happened: kinds of events, when they began, and how far it turned."""
    turns = [one.amount.mean for one in track.events if one.kind.value == "turn"]
    return (
        [one.kind for one in track.events],
        [one.begin_s for one in track.events],
        [*turns, track.net(Component.TURN).mean],
    )


@pytest.fixture(scope="module")
def expected():
    return told(track_of(CLIP))


@pytest.mark.parametrize("source", [array, bag, data_set, video, camera])
def test_a_recording_gives_the_same_track_from_every_source(source, expected, tmp_path):
    kinds, begins, turns = told(source(tmp_path))
    assert kinds == expected[0]
    near_s = CAMERA_S if source is camera else NEAR_S
    assert begins == pytest.approx(expected[1], abs=near_s)
    assert turns == pytest.approx(expected[2], abs=NEAR_DEG)
