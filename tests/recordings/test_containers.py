"""A video that ends before its container says so is never taken for a whole one."""

import cv2
import numpy as np
import pytest

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.doctor.examine import file_end
from geotlm_lm.recordings.read import read_clip
from geotlm_lm.recordings.streams import open_source
from geotlm_lm.recordings.video import declared_end

FORMS = [
    (".mkv", "FFV1"),
    (".mkv", "MJPG"),
    (".webm", "VP80"),
    (".avi", "MJPG"),
    (".mp4", "mp4v"),
    (".mov", "mp4v"),
]


def opened(path, code):
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*code), 25, (64, 48))
    noise = np.random.default_rng(0)
    for _ in range(40):
        writer.write(cv2.blur(noise.integers(0, 255, (48, 64, 3), np.uint8), (5, 5)))
    return writer


@pytest.mark.parametrize(("suffix", "code"), FORMS)
@pytest.mark.parametrize("share", [1.0, 0.9, 0.48])
def test_a_video_that_is_cut_off_says_so(tmp_path, suffix, code, share):
    path = tmp_path / f"cut{suffix}"
    opened(path, code).release()
    stored = path.read_bytes()
    end = declared_end(path)
    assert end.declared_bytes == end.present_bytes == len(stored)
    path.write_bytes(stored[: int(len(stored) * share)])
    if share < 1 and suffix in (".mp4", ".mov"):  # their index comes last
        for read in (read_clip, lambda path: open_source(str(path))):
            with pytest.raises(UnreadableClip, match=r"only \d+% of the file is there"):
                read(path)
        return
    is_cut = share < 1
    assert any("of 1.6 s can be decoded" in note for note in read_clip(path).notes) == is_cut
    [finding] = file_end(read_clip(path))
    assert finding.verdict == ("fault" if is_cut else "fine")
    notes = open_source(str(path)).notes
    assert any("of the file is there" in note for note in notes) == is_cut


@pytest.mark.parametrize("suffix", [".mkv", ".avi"])
def test_a_video_that_is_still_being_written_says_so(tmp_path, suffix):
    written, copied = tmp_path / f"written{suffix}", tmp_path / f"copied{suffix}"
    writer = cv2.VideoWriter(str(written), cv2.VideoWriter_fourcc(*"MJPG"), 25, (640, 480))
    for frame in np.random.default_rng(0).integers(0, 255, (10, 480, 640, 3), np.uint8):
        writer.write(frame)  # noise fills the writer's buffer
    copied.write_bytes(written.read_bytes())
    writer.release()
    open_end = "The file does not declare where it ends"
    assert any(open_end in note for note in read_clip(copied).notes)
    assert not any(open_end in note for note in read_clip(written).notes)


@pytest.mark.parametrize("head", [b"\x1aE\xdf\xa3", b"RIFF\x08\0\0\0AVI ", b"\0\0\0\x18ftyp"])
def test_a_header_that_ends_early_is_a_missing_end(tmp_path, head):
    path = tmp_path / "clip.mkv"
    path.write_bytes(head)
    assert declared_end(path).note() is not None
    path.write_bytes(b"else")
    assert declared_end(path) is None
