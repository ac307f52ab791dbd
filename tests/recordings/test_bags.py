"""Bags of ROS come back as any other recording, and what is no such bag is told in a sentence."""

import shutil
import sys
from io import BytesIO

import cv2
import numpy as np
import pytest
from PIL import Image

from geotlm_lm.core.errors import MissingDependency, UnreadableClip
from geotlm_lm.recordings import policy
from geotlm_lm.recordings.bags import BAG_SUFFIXES, ENCODINGS
from geotlm_lm.recordings.listing import clips_in
from geotlm_lm.recordings.read import each_frame, read_clip
from geotlm_lm.recordings.streams import open_source
from tests.recordings.bag_files import (
    MCAP,
    PER_FILE,
    PER_MESSAGE,
    SQLITE,
    STEP_NS,
    TOPIC,
    even_ns,
    first_bag,
    packed,
    raw,
    raw_bag,
    stored_as,
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


def test_a_turn_that_they_state_is_applied_and_told(tmp_path):
    exif = Image.Exif()
    exif[274] = 3
    messages = []
    for frame, at in zip(FRAMES, even_ns(9), strict=True):
        stored = BytesIO()
        Image.fromarray(frame).save(stored, "PNG", exif=exif)
        message = packed(frame, at)
        message.data = np.frombuffer(stored.getvalue(), np.uint8)
        messages.append(message)
    path = write_bag(tmp_path / "run", {TOPIC: messages})
    clip = read_clip(path)
    assert np.array_equal(clip.frames, FRAMES[:, ::-1, ::-1])
    assert clip.notes[0].startswith("Pictures were turned by 180 degrees")
    assert open_source(str(path)).notes == clip.notes[:1]


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
    monkeypatch.setattr(policy, "KEPT_BYTES", 4 * FRAMES[0].nbytes)
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
    path = write_bag(tmp_path / "run", {TOPIC: [raw(FRAMES[0], 1, "nv12")]})
    assert refusal(path) == (
        f"{path}: image 0 has the encoding nv12, expected {', '.join(ENCODINGS)}; publish the "
        f"camera's images in one of these."
    )


def test_images_of_changing_sizes_are_refused(tmp_path):
    messages = [*stamped(even_ns(2), FRAMES[:2]), raw(FRAMES[2][:-1], even_ns(3)[2])]
    path = write_bag(tmp_path / "run", {TOPIC: messages})
    rows, columns = FRAMES.shape[1:3]
    sentence = (
        f"{path}: frame 2 is {columns} x {rows - 1} pixels after {columns} x {rows}, expected one "
        f"size; record or export it at one size."
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
    assert f"is no bag of ROS {1 if ending == '.bag' else 2}" in refusal(path)


@pytest.mark.parametrize("make", [raw, packed])
def test_one_of_ros_1_is_read_as_one_of_ros_2(tmp_path, make):
    messages = [make(*pair) for pair in zip(FRAMES, even_ns(9), strict=True)]
    path = first_bag(tmp_path / "run.bag", {TOPIC: messages, "/other": messages[:3]})
    clip = read_clip(path, topic=TOPIC)
    assert np.array_equal(clip.frames, FRAMES)
    assert clip.fps == pytest.approx(25)
    assert len(list(open_source(str(path), topic=TOPIC))) == 9
    assert clips_in(tmp_path) == [path]
    assert "holds images on 2 topics, /gelsight/image_raw (9 images), /other (3" in refusal(path)


@pytest.mark.parametrize("share", [0.001, 0.1, 0.5, 0.9])
def test_one_of_ros_1_that_is_cut_off_is_refused_in_a_sentence(tmp_path, share):
    messages = [raw(*pair) for pair in zip(FRAMES, even_ns(9), strict=True)]
    path = first_bag(tmp_path / "run.bag", {TOPIC: messages})
    path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])
    assert refusal(path) == (
        f"{path}: is cut off or is no bag of ROS 1, expected what `rosbag record` writes; copy it "
        f"again, or repair it by `rosbag reindex`."
    )


DEEP = FRAMES.astype(np.uint16) * 257
ALPHA = np.full((*FRAMES.shape[:3], 1), 9, np.uint8)
EXACT = {
    "rgb16": DEEP,
    "bgr16": DEEP[..., ::-1],
    "16UC3": DEEP[..., ::-1],
    "mono16": GREY[..., :1].astype(np.uint16) * 257,
    "16UC1": GREY[..., :1].astype(np.uint16) * 257,
    "rgba8": np.concatenate([FRAMES, ALPHA], axis=-1),
    "bgra8": np.concatenate([FRAMES[..., ::-1], ALPHA], axis=-1),
    "8UC4": np.concatenate([FRAMES[..., ::-1], ALPHA], axis=-1),
    "rgba16": np.concatenate([DEEP, ALPHA], axis=-1),
    "bgra16": np.concatenate([DEEP[..., ::-1], ALPHA], axis=-1),
}


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("encoding", EXACT)
def test_other_orders_and_depths_of_colours_come_back(tmp_path, encoding, order):
    pixels = EXACT[encoding].astype(EXACT[encoding].dtype.newbyteorder(order))
    messages = [stored_as(one, encoding, at) for one, at in zip(pixels, even_ns(9), strict=True)]
    clip = read_clip(write_bag(tmp_path / "run", {TOPIC: messages}))
    is_grey = encoding in ("mono16", "16UC1")
    assert np.array_equal(clip.frames, GREY if is_grey else FRAMES)
    is_open = encoding in ("16UC3", "8UC4")
    assert any(f"{encoding} does not tell" in note for note in clip.notes) == is_open


FLAT = np.array([200, 100, 50])


def mosaic(order):
    """Return a picture of one colour behind a filter whose four upper left pixels are `order`."""
    tile = [[FLAT["rgb".index(name)] for name in pair] for pair in (order[:2], order[2:])]
    return np.tile(np.array(tile, np.uint8), (12, 16))[..., None]


def luma_chroma(order):
    """Return a picture of one colour as bytes of pairs of pixels in an order such as `uyvy`."""
    red, green, blue = FLAT / 255
    y = 16 + 65.481 * red + 128.553 * green + 24.966 * blue
    u = 128 - 37.797 * red - 74.203 * green + 112 * blue
    v = 128 + 112 * red - 93.786 * green - 18.214 * blue
    pair = [{"y": y, "u": u, "v": v}[name] for name in order]
    return np.tile(np.rint(pair).astype(np.uint8), (24, 16)).reshape(24, 32, 2)


SAMPLED = {
    **{f"bayer_{order}8": mosaic(order) for order in ("rggb", "bggr", "gbrg", "grbg")},
    "bayer_rggb16": mosaic("rggb").astype(np.uint16) * 257,
    "yuv422": luma_chroma("uyvy"),
    "uyvy": luma_chroma("uyvy"),
    "yuv422_yuy2": luma_chroma("yuyv"),
    "yuyv": luma_chroma("yuyv"),
}


@pytest.mark.parametrize("encoding", SAMPLED)
def test_colours_sampled_sparsely_come_back(tmp_path, encoding):
    messages = [stored_as(SAMPLED[encoding], encoding, at) for at in even_ns(2)]
    frames = read_clip(write_bag(tmp_path / "run", {TOPIC: messages})).frames
    assert np.abs(frames.astype(int) - FLAT).max() <= 2


def test_pixels_in_pairs_of_an_odd_width_are_refused(tmp_path):
    message = stored_as(SAMPLED["uyvy"][:, :31], "yuv422")
    assert refusal(write_bag(tmp_path / "run", {TOPIC: [message]})).endswith(
        "image 0 has 31 x 24 pixels, which the encoding yuv422 does not divide into its groups; "
        "publish the camera's images as rgb8."
    )


def test_16_bits_that_stay_dark_are_refused_as_those_of_a_png(tmp_path):
    message = stored_as(DEEP[0] // 64, "rgb16")
    assert "holds 16-bit values up to" in refusal(write_bag(tmp_path / "run", {TOPIC: [message]}))


def test_without_the_library_the_extra_is_named(bag, monkeypatch):
    for name in [one for one in sys.modules if one.partition(".")[0] == "rosbags"]:
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(MissingDependency) as error:
        read_clip(bag)
    assert str(error.value) == (
        f"{bag}: a bag is read with rosbags, which is not installed; run `pip install "
        f"'geotlm-lm[ros]'`."
    )
