"""Bags of ROS come back as any other recording; what is no such bag is refused in a sentence."""

import shutil
import sys
from io import BytesIO

import cv2
import numpy as np
import pytest
from PIL import Image

from geotlm_lm.core.errors import MissingDependency
from geotlm_lm.recordings import policy
from geotlm_lm.recordings.bags import BAG_SUFFIXES, ENCODINGS
from geotlm_lm.recordings.read import clips_in, each_frame, read_clip
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
from tests.recordings.test_read import colourful, refusal

FRAMES = colourful(count=9)
GREY = np.stack(
    [cv2.cvtColor(cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY), cv2.COLOR_GRAY2RGB) for frame in FRAMES]
)


def stamped(stamps_ns, frames=FRAMES, make=raw, *options):
    return [make(frame, at, *options) for frame, at in zip(frames, stamps_ns, strict=True)]


def bag_of(folder, messages, **options):
    return write_bag(folder / "run", {TOPIC: messages}, **options)


@pytest.fixture
def bag(tmp_path):
    return raw_bag(tmp_path / "run", FRAMES)


@pytest.mark.parametrize("storage", [MCAP, SQLITE])
@pytest.mark.parametrize("encoding", ["rgb8", "bgr8", "8UC3", "mono8"])
def test_its_images_are_frames_in_rgb(tmp_path, encoding, storage):
    path = raw_bag(tmp_path / "run", FRAMES, encoding, storage=storage)
    clip = read_clip(path, topic=TOPIC)
    assert np.array_equal(clip.frames, GREY if encoding == "mono8" else FRAMES)
    assert clip.fps == pytest.approx(25)
    assert clip.times_s == ()
    assert any("8UC3 does not tell" in note for note in clip.notes) == (encoding == "8UC3")
    [stored] = (file for file in path.iterdir() if file.suffix in BAG_SUFFIXES)
    alone = shutil.move(stored, tmp_path / f"alone{stored.suffix}")
    assert np.array_equal(read_clip(alone).frames, clip.frames)


@pytest.mark.parametrize("mode", [PER_FILE, PER_MESSAGE])
def test_a_compressed_one_is_read(tmp_path, mode):
    folder = raw_bag(tmp_path / "run", FRAMES, storage=SQLITE, compression=mode)
    assert np.array_equal(read_clip(folder).frames, FRAMES)


def test_padding_behind_the_rows_is_left_out(tmp_path):
    path = bag_of(tmp_path, stamped(even_ns(9), FRAMES, raw, "bgr8", 5))
    assert np.array_equal(read_clip(path).frames, FRAMES)


@pytest.mark.parametrize(("ending", "most"), [("png", 0), ("jpg", 40)])
def test_compressed_images_are_decoded(tmp_path, ending, most):
    smooth = np.stack([cv2.GaussianBlur(frame, (0, 0), 3) for frame in FRAMES])
    clip = read_clip(bag_of(tmp_path, stamped(even_ns(9), smooth, packed, ending)))
    assert np.abs(clip.frames.astype(int) - smooth).max() <= most


def test_a_turn_that_they_state_is_applied_and_noted(tmp_path):
    exif, messages = Image.Exif(), stamped(even_ns(9), FRAMES, packed)
    exif[274] = 3
    for frame, message in zip(FRAMES, messages, strict=True):
        stored = BytesIO()
        Image.fromarray(frame).save(stored, "PNG", exif=exif)
        message.data = np.frombuffer(stored.getvalue(), np.uint8)
    path = bag_of(tmp_path, messages)
    clip = read_clip(path)
    assert np.array_equal(clip.frames, FRAMES[:, ::-1, ::-1])
    assert clip.notes[0].startswith("Pictures were turned by 180 degrees")
    assert open_source(str(path)).notes == clip.notes[:1]


def test_times_are_those_of_the_headers(tmp_path):
    stamps_ns = even_ns(9) + np.array([0, 0, 0, 0, 5, 5, 5, 5, 5]) * STEP_NS
    clip = read_clip(bag_of(tmp_path, stamped(stamps_ns)))
    steps = [0, 1, 2, 3, 9, 10, 11, 12, 13]
    assert clip.times_s == pytest.approx([0.04 * step for step in steps], abs=1e-6)


@pytest.mark.parametrize(
    ("stamps_ns", "lack"),
    [([0] * 9, "are missing"), (even_ns(9)[[0, 1, 2, 2, 3, 4, 5, 6, 7]], "do not rise")],
)
def test_without_them_those_of_the_recorder(tmp_path, stamps_ns, lack):
    received_ns = even_ns(9) + np.array([0, 0, 0, 0, 0, 3, 3, 3, 3]) * STEP_NS
    clip = read_clip(bag_of(tmp_path, stamped(stamps_ns), received_ns=received_ns))
    assert clip.times_s[4:6] == pytest.approx([0.16, 0.32], abs=1e-6)
    assert clip.notes[0].startswith(f"Stamps of the images {lack}: ")


def test_a_long_one_is_read_at_a_stride_and_followed_frame_by_frame(bag, monkeypatch):
    monkeypatch.setattr(policy, "KEPT_BYTES", 4 * FRAMES[0].nbytes)
    clip = read_clip(bag)
    assert clip.frame_numbers == (0, 4, 8)
    assert np.array_equal(clip.frames, FRAMES[::4])
    assert clip.notes[-1].startswith("Of 9 frames one in 4 was read")
    numbers, frames = zip(*each_frame(clip), strict=True)
    assert numbers == tuple(range(9))
    assert np.array_equal(np.stack(frames), FRAMES)


def test_it_is_a_stream_and_one_recording_of_a_folder(bag, tmp_path):
    source = open_source(str(bag), topic=TOPIC)
    frames = list(source)
    assert source.fps == pytest.approx(25)
    times_s = [frame.time_s for frame in frames]
    assert times_s == pytest.approx([0.04 * k for k in range(9)], abs=1e-6)
    assert np.array_equal(np.stack([frame.image for frame in frames]), FRAMES)
    assert [frame.time_s for frame in open_source(str(bag), fps=10)][-1] == pytest.approx(0.8)
    np.save(tmp_path / "other.npy", FRAMES)
    assert clips_in(tmp_path) == [tmp_path / "other.npy", bag]
    note = f"The topic {TOPIC} is not used: only bags have topics."
    assert read_clip(tmp_path / "other.npy", topic=TOPIC).notes[-1] == note


def test_a_topic_that_is_open_or_not_there_is_refused_with_those_that_are(tmp_path):
    messages = stamped(even_ns(9))
    topics = {"/left": messages, "/right": messages[:4], "/say": [text()]}
    path = write_bag(tmp_path / "run", topics)
    listed = "/left (9 images), /right (4 images)"
    assert refusal(path) == f"holds images on 2 topics, {listed}, expected one; give it by --topic."
    assert refusal(path, topic="/up") == (
        f"holds no images on the topic /up, expected {listed}; give one by --topic."
    )
    assert len(read_clip(path, topic="/right")) == 4
    assert refusal(write_bag(tmp_path / "text", {"/say": [text()]})) == (
        "holds no images but /say, expected a topic of sensor_msgs/msg/Image or "
        "sensor_msgs/msg/CompressedImage; record the sensor's."
    )


def cut(message, count):
    message.data = message.data[:-count]
    return message


DEEP = FRAMES.astype(np.uint16) * 257
DAMAGED = {
    "has the encoding nv12": (raw(FRAMES[0], 1, "nv12"), f"expected {', '.join(ENCODINGS)}; "),
    "has 2301 bytes in rows of 96": (cut(raw(FRAMES[0], 1), 3), "24 rows of 96; record it again."),
    "(png) is cut off": (cut(packed(FRAMES[0], 1), 20), "expected jpeg or png; record it again."),
    ": holds 16-bit values up to": (stored_as(DEEP[0] // 64, "rgb16"), "save them in 8 bits."),
    "has 31 x 24 pixels, which the encoding yuv422 does not divide": (
        stored_as(np.zeros((24, 31, 2), np.uint8), "yuv422"),
        "publish the camera's images as rgb8.",
    ),
}


@pytest.mark.parametrize("kind", DAMAGED)
def test_an_image_that_is_damaged_or_of_another_encoding_is_refused(tmp_path, kind):
    message, advice = DAMAGED[kind]
    sentence = refusal(bag_of(tmp_path, [message]))
    assert sentence.startswith(f"image 0{'' if kind[0] == ':' else ' '}{kind}")
    assert advice in sentence


def test_images_of_changing_sizes_are_refused(tmp_path):
    path = bag_of(tmp_path, [*stamped(even_ns(2), FRAMES[:2]), raw(FRAMES[2][:-1], even_ns(3)[2])])
    sentence = (
        "frame 2 is 32 x 23 pixels after 32 x 24, expected one size; record or export it at one "
        "size."
    )
    assert refusal(path) == sentence
    assert refusal(path, lambda path: list(open_source(str(path)))) == sentence


@pytest.mark.parametrize("share", [0.001, 0.7])
@pytest.mark.parametrize("kind", [MCAP, SQLITE, "ROS 1"])
def test_one_that_is_cut_off_is_refused_in_a_sentence(tmp_path, kind, share):
    folder = path = tmp_path / "run.bag"
    messages = stamped(even_ns(40), colourful(count=40))
    if kind == "ROS 1":
        first_bag(path, {TOPIC: messages})
    else:
        folder = bag_of(tmp_path, messages, storage=kind)
        [path] = (file for file in folder.iterdir() if file.suffix in BAG_SUFFIXES)
    path.write_bytes(path.read_bytes()[: max(int(share * path.stat().st_size), 1)])
    names = ("ROS 2", "ros2 bag record", "mcap recover")
    if kind == "ROS 1":
        names = ("ROS 1", "rosbag record", "rosbag reindex")
    assert refusal(folder) == (
        "is cut off or is no bag of {}, expected what `{}` writes; copy it again, or repair it by "
        "`{}`."
    ).format(*names)


@pytest.mark.parametrize("make", [raw, packed])
def test_one_of_ros_1_is_read_as_one_of_ros_2(tmp_path, make):
    messages = stamped(even_ns(9), FRAMES, make)
    path = first_bag(tmp_path / "run.bag", {TOPIC: messages, "/other": messages[:3]})
    clip = read_clip(path, topic=TOPIC)
    assert np.array_equal(clip.frames, FRAMES)
    assert clip.fps == pytest.approx(25)
    assert len(list(open_source(str(path), topic=TOPIC))) == 9
    assert clips_in(tmp_path) == [path]
    assert "holds images on 2 topics, /gelsight/image_raw (9 images), /other (3" in refusal(path)


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
    messages = [
        stored_as(frame, encoding, at) for frame, at in zip(pixels, even_ns(9), strict=True)
    ]
    clip = read_clip(bag_of(tmp_path, messages))
    assert np.array_equal(clip.frames, GREY if encoding in ("mono16", "16UC1") else FRAMES)
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
    frames = read_clip(bag_of(tmp_path, messages)).frames
    assert np.abs(frames.astype(int) - FLAT).max() <= 2


def test_without_the_library_the_extra_is_named(bag, monkeypatch):
    for name in [name for name in sys.modules if name.partition(".")[0] == "rosbags"]:
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(MissingDependency, match="read with rosbags, .*'geotlm-lm\\[ros\\]'`.$"):
        read_clip(bag)
