"""The folder that is served lists recordings alone, and nothing outside it can be named."""

import os
from pathlib import Path

import pytest

from app import recordings_folder
from app.recordings_folder import RecordingsFolder
from app.sources import Sources
from app.uploads import Uploads
from geotlm_lm import GeoTLMError


@pytest.fixture
def root(tmp_path):
    root = tmp_path / "served"
    (root / "day 1" / "frames").mkdir(parents=True)
    (root / ".hidden").mkdir()
    for name in ("b.MOV", "a.npz", "notes.txt", "day 1/c.avi", ".d.npy", ".hidden/e.npy"):
        (root / name).write_bytes(b"12345")
    for number in range(3):
        (root / "day 1" / "frames" / f"{number}.png").write_bytes(b"12")
    (tmp_path / "private.npz").write_bytes(b"1")
    return root


def names(root):
    return {one.name: (one.kind, one.size_bytes) for one in RecordingsFolder(root).listing()[0]}


def test_recordings_are_listed_by_name_kind_and_size(root):
    assert names(root) == {
        "a.npz": ("npz", 5),
        "b.MOV": ("mov", 5),
        "day 1/c.avi": ("avi", 5),
        "day 1/frames": ("images", 6),
    }


def test_every_listed_name_is_found_and_lies_in_the_folder(root):
    for name in names(root):
        assert RecordingsFolder(root).path_of(name) == root / name


def test_links_pipes_and_what_lies_behind_them_are_neither_listed_nor_found(root):
    before = names(root)
    (root / "link.npz").symlink_to(root.parent / "private.npz")
    (root / "up").symlink_to(root.parent)
    (root / "inside.npz").symlink_to(root / "a.npz")
    os.mkfifo(root / "pipe.npy")
    (root / "linked").mkdir()
    for number in range(2):
        (root / "linked" / f"{number}.png").symlink_to(root.parent / "private.npz")
    assert names(root) == before
    for name in (
        "link.npz",
        "up/private.npz",
        "inside.npz",
        "pipe.npy",
        "linked",
        "up/served/a.npz",
    ):
        with pytest.raises(GeoTLMError, match="^There is no recording "):
            RecordingsFolder(root).path_of(name)


@pytest.mark.parametrize(
    "name",
    ["../private.npz", "./a.npz", "day 1/../a.npz", "", "/", ".hidden/e.npy", ".d.npy", "a.npz/",
     "notes.txt", "day 1", "//a.npz", "a.npz\0"],
)  # fmt: skip
def test_what_is_not_listed_is_refused_in_one_sentence(root, name):
    with pytest.raises(GeoTLMError) as caught:
        RecordingsFolder(root).path_of(name)
    assert str(caught.value) == (
        f"There is no recording {name!r}; the tool recordings lists the names there are."
    )


def test_a_folder_that_may_not_be_read_and_a_name_that_is_no_text_are_left_out(root, monkeypatch):
    before, listdir = names(root), os.listdir
    (root / "closed").mkdir()
    (root / os.fsdecode(b"caf\xe9.npz")).write_bytes(b"12345")

    def guarded(place):
        if Path(place).name == "closed":
            raise PermissionError(place)
        return listdir(place)

    monkeypatch.setattr(os, "listdir", guarded)
    assert names(root) == before
    for name in ("closed", "closed/a.npz", os.fsdecode(b"caf\xe9.npz")):
        with pytest.raises(GeoTLMError, match="^There is no recording "):
            RecordingsFolder(root).path_of(name)


def test_an_upload_that_is_gone_is_told(tmp_path):
    uploads = Uploads(tmp_path)
    with (
        pytest.raises(GeoTLMError, match="^The upload is not on the server any more; send "),
        Sources(uploads).opened(str(tmp_path / "gone.npz")),
    ):
        pass


def test_more_than_can_be_listed_is_said_to_be_there(root, monkeypatch):
    monkeypatch.setattr(recordings_folder, "LISTED", 2)
    found, has_more = RecordingsFolder(root).listing()
    assert ([one.name for one in found], has_more) == (["a.npz", "b.MOV"], True)


def test_a_recording_that_is_too_long_is_told_before_it_is_read(root, monkeypatch):
    monkeypatch.setattr(recordings_folder, "UPLOAD_BYTES", 4)
    with pytest.raises(GeoTLMError, match="expected at most 0; cut the recording"):
        RecordingsFolder(root).path_of("a.npz")


def test_a_folder_that_is_not_there_is_told(tmp_path):
    with pytest.raises(GeoTLMError) as caught:
        RecordingsFolder(tmp_path / "none")
    assert str(caught.value) == (
        f"--recordings {tmp_path / 'none'} is no folder; give the folder that your recordings lie "
        f"in."
    )
