"""Bags of ROS 2 come back as any other recording, and what is no such bag is told in a sentence."""

import shutil
import sys

import cv2
import numpy as np
import pytest

from geotlm_lm.core.errors import MissingDependency, UnreadableClip
from geotlm_lm.recordings import limits
from geotlm_lm.recordings.bags import BAG_SUFFIXES
from geotlm_lm.recordings.every_frame import each_frame
from geotlm_lm.recordings.listing import clips_in
from geotlm_lm.recordings.read import read_clip
from geotlm_lm.recordings.streams import open_source
from tests.recordings.bag_files import (
    MCAP,
    PER_FILE,
    PER_MESSAGE,
    SQLITE,
    STEP_NS,
    TOPIC,
    even_ns,
    packed,
    raw,
    raw_bag,
    text,
    write_bag,
)
from tests.recordings.test_read import colourful

FRAMES = colourful(count=9)
GREY = np.stack(
    [cv2.cvtColor(cv2.cvtColor(one, cv2.COLOR_RGB2GRAY), cv2.COLOR_GRAY2RGB) for one in FRAMES]
)


def stamped(stamps_ns, frames=FRAMES):
    return [raw(*one) for one in zip(frames, stamps_ns, strict=True)]


@pytest.fixture
def bag(tmp_path):
    return raw_bag(tmp_path / "run", FRAMES)


@pytest.mark.parametrize("storage", [MCAP, SQLITE])
@pytest.mark.parametrize("encoding", ["rgb8", "bgr8", "8UC3", "mono8"])
def test_its_images_are_frames_in_rgb(tmp_path, encoding, storage):
    clip = read_clip(raw_bag(tmp_path / "run", FRAMES, encoding, storage=storage), topic=TOPIC)
    assert np.array_equal(clip.frames, GREY if encoding == "mono8" else FRAMES)
    assert clip.fps == pytest.approx(25)
    assert clip.times_s == ()
    assert any("8UC3 does not tell" in note for note in clip.notes) == (encoding == "8UC3")


@pytest.mark.parametrize(("storage", "ending"), [(MCAP, ".mcap"), (SQLITE, ".db3")])
def test_the_file_in_its_folder_is_read_alone(tmp_path, storage, ending):
    folder = raw_bag(tmp_path / "run", FRAMES, storage=storage)
    [path] = folder.glob(f"*{ending}")
    alone = shutil.move(path, tmp_path / f"alone{ending}")
    assert np.array_equal(read_clip(alone).frames, FRAMES)


@pytest.mark.parametrize("mode", [PER_FILE, PER_MESSAGE])
def test_a_compressed_one_is_read(tmp_path, mode):
    folder = raw_bag(tmp_path / "run", FRAMES, storage=SQLITE, compression=mode)
    assert np.array_equal(read_clip(folder).frames, FRAMES)


def test_padding_behind_the_rows_is_left_out(tmp_path):
    messages = [
        raw(frame, at, "bgr8", padding=5) for frame, at in zip(FRAMES, even_ns(9), strict=True)
    ]
    assert np.array_equal(read_clip(write_bag(tmp_path / "run", {TOPIC: messages})).frames, FRAMES)


@pytest.mark.parametrize(("ending", "most"), [("png", 0), ("jpg", 40)])
def test_compressed_images_are_decoded(tmp_path, ending, most):
    smooth = np.stack([cv2.GaussianBlur(one, (0, 0), 3) for one in FRAMES])
    messages = [packed(frame, at, ending) for frame, at in zip(smooth, even_ns(9), strict=True)]
    clip = read_clip(write_bag(tmp_path / "run", {"/gel/compressed": messages}))
    assert np.abs(clip.frames.astype(int) - smooth).max() <= most


def test_times_are_those_of_the_headers(tmp_path):
    stamps_ns = even_ns(9) + np.array([0, 0, 0, 0, 5, 5, 5, 5, 5]) * STEP_NS
    clip = read_clip(write_bag(tmp_path / "run", {TOPIC: stamped(stamps_ns)}))
    steps = [0, 1, 2, 3, 9, 10, 11, 12, 13]
    assert clip.times_s == pytest.approx([0.04 * one for one in steps], abs=1e-6)


@pytest.mark.parametrize(
    ("stamps_ns", "found"),
    [([0] * 9, "are missing"), (even_ns(9)[[0, 1, 2, 2, 3, 4, 5, 6, 7]], "do not rise")],
)
def test_without_them_those_of_the_recorder(tmp_path, stamps_ns, found):
    received_ns = even_ns(9) + np.array([0, 0, 0, 0, 0, 3, 3, 3, 3]) * STEP_NS
    messages = {TOPIC: stamped(stamps_ns)}
    clip = read_clip(write_bag(tmp_path / "run", messages, received_ns=received_ns))
    assert clip.times_s[4:6] == pytest.approx([0.16, 0.32], abs=1e-6)
    assert clip.notes[0].startswith(f"Stamps of the images {found}: ")


def test_a_long_one_is_read_at_a_stride_and_followed_frame_by_frame(tmp_path, monkeypatch):
    monkeypatch.setattr(limits, "KEPT_BYTES", 4 * FRAMES[0].nbytes)
    clip = read_clip(raw_bag(tmp_path / "run", FRAMES))
    assert clip.frame_numbers == (0, 4, 8)
    assert np.array_equal(clip.frames, FRAMES[::4])
    assert clip.notes[-1].startswith("Of 9 frames one in 4 was read")
    numbers, frames = zip(*each_frame(clip), strict=True)
    assert numbers == tuple(range(9))
    assert np.array_equal(np.stack(frames), FRAMES)


def test_it_is_a_stream(bag):
    source = open_source(str(bag), topic=TOPIC)
    frames = list(source)
    assert source.fps == pytest.approx(25)
    assert [one.time_s for one in frames] == pytest.approx([0.04 * k for k in range(9)], abs=1e-6)
    assert np.array_equal(np.stack([one.image for one in frames]), FRAMES)


def test_a_given_rate_holds_for_a_stream(bag):
    assert [one.time_s for one in open_source(str(bag), fps=10)][-1] == pytest.approx(0.8)


def test_it_is_one_recording_of_a_folder(tmp_path):
    bag = raw_bag(tmp_path / "run", FRAMES)
    np.save(tmp_path / "other.npy", FRAMES)
    assert clips_in(tmp_path) == [tmp_path / "other.npy", bag]


def test_other_recordings_have_no_topic(tmp_path):
    np.save(tmp_path / "clip.npy", FRAMES)
    clip = read_clip(tmp_path / "clip.npy", topic=TOPIC)
    assert clip.notes[-1] == f"The topic {TOPIC} is not used: only bags have topics."


def refusal(path, **options):
    with pytest.raises(UnreadableClip) as error:
        read_clip(path, **options)
    return str(error.value)


def test_of_several_topics_one_has_to_be_given(tmp_path):
    messages = stamped(even_ns(9))
    path = write_bag(
        tmp_path / "run",
        {"/left": messages, "/right": messages[:4], "/say": [text()]},
        received_ns=None,
    )
    assert refusal(path) == (
        f"{path}: holds images on 2 topics, /left (9 images), /right (4 images), expected one; "
        f"give it by --topic."
    )
    assert len(read_clip(path, topic="/right")) == 4


def test_a_topic_that_is_not_there_is_told(bag):
    assert refusal(bag, topic="/left") == (
        f"{bag}: holds no images on the topic /left, expected {TOPIC} (9 images); give one by "
        f"--topic."
    )


def test_one_without_images_says_what_it_holds(tmp_path):
    path = write_bag(tmp_path / "run", {"/say": [text()]})
    assert refusal(path) == (
        f"{path}: holds no images but /say, expected a topic of sensor_msgs/msg/Image or "
        f"sensor_msgs/msg/CompressedImage; record the sensor's."
    )


def test_an_encoding_that_is_not_read_is_told(tmp_path):
    path = write_bag(tmp_path / "run", {TOPIC: [raw(FRAMES[0], 1, "yuv422")]})
    assert refusal(path) == (
        f"{path}: image 0 has the encoding yuv422, expected rgb8, bgr8, 8UC3, mono8, 8UC1; publish "
        f"the camera's images in one of these."
    )


def test_images_of_changing_sizes_are_refused(tmp_path):
    messages = [*stamped(even_ns(2), FRAMES[:2]), raw(FRAMES[2][:-1], even_ns(3)[2])]
    path = write_bag(tmp_path / "run", {TOPIC: messages})
    rows, columns = FRAMES.shape[1:3]
    sentence = (
        f"{path}: image 2 is {columns} x {rows - 1} pixels after {columns} x {rows}, expected one "
        f"size; record it at one size."
    )
    assert refusal(path) == sentence
    with pytest.raises(UnreadableClip) as error:
        list(open_source(str(path)))
    assert str(error.value) == sentence


def test_rows_that_are_too_short_are_refused(tmp_path):
    message = raw(FRAMES[0], 1)
    message.data = message.data[:-3]
    path = write_bag(tmp_path / "run", {TOPIC: [message]})
    assert "expected" in refusal(path)
    assert refusal(path).endswith("; record it again.")


def test_a_picture_that_is_cut_off_is_refused(tmp_path):
    message = packed(FRAMES[0], 1)
    message.data = message.data[:-20]
    path = write_bag(tmp_path / "run", {TOPIC: [message]})
    assert refusal(path) == (
        f"{path}: image 0 (png) is cut off or is no picture, expected jpeg or png; record it again."
    )


@pytest.mark.parametrize("storage", [MCAP, SQLITE])
@pytest.mark.parametrize("share", [0.001, 0.3, 0.7])
def test_one_that_is_cut_off_is_refused_in_a_sentence(tmp_path, storage, share):
    folder = raw_bag(tmp_path / "run", colourful(count=40), storage=storage)
    [path] = (one for one in folder.iterdir() if one.suffix in BAG_SUFFIXES)
    path.write_bytes(path.read_bytes()[: max(int(share * path.stat().st_size), 1)])
    assert refusal(folder) == (
        f"{folder}: is cut off or is no bag of ROS 2, expected what `ros2 bag record` writes; copy "
        f"it again, or repair it by `mcap recover`."
    )


@pytest.mark.parametrize("ending", BAG_SUFFIXES)
def test_another_file_of_that_name_is_refused(tmp_path, ending):
    path = tmp_path / f"notes{ending}"
    path.write_text("no bag at all")
    assert "is no bag of ROS 2" in refusal(path)


def test_without_the_library_the_extra_is_named(bag, monkeypatch):
    for name in [one for one in sys.modules if one.partition(".")[0] == "rosbags"]:
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(MissingDependency) as error:
        read_clip(bag)
    assert str(error.value) == (
        f"{bag}: a bag is read with rosbags, which is not installed; run `pip install "
        f"'geotlm-lm[ros]'`."
    )
