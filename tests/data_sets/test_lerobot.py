"""Data sets in LeRobot's layout, read where they lie: what is expected is what was written."""

import json

import numpy as np
import pytest

from geotlm_lm.core import errors
from geotlm_lm.core.errors import MissingDependency, UnreadableClip, UsageError
from geotlm_lm.data_sets.lerobot import episode_clip, is_data_set, read_data_set
from geotlm_lm.recordings import policy
from tests.data_sets.lerobot_files import CAMERA, FPS, OTHER, turned, write_data_set

pytest.importorskip("pyarrow", reason="needs pyarrow, of the extra lerobot")
pytest.importorskip("av", reason="needs av, of the extra lerobot")

CLIPS = [turned(20), turned(-15, 28), turned(10, 26)]

CODEC_GREY = 3.0
"""Largest mean difference that H.264 makes of a frame: 1.3 at most where this was written."""


@pytest.fixture(scope="module")
def root(tmp_path_factory):
    return write_data_set(tmp_path_factory.mktemp("sets") / "videos", CLIPS)


@pytest.mark.parametrize("number", range(3))
def test_an_episode_shows_what_was_recorded_wherever_it_lies_in_its_video(root, number):
    data_set = read_data_set(root)
    clip = episode_clip(data_set, data_set.episode(number), CAMERA)
    wanted = CLIPS[number].frames.astype(float)
    assert (clip.frames.shape, clip.fps) == (wanted.shape, FPS)
    assert np.abs(clip.frames - wanted).mean(axis=(1, 2, 3)).max() < CODEC_GREY


def test_another_camera_shows_something_else(root):
    data_set = read_data_set(root)
    assert data_set.cameras == (OTHER, CAMERA)
    clip = episode_clip(data_set, data_set.episode(1), OTHER)
    assert np.abs(clip.frames[:, ::-1] - CLIPS[1].frames.astype(float)).mean() < CODEC_GREY


def test_pictures_in_the_tables_are_read_as_they_are(tmp_path):
    data_set = read_data_set(write_data_set(tmp_path / "s", CLIPS[:2], as_images=True))
    clip = episode_clip(data_set, data_set.episode(1), CAMERA)
    assert np.array_equal(clip.frames, CLIPS[1].frames)


def test_what_does_not_fit_into_memory_is_read_at_a_stride(root, monkeypatch):
    monkeypatch.setattr(policy, "KEPT_BYTES", 10 * CLIPS[0].frames[0].nbytes)
    data_set = read_data_set(root)
    clip = episode_clip(data_set, data_set.episode(0), CAMERA)
    assert clip.frame_numbers == tuple(range(0, 24, 3))
    assert "Of 24 frames one in 3 was read" in clip.notes[0]


def test_a_camera_or_an_episode_that_is_not_there_is_refused(root):
    data_set = read_data_set(root)
    with pytest.raises(UsageError, match=f"has no camera wrist; choose one of {OTHER}, {CAMERA}"):
        data_set.require_camera("wrist")
    with pytest.raises(UsageError, match="has no episode 3, expected 0 to 2"):
        data_set.episode(3)


def changed(root, **values):
    path = root / "meta/info.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | values))


def test_what_is_no_data_set_of_this_version_is_refused(tmp_path):
    with pytest.raises(UnreadableClip, match="is no LeRobot data set, expected a readable meta"):
        read_data_set(tmp_path)
    assert not is_data_set(tmp_path)
    root = write_data_set(tmp_path / "s", CLIPS[:1])
    assert is_data_set(root)
    changed(root, codebase_version="v2.1")
    with pytest.raises(UnreadableClip, match=r"of version 'v2\.1', expected v3\.x"):
        read_data_set(root)
    changed(root, codebase_version="v3.0", total_episodes=4)
    with pytest.raises(UnreadableClip, match="1 episodes were found, expected 4 counted from 0"):
        read_data_set(root)
    (root / "meta/episodes/chunk-000/file-000.parquet").write_bytes(b"nothing")
    with pytest.raises(UnreadableClip, match="cannot be read"):
        read_data_set(root)


def test_a_video_that_is_cut_off_or_missing_is_refused(tmp_path):
    root = write_data_set(tmp_path / "s", CLIPS[:1])
    data_set, video = read_data_set(root), root / f"videos/{CAMERA}/chunk-000/file-000.mp4"
    video.write_bytes(video.read_bytes()[:2000])
    with pytest.raises(UnreadableClip, match="cannot be decoded"):
        episode_clip(data_set, data_set.episode(0), CAMERA)
    video.unlink()
    with pytest.raises(UnreadableClip, match="cannot be decoded"):
        episode_clip(data_set, data_set.episode(0), CAMERA)


def test_a_video_shorter_than_its_rows_is_refused(root, tmp_path):
    longer = write_data_set(tmp_path / "s", [CLIPS[1]], in_a_file=1)
    shorter = root / f"videos/{CAMERA}/chunk-000/file-001.mp4"  # 26 frames
    (longer / f"videos/{CAMERA}/chunk-000/file-000.mp4").write_bytes(shorter.read_bytes())
    data_set = read_data_set(longer)
    with pytest.raises(UnreadableClip, match=r"has no picture within 20 ms of 1\.040 s"):
        episode_clip(data_set, data_set.episode(0), CAMERA)


@pytest.mark.parametrize("package", ["pyarrow", "av"])
def test_a_missing_package_is_told_with_its_extra(root, monkeypatch, package):
    find = errors.find_spec
    monkeypatch.setattr(errors, "find_spec", lambda name: None if name == package else find(name))
    with pytest.raises(MissingDependency, match=rf"with {package}, .*'geotlm-lm\[lerobot\]'"):
        read_data_set(root)
