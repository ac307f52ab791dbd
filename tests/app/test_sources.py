"""A tool is given what was sent or is listed, in any of the ways there are; nothing else."""

import base64
import io
import os
import re
from pathlib import Path

import numpy as np
import pytest

from app import sources
from app.sources import Sources
from geotlm_lm import GeoTLMError


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "uploads" / "abc").mkdir(parents=True)
    (tmp_path / "uploads" / "abc" / "a clip.npz").write_bytes(b"PK\x03\x04")
    (tmp_path / "private.npz").write_bytes(b"PK\x03\x04")
    return tmp_path / "uploads"


def data_uri(stored, form="data:;base64"):
    return f"{form},{base64.b64encode(stored).decode()}"


def test_an_upload_is_found_by_path_by_address_and_as_the_client_sends_it(folder):
    path = folder / "abc" / "a clip.npz"
    address = f"http://127.0.0.1:7860/gradio_api/file={str(path).replace(' ', '%20')}"
    assert Sources(folder).is_upload({"path": str(path), "meta": {"_type": "gradio.FileData"}})
    for given in (str(path), address):
        with Sources(folder).opened(given) as opened:
            assert opened == path


TRICKS = [
    *("private.npz", "../private.npz", "abc/../../private.npz"),
    *("/etc/passwd", "file:///etc/passwd"),
    "http://127.0.0.1:7860/gradio_api/file=/etc/passwd",
    "http://127.0.0.1:7860/gradio_api/file=../private.npz",
    "http://127.0.0.1:7860/gradio_api/file=%2e%2e/private.npz",
    *("https://example.com/clip.npz", "a\0b", "x" * 100_000, "", None, 7, [], {}),
    *({"path": None}, {"path": {"path": "private.npz"}}),
]


def test_nothing_else_on_the_machine_is_an_upload(folder, monkeypatch):
    monkeypatch.chdir(folder.parent)
    (folder / "abc" / "link.npz").symlink_to(folder.parent / "private.npz")
    for trick in [*TRICKS, str(folder / "abc" / "link.npz")]:
        assert not Sources(folder).is_upload(trick), trick


def test_a_name_does_not_lead_into_the_folder_that_the_server_was_started_in(folder, monkeypatch):
    monkeypatch.chdir(folder.parent)
    served = Sources(folder, folder)
    for name in ("private.npz", "no/private.npz", "no/such/private.npz"):
        with pytest.raises(GeoTLMError, match="^There is no recording "), served.opened(name):
            pass


def test_a_recording_inside_a_message_is_named_after_its_kind_and_gone_once_read(folder):
    beginnings = {
        ".avi": b"RIFF\0\0\0\0AVI LIST",
        ".mp4": b"\0\0\0\x1cftypisom",
        ".mkv": b"\x1a\x45\xdf\xa3",
        ".gif": b"GIF89a",
        ".bag": b"#ROSBAG V2.0\n",
        ".npz": b"PK\x03\x04",
        ".tif": b"II*\0\x08\0\0\0",
        ".tiff": b"MM\0*\0\0\0\x08",
    }
    array = io.BytesIO()
    np.save(array, np.zeros(3))
    before = sorted(folder.rglob("*"))
    for suffix, stored in (beginnings | {".npy": array.getvalue()}).items():
        with Sources(folder).opened(data_uri(stored, "data:a/b;x=../y;base64")) as path:
            assert (path.suffix, path.read_bytes()) == (suffix, stored)
            assert path.is_relative_to(folder)
        assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize(
    ("uri", "sentence"),
    [
        ("data:application/zip,PK", "The clip's data URI is not in base64; send "),
        ("data:;base64,PK*", "The clip's data URI is cut off or no base64; send "),
        ("data:;base64,\u00e4", "The clip's data URI is cut off or no base64; send "),
        ("data:;base64," + "A" * 3000, "The clip is 0 MiB long, expected at most 0 inside a "),
    ],
)
def test_a_message_that_holds_no_recording_is_told(folder, monkeypatch, uri, sentence):
    monkeypatch.setattr(sources, "INLINE_BYTES", 2**10)
    with pytest.raises(GeoTLMError, match=f"^{sentence}"), Sources(folder).opened(uri):
        pytest.fail("it was opened")


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


def served(root):
    return Sources(root.parent / "uploads", root)


def path_of(root, name):
    with served(root).opened(name) as path:
        return path


def names(root):
    listed = served(root).listing()["recordings"]
    return {one["name"]: (one["kind"], one["size_bytes"]) for one in listed}


def test_recordings_are_listed_by_name_kind_and_size_and_found(root):
    assert names(root) == {
        "a.npz": ("npz", 5),
        "b.MOV": ("mov", 5),
        "day 1/c.avi": ("avi", 5),
        "day 1/frames": ("images", 6),
    }
    for name in names(root):
        assert path_of(root, name) == root / name


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
    reached = ("up/private.npz", "up/served/a.npz")
    for name in ("link.npz", "inside.npz", "pipe.npy", "linked", *reached):
        with pytest.raises(GeoTLMError, match="^There is no recording "):
            path_of(root, name)


UNLISTED = ["../private.npz", "./a.npz", "day 1/../a.npz", "", ".hidden/e.npy", ".d.npy", "a.npz/"]


@pytest.mark.parametrize("name", [*UNLISTED, "notes.txt", "day 1", "a.npz\0"])
def test_what_is_not_listed_is_refused(root, name):
    listed = "|".join(map(re.escape, names(root)))
    ends = f"lists the names there are[.]|did you mean '({listed})'[?]"
    with pytest.raises(GeoTLMError, match=f"^There is no recording .*; .*({ends})$"):
        path_of(root, name)


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
            path_of(root, name)


def test_an_upload_that_is_gone_is_told(tmp_path):
    with pytest.raises(GeoTLMError, match="^The upload is not on the server any more; send "):
        path_of(tmp_path, str(tmp_path.parent / "uploads" / "gone.npz"))


def test_more_than_can_be_listed_is_said_to_be_there(root, monkeypatch):
    monkeypatch.setattr(sources, "LISTED", 2)
    assert (list(names(root)), served(root).listing()["has_more"]) == (["a.npz", "b.MOV"], True)


def test_a_recording_that_is_too_long_is_told_before_it_is_read(root, monkeypatch):
    monkeypatch.setattr(sources, "UPLOAD_BYTES", 4)
    with pytest.raises(GeoTLMError, match="expected at most 0; cut the recording"):
        path_of(root, "a.npz")


def test_a_folder_that_is_not_there_is_told(tmp_path):
    with pytest.raises(GeoTLMError, match="^--recordings .*none is no folder; give the folder "):
        Sources(tmp_path, tmp_path / "none")
