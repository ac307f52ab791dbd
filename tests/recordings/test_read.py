"""What is written in any supported form comes back as the same frames, colours in RGB order.

Which recordings a folder holds, and the rate of a recording by the times of its frames.
"""

import tracemalloc
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.recordings import arrays, policy
from geotlm_lm.recordings.pixels import layout_of
from geotlm_lm.recordings.policy import rate_by, uneven_times_s
from geotlm_lm.recordings.read import clips_in, read_clip, skipped_in


def colourful(count=5, rows=24, columns=32):
    rng = np.random.default_rng(3)
    frames = rng.integers(0, 256, (count, rows, columns, 3)).astype(np.uint8)
    frames[..., 0] |= 128  # red is always bright: a swapped order of colours cannot pass
    frames[..., 2] &= 63
    return frames


FRAMES = colourful()


def write_images(folder, frames=FRAMES, names="{}.png", flags=()):
    """Write one image per frame; their names are listed, or a pattern for their numbers."""
    names = [names.format(k) for k in range(len(frames))] if isinstance(names, str) else names
    for name, frame in zip(names, frames, strict=True):
        cv2.imwrite(str(folder / name), frame[..., ::-1], list(flags))


def write_video(path, frames=FRAMES, fps=10, code="FFV1"):
    size = frames[0].shape[1::-1]
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*code), fps, size)
    for frame in frames:
        writer.write(np.ascontiguousarray(frame[..., ::-1]))
    writer.release()
    return path


def write_gif(path, frames, durations_ms):
    first, *others = map(Image.fromarray, frames)
    first.save(path, save_all=True, append_images=others, duration=durations_ms)
    return path


def levels(count):
    """Frames of one grey level each, told by its number: 0, 10, 20, ..."""
    return [np.full((24, 32, 3), 10 * number, np.uint8) for number in range(count)]


def refusal(path, read=read_clip, **options):
    """Return the sentence that refuses a path, behind its name."""
    with pytest.raises(UnreadableClip) as error:
        read(path, **options)
    assert str(error.value).startswith(f"{path}: ")
    return str(error.value).removeprefix(f"{path}: ")


STORED = {
    "uint8": FRAMES,
    "unit float": FRAMES / np.float32(255),
    "double": FRAMES / 255,
    "half": FRAMES.astype(np.float16),
    "int64": FRAMES.astype(np.int64),
    "colours first": np.moveaxis(FRAMES, -1, 1),
    "big endian": FRAMES.astype(">u2"),
    "fortran order": np.asfortranarray(FRAMES),
    "16 bits": FRAMES.astype(np.uint16) * 257,
    "16 bits, big endian": (FRAMES.astype(np.uint16) * 257).astype(">u2"),
    "alpha": np.pad(FRAMES, [(0, 0)] * 3 + [(0, 1)], constant_values=255),
    "unit float with alpha of 255": np.pad(
        FRAMES / 255, [(0, 0)] * 3 + [(0, 1)], constant_values=255
    ),
}


@pytest.mark.parametrize("stored", STORED)
def test_an_array_comes_back_whatever_its_layout_and_range(tmp_path, stored):
    np.save(tmp_path / "clip.npy", STORED[stored])
    assert np.array_equal(read_clip(tmp_path / "clip.npy").frames, FRAMES)


def test_what_was_done_to_channels_and_bits_is_told(tmp_path):
    stored = np.pad(FRAMES.astype(np.uint16) * 257, [(0, 0)] * 3 + [(0, 1)])
    np.savez(tmp_path / "clip.npz", rgba=stored, mask=stored[..., 0], background=stored[0])
    clip = read_clip(tmp_path / "clip.npz")
    assert np.array_equal(clip.frames, FRAMES)
    assert np.array_equal(clip.background, FRAMES[0])
    assert clip.notes == (
        "Colours were taken for red, green, blue; pass --layout BGR if OpenCV gave them.",
        "The fourth channel was taken for alpha and left out.",
        "The array 'rgba' was taken for the frames.",
    )


@pytest.mark.parametrize("layout", ["BGR", "bgr", "THWC-BGR"])
def test_colours_in_opencvs_order_are_turned_round_those_of_the_background_too(tmp_path, layout):
    swapped = FRAMES[..., ::-1]
    np.savez(tmp_path / "clip.npz", frames=swapped, background=swapped[0])
    np.save(tmp_path / "clip.npy", swapped)
    np.save(tmp_path / "idle.npy", np.moveaxis(swapped[1], -1, 0))
    archive = read_clip(tmp_path / "clip.npz", layout=layout)
    array = read_clip(tmp_path / "clip.npy", layout=layout, background=tmp_path / "idle.npy")
    assert np.array_equal(archive.frames, FRAMES)
    assert np.array_equal(archive.background, FRAMES[0])
    assert np.array_equal(array.frames, FRAMES)
    assert np.array_equal(array.background, FRAMES[1])
    assert archive.notes == ()
    np.save(tmp_path / "grey.npy", FRAMES[..., 0])
    grey = read_clip(tmp_path / "grey.npy", layout="thw").frames
    assert np.array_equal(grey, np.repeat(FRAMES[..., :1], 3, axis=-1))
    first = np.pad(np.moveaxis(swapped, -1, 1), [(0, 0), (0, 1), (0, 0), (0, 0)])
    np.save(tmp_path / "first.npy", first)
    assert np.array_equal(read_clip(tmp_path / "first.npy", layout="TCHW-BGR").frames, FRAMES)


def test_what_was_guessed_is_stated(tmp_path):
    np.save(tmp_path / "clip.npy", FRAMES / 255)
    assert read_clip(tmp_path / "clip.npy").notes == (
        "Colours were taken for red, green, blue; pass --layout BGR if OpenCV gave them.",
    )


@pytest.mark.parametrize(("stated", "notes"), [("THWC-RGB", 0), ("bgr", 0), ("left", 1)])
def test_an_archive_may_state_its_layout(tmp_path, stated, notes):
    frames = FRAMES[..., ::-1] if stated == "bgr" else FRAMES
    np.savez(tmp_path / "clip.npz", frames=frames, background=frames[0], layout=stated)
    clip = read_clip(tmp_path / "clip.npz")
    assert np.array_equal(clip.frames, FRAMES)
    assert np.array_equal(clip.background, FRAMES[0])
    assert len(clip.notes) == notes


def test_a_shape_that_fits_two_layouts_says_which_was_assumed():
    assert layout_of((4, 3, 16, 3), None, "clip.npy") == (
        "THWC",
        "Shape (4, 3, 16, 3) was taken for frames, rows, columns, colours; pass --layout TCHW if "
        "its colours come second.",
    )


def test_a_lossless_video_comes_back_in_rgb(tmp_path):
    clip = read_clip(write_video(tmp_path / "clip.avi"))
    assert (len(clip), clip.fps) == (len(FRAMES), 10)
    # FFV1 keeps colours at half resolution here; single pixels move, means do not.
    means = clip.frames.mean(axis=(1, 2)) - FRAMES.mean(axis=(1, 2))
    assert np.abs(means).max() < 2


@pytest.mark.parametrize(("suffix", "code"), [(".webm", "VP80"), (".m4v", "mp4v")])
def test_a_lossy_video_comes_back_in_rgb_and_is_said_to_be_one(tmp_path, suffix, code):
    smooth = [cv2.resize(cv2.blur(frame, (9, 9)), (64, 48)) for frame in FRAMES]
    clip = read_clip(write_video(tmp_path / f"clip{suffix}", smooth, code=code))
    assert (len(clip), clip.fps) == (len(FRAMES), 10)
    means = clip.frames.mean(axis=(1, 2)) - np.mean(smooth, axis=(1, 2))
    assert np.abs(means).max() < 6
    assert clip.notes[0] == (
        f"This {suffix[1:]} video is lossy and blurs fine imprints; record .npy, .png or FFV1 "
        f"instead."
    )


def test_a_layout_is_said_not_to_be_used_where_there_is_none(tmp_path):
    write_images(tmp_path)
    note = "The layout THW is not used: only arrays have one to tell."
    assert read_clip(tmp_path, layout="thw").notes[-1] == note
    assert note not in read_clip(tmp_path).notes


def test_a_background_image_is_read_in_rgb(tmp_path):
    np.save(tmp_path / "clip.npy", FRAMES)
    cv2.imwrite(str(tmp_path / "idle.png"), FRAMES[0][..., ::-1])
    clip = read_clip(tmp_path / "clip.npy", background=tmp_path / "idle.png")
    assert np.array_equal(clip.background, FRAMES[0])


def test_a_long_array_is_read_at_a_stride_and_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(policy, "KEPT_BYTES", 6 * FRAMES[0].nbytes)
    frames = colourful(count=20)
    np.savez(tmp_path / "clip.npz", frames=frames, fps=40.0)
    clip = read_clip(tmp_path / "clip.npz")
    assert clip.frame_numbers == (0, 4, 8, 12, 16)
    assert np.array_equal(clip.frames, frames[::4])
    # The rate is the recording's, which the frame numbers count in: four frames are 0.1 s apart.
    assert clip.fps == 40
    assert read_clip(tmp_path / "clip.npz", fps=20).fps == 20
    assert clip.notes[-1] == (
        "Of 20 frames one in 4 was read to bound memory; cut the recording to see all of them."
    )


@pytest.mark.parametrize("block_bytes", [1, 30_000])
def test_an_archive_that_unpacks_to_more_than_is_kept_is_never_held_whole(
    tmp_path, monkeypatch, block_bytes
):
    frames = colourful(count=1_000)
    kept = 340 * frames[0].nbytes  # one in 3 fits
    monkeypatch.setattr(arrays, "KEPT_BYTES", kept)
    monkeypatch.setattr(arrays, "BLOCK_BYTES", block_bytes)
    monkeypatch.setattr(policy, "KEPT_BYTES", kept)
    np.savez_compressed(tmp_path / "clip.npz", frames=frames)
    tracemalloc.start()
    clip = read_clip(tmp_path / "clip.npz")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert clip.frame_numbers == tuple(range(0, 1_000, 3))
    assert np.array_equal(clip.frames, frames[::3])
    assert clip.notes[-1].startswith("Of 1000 frames one in 3 was read to bound memory")
    assert peak < 0.8 * frames.nbytes  # a third as stored, a third as RGB


def test_an_archive_whose_frames_cannot_be_taken_one_by_one_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(arrays, "KEPT_BYTES", FRAMES.nbytes - 1)
    np.savez(tmp_path / "clip.npz", frames=np.asfortranarray(FRAMES))
    with pytest.raises(UnreadableClip, match="'frames' unpacks to .*; save it as .npy instead"):
        read_clip(tmp_path / "clip.npz")


@pytest.mark.parametrize("room", [5, 6, 7])
def test_a_long_video_is_read_at_a_stride_and_says_so(tmp_path, monkeypatch, room):
    monkeypatch.setattr(policy, "KEPT_BYTES", room * 24 * 32 * 3)
    clip = read_clip(write_video(tmp_path / "clip.avi", levels(20)))
    assert clip.frame_numbers == (0, 4, 8, 12, 16)
    assert clip.fps == 10
    assert np.abs(clip.frames.mean(axis=(1, 2, 3)) - [0, 40, 80, 120, 160]).max() < 2


@pytest.mark.parametrize(
    ("name", "limit", "read"), [("DECODING_S", -1.0, 4), ("DECODED_FRAMES", 9, 9)]
)
def test_a_video_that_takes_too_long_is_read_in_part_and_says_so(
    tmp_path, monkeypatch, name, limit, read
):
    path = write_video(tmp_path / "clip.avi", levels(10))
    assert len(read_clip(path)) == 10
    assert not any("Only the first" in note for note in read_clip(path).notes)
    monkeypatch.setattr(policy, name, limit)
    clip = read_clip(path)
    assert clip.frame_numbers == tuple(range(read))
    assert clip.notes[-1] == f"Only the first {read} frames were read; cut the recording."


def test_recordings_are_known_files_and_folders_of_images(tmp_path):
    for name in ("b.npy", "a.MP4", "c.txt", ".hidden.npy"):
        (tmp_path / name).write_bytes(b"")
    (tmp_path / "frames").mkdir()
    (tmp_path / "frames" / "0.png").write_bytes(b"")
    (tmp_path / "notes").mkdir()
    assert [one.name for one in clips_in(tmp_path)] == ["a.MP4", "b.npy", "frames"]
    assert [one.name for one in skipped_in(tmp_path)] == ["c.txt", "notes"]


def test_a_folder_that_may_not_be_opened_is_refused(tmp_path, monkeypatch):
    def refuse(path):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "iterdir", refuse)
    assert refusal(tmp_path, clips_in) == (
        "cannot be opened (Permission denied); check its permissions."
    )


KINDS = (
    ".npy, .npz, .mp4, .m4v, .avi, .mov, .mkv, .webm, .gif, .tif, .tiff, .mcap, .db3, .bag or "
    "folders of images"
)


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("empty", f"holds no recording, expected {KINDS}; give the folder they lie in."),
        (
            "frames",
            "holds images, which are frames of one recording, expected a folder of recordings: "
            f"{KINDS}; give the folder that this one lies in.",
        ),
        ("nowhere", "no such folder; give the one your recordings lie in."),
        ("clip.npz", "is a file, expected a folder; give the one your recordings lie in."),
    ],
)
def test_what_is_no_folder_of_recordings_is_refused(tmp_path, name, sentence):
    (tmp_path / "clip.npz").write_bytes(b"a recording")
    (tmp_path / "empty").mkdir()
    (tmp_path / "frames").mkdir()
    for image in ("0.png", "1.PNG", "notes.txt"):
        (tmp_path / "frames" / image).write_bytes(b"")
    assert refusal(tmp_path / name, clips_in) == sentence


@pytest.mark.parametrize(
    ("times_ms", "header_fps"),
    [
        (np.delete(np.arange(50) * 40.0, [7, 20]), 25.0),  # two frames were dropped
        *((np.rint(np.arange(100) * 1000 / fps), fps) for fps in (30.0, 60.0, 240.0, 400.0)),
        ([0.0] * 9, 25.0),
    ],
)
def test_a_headers_rate_is_kept_where_the_times_are_rounded_or_missing(times_ms, header_fps):
    assert rate_by(times_ms, header_fps) == (header_fps, ())


def test_a_rate_that_changes_is_none():
    times_ms = np.cumsum(np.r_[np.full(25, 40.0), np.full(25, 200.0)])
    fps, notes = rate_by(times_ms, 8.3)
    assert fps is None
    assert "40 to 200 ms" in notes[0]
    assert notes[0].endswith("give that of the frames used by fps.")


def test_uneven_times_are_kept_from_the_first_frame_on():
    times_ms = 500 + np.cumsum([0, 40, 40, 200, 40])
    assert uneven_times_s(times_ms, None) == pytest.approx((0, 0.04, 0.08, 0.28, 0.32))
    assert uneven_times_s(times_ms, 25.0) != ()


def test_even_times_and_none_are_left_to_the_rate():
    assert uneven_times_s(np.rint(np.arange(100) * 1000 / 30), 30.0) == ()
    assert uneven_times_s([0.0] * 9, 25.0) == ()
    assert uneven_times_s([0.0, 40.0, 20.0, 60.0], 25.0) == ()
