import pytest

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.recordings.listing import clips_in


def test_recordings_are_known_files_and_folders_of_images(tmp_path):
    for name in ("b.npy", "a.MP4", "c.txt", ".hidden.npy"):
        (tmp_path / name).write_bytes(b"")
    (tmp_path / "frames").mkdir()
    (tmp_path / "frames" / "0.png").write_bytes(b"")
    (tmp_path / "notes").mkdir()
    assert [one.name for one in clips_in(tmp_path)] == ["a.MP4", "b.npy", "frames"]


def test_a_folder_without_recordings_is_refused(tmp_path):
    with pytest.raises(UnreadableClip) as error:
        clips_in(tmp_path)
    assert str(error.value) == (
        f"{tmp_path}: holds no recording, expected .npy, .npz, .mp4, .avi, .mov, .mkv or folders "
        f"of images; give the folder they lie in."
    )


def test_a_missing_folder_is_refused(tmp_path):
    with pytest.raises(UnreadableClip, match="no such folder; give the one your recordings lie in"):
        clips_in(tmp_path / "nowhere")
