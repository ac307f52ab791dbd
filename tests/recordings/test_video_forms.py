"""Forms of video: GIF, AV1, pixels that are not square, pictures that a file states as turned."""

import os
import struct
import sys
from fractions import Fraction

import cv2
import numpy as np
import pytest
from PIL import Image

from geotlm_lm.core.errors import MissingDependency, UnreadableClip
from geotlm_lm.doctor.examine import mount
from geotlm_lm.recordings import policy
from geotlm_lm.recordings.read import clips_in, each_frame, read_clip
from geotlm_lm.recordings.streams import open_source
from tests.recordings.test_read import FRAMES, write_gif

av = pytest.importorskip("av", reason="needs the extra `lerobot`")

QUARTERS = {90: (0, 1, -1, 0), 180: (-1, 0, 0, -1), 270: (0, -1, 1, 0)}
"""Degrees clockwise -> the matrix that an .mp4 states."""


def write_av(path, frames, codec="libsvtav1", fps=10, aspect=None):
    """Write frames by PyAV, with the width of a pixel over its height where it is given."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=fps)
        stream.height, stream.width = frames[0].shape[:2]
        stream.pix_fmt = "yuv420p"
        if aspect is not None:
            stream.codec_context.sample_aspect_ratio = aspect
        for frame in frames:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(frame, format="rgb24")))
        container.mux(stream.encode(None))
    if codec == "libsvtav1" and hasattr(os, "sched_setscheduler"):
        # Run by root, its encoder leaves this process, and all it starts, at real-time priority.
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    return path


def turned(path, degrees):
    """State in an .mp4 that its pictures are to be turned clockwise."""
    stored = bytearray(path.read_bytes())
    at = stored.index(b"tkhd") + 44
    across, down, over, under = (value << 16 for value in QUARTERS[degrees])
    stored[at : at + 36] = struct.pack(">9i", across, down, 0, over, under, 0, 0, 0, 1 << 30)
    path.write_bytes(stored)
    return path


CORNERED = np.full((6, 48, 64, 3), 90, np.uint8)
"""Frames with a red corner at the upper left."""
CORNERED[:, :16, :24] = (220, 40, 40)
CORNERED[:, 30:] += np.arange(6, dtype=np.uint8)[:, None, None, None] * 20

FEW = FRAMES // 64 * 64
"""Frames of few colours, which a GIF holds as they are."""

TURNED_NOTE = "Pictures were turned by {} as the file states"


def every_way(path, monkeypatch):
    """Return a recording read at once, as a stream, and anew frame by frame."""
    clip = read_clip(path)
    streamed = np.stack([frame.image for frame in open_source(str(path))])
    monkeypatch.setattr(policy, "KEPT_BYTES", 4 * clip.frames[0].nbytes)
    strided = read_clip(path)
    assert len(strided) < len(clip)
    return clip, streamed, np.stack([image for _, image in each_frame(strided)])


def test_a_gif_is_read_as_an_array_of_its_frames(tmp_path, monkeypatch):
    path = write_gif(tmp_path / "clip.gif", FEW, 40)
    clip, *others = every_way(path, monkeypatch)
    assert np.array_equal(clip.frames, FEW)
    assert all(np.array_equal(frames, FEW) for frames in others)
    assert (clip.fps, clip.times_s) == (25, ())
    assert clip.notes[0].startswith("This gif video is lossy")
    assert clips_in(tmp_path) == [path]


@pytest.mark.parametrize(
    ("durations_ms", "fps", "times_s"),
    [
        (10, 100, ()),  # which players slow down to 10 a second
        (0, None, ()),
        ([40, 40, 120, 40, 40], None, (0, 0.04, 0.08, 0.2, 0.24)),
    ],
)
def test_the_durations_of_a_gifs_frames_are_its_times(tmp_path, durations_ms, fps, times_s):
    clip = read_clip(write_gif(tmp_path / "clip.gif", FEW, durations_ms))
    assert clip.fps == (None if fps is None else pytest.approx(fps))
    assert clip.times_s == pytest.approx(times_s)


def test_a_gif_that_is_cut_off_is_told_to_be(tmp_path):
    path = write_gif(tmp_path / "clip.gif", FEW, 40)
    stored = path.read_bytes()
    path.write_bytes(stored[: len(stored) * 3 // 4])
    clip = read_clip(path)
    assert np.array_equal(clip.frames, FEW[: len(clip)])
    assert 2 <= len(clip) < len(FEW)
    assert "The end of this gif is missing" in clip.notes[0]
    path.write_bytes(stored[:50])
    with pytest.raises(UnreadableClip, match="no frame of it can be decoded"):
        read_clip(path)


@pytest.mark.parametrize("ending", [".mp4", ".mkv"])
def test_av1_is_read(tmp_path, monkeypatch, ending):
    path = write_av(tmp_path / f"clip{ending}", CORNERED)
    clip, *others = every_way(path, monkeypatch)
    assert np.abs(clip.frames.astype(int) - CORNERED).mean() < 3
    assert all(np.array_equal(frames, clip.frames) for frames in others)
    assert clip.fps == 10


def test_tags_of_av1_that_are_no_text_do_no_harm(tmp_path):
    path = write_av(tmp_path / "clip.mkv", CORNERED)
    stored = path.read_bytes()
    path.write_bytes(stored.replace(b"ENCODER", b"ENCOD\x95R"))
    assert path.read_bytes() != stored
    assert len(read_clip(path)) == len(CORNERED)


def test_without_its_decoder_the_extra_is_named(tmp_path, monkeypatch):
    path = write_av(tmp_path / "clip.mp4", CORNERED)
    for name in [name for name in sys.modules if name.partition(".")[0] == "av"]:
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(MissingDependency) as error:
        read_clip(path)
    assert str(error.value) == (
        f"{path}: is AV1 video, which is read with av, which is not installed; run `pip install "
        f"'geotlm-lm[lerobot]'`."
    )


@pytest.mark.parametrize(
    ("aspect", "size"), [(Fraction(1, 4), (192, 64)), (Fraction(2), (48, 128))]
)
def test_pixels_that_are_not_square_are_stretched(tmp_path, monkeypatch, aspect, size):
    path = write_av(tmp_path / "clip.mp4", CORNERED, "mpeg4", aspect=aspect)
    clip, *others = every_way(path, monkeypatch)
    assert clip.frames.shape[1:3] == size
    assert all(np.array_equal(frames, clip.frames) for frames in others)
    ratio = f"The file states pixels {float(aspect):.3g} times as wide as high: pictures were "
    assert any(note.startswith(ratio) for note in clip.notes)
    assert open_source(str(path)).notes[0].startswith(ratio)


@pytest.mark.parametrize("aspect", [Fraction(1, 20), Fraction(20)])
def test_pixels_of_a_senseless_shape_are_left_as_they_are(tmp_path, aspect):
    clip = read_clip(write_av(tmp_path / "clip.mp4", CORNERED, "mpeg4", aspect=aspect))
    assert clip.frames.shape == CORNERED.shape
    assert clip.notes[0].endswith(" times as wide as high, which is not used.")


QUARTER_NAMES = {90: "90 degrees clockwise", 180: "180 degrees", 270: "90 degrees counterclockwise"}


@pytest.mark.parametrize("codec", ["mpeg4", "libsvtav1"])
@pytest.mark.parametrize("degrees", QUARTER_NAMES)
def test_a_turn_that_a_video_states_is_applied_and_told(tmp_path, monkeypatch, degrees, codec):
    path = turned(write_av(tmp_path / "clip.mp4", CORNERED, codec), degrees)
    clip, *others = every_way(path, monkeypatch)
    upright = np.rot90(CORNERED, -degrees // 90, axes=(1, 2))
    assert np.abs(clip.frames.astype(int) - upright).mean() < 4
    assert all(np.array_equal(frames, clip.frames) for frames in others)
    assert clip.notes[0].startswith(TURNED_NOTE.format(QUARTER_NAMES[degrees]))
    assert mount(clip).measured == (
        f"the file states pictures turned by {QUARTER_NAMES[degrees]}, and so they were."
    )


def test_pixels_of_a_turned_picture_are_turned_too(tmp_path):
    path = turned(write_av(tmp_path / "clip.mp4", CORNERED, "mpeg4", aspect=Fraction(1, 4)), 90)
    assert read_clip(path).frames.shape[1:3] == (64, 192)


STILLS = {".jpg": {"quality": 95}, ".png": {}, ".tif": {}, ".webp": {"lossless": True}}


def write_stills(folder, ending, frames=CORNERED, **stated):
    for number, frame in enumerate(frames):
        Image.fromarray(frame).save(folder / f"{number}{ending}", **STILLS[ending], **stated)
    return folder


UPRIGHT = {
    2: CORNERED[:, :, ::-1],
    3: CORNERED[:, ::-1, ::-1],
    4: CORNERED[:, ::-1],
    5: CORNERED.swapaxes(1, 2),
    6: np.rot90(CORNERED, -1, axes=(1, 2)),
    7: CORNERED[:, ::-1, ::-1].swapaxes(1, 2),
    8: np.rot90(CORNERED, 1, axes=(1, 2)),
}
"""Orientation as EXIF numbers it -> how the pictures are to be shown."""


@pytest.mark.parametrize("ending", STILLS)
@pytest.mark.parametrize("orientation", UPRIGHT)
def test_an_orientation_that_images_state_is_applied_and_told(tmp_path, ending, orientation):
    exif = Image.Exif()
    exif[274] = orientation
    stated = {"tiffinfo": {274: orientation}} if ending == ".tif" else {"exif": exif}
    clip = read_clip(write_stills(tmp_path, ending, **stated))
    assert np.abs(clip.frames.astype(int) - UPRIGHT[orientation]).mean() < 3
    assert any("as the file states; directions" in note for note in clip.notes)
    assert mount(clip).verdict == "limit"


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_that_of_a_stack_of_pages_too(tmp_path, kind):
    grey = CORNERED[..., 0].astype(kind) * (1 if kind == np.uint8 else 257)
    first, *others = map(Image.fromarray, grey)
    path = tmp_path / "clip.tif"
    first.save(path, save_all=True, append_images=others, tiffinfo={274: 6, 282: 100, 283: 200})
    clip = read_clip(path)
    assert clip.frames.shape[1:3] == (128, 48)
    assert clip.notes[1].startswith(TURNED_NOTE.format("90 degrees clockwise"))


def test_a_tiff_that_pillow_does_not_open_states_its_orientation_all_the_same(tmp_path):
    deep = CORNERED.astype(np.uint16) * 257
    for number, frame in enumerate(deep):
        stored = bytearray(cv2.imencode(".tif", frame[..., ::-1])[1].tobytes())
        [at] = (k for k in range(len(stored) - 12) if stored[k : k + 4] == b"\x1c\x01\x03\0")
        stored[at : at + 12] = b"\x12\x01\x03\0\x01\0\0\0\x03\0\0\0"
        (tmp_path / f"{number}.tif").write_bytes(stored)
    clip = read_clip(tmp_path)
    assert np.array_equal(clip.frames, UPRIGHT[3])
    assert any(note.startswith(TURNED_NOTE.format("180 degrees")) for note in clip.notes)


@pytest.mark.parametrize("ending", [".jpg", ".png", ".tif"])
def test_resolutions_that_differ_across_and_down_stretch_images(tmp_path, ending):
    clip = read_clip(write_stills(tmp_path, ending, dpi=(100, 200)))
    assert clip.frames.shape[1:3] == (48, 128)
    assert "pixels 2 times as wide as high" in clip.notes[1]
