from pathlib import Path

import pytest

from geotlm_lm.recordings.listing import clips_in, skipped_in
from tests.recordings.test_read import refusal


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
