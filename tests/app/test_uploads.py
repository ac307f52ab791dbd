"""A program names what it sent, in any of the ways it can; everything else is refused."""

import base64
import io

import numpy as np
import pytest

from app import uploads
from app.uploads import Uploads
from geotlm_lm import GeoTLMError

REFUSED = (
    "The clip is no upload; send the file itself, in Python by handle_file('clip.npz'), or as a "
    "data URI in base64."
)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "uploads" / "abc").mkdir(parents=True)
    (tmp_path / "uploads" / "abc" / "a clip.npz").write_bytes(b"PK\x03\x04")
    (tmp_path / "private.npz").write_bytes(b"PK\x03\x04")
    return tmp_path / "uploads"


def data_uri(stored, form="data:;base64"):
    return f"{form},{base64.b64encode(stored).decode()}"


def test_an_upload_is_found_by_path_by_address_and_as_the_client_sends_it(folder):
    path = str(folder / "abc" / "a clip.npz")
    address = f"http://127.0.0.1:7860/gradio_api/file={path.replace(' ', '%20')}"
    sent = {"path": path, "meta": {"_type": "gradio.FileData"}}
    assert {Uploads(folder).path_of(one) for one in (path, address, sent)} == {path}


@pytest.mark.parametrize(
    "trick",
    [
        "private.npz",
        "../private.npz",
        "abc/../../private.npz",
        "/etc/passwd",
        "file:///etc/passwd",
        "http://127.0.0.1:7860/gradio_api/file=/etc/passwd",
        "http://127.0.0.1:7860/gradio_api/file=../private.npz",
        "http://127.0.0.1:7860/gradio_api/file=%2e%2e/private.npz",
        "https://example.com/clip.npz",
        "a\0b",
        "x" * 100_000,
        "",
        None,
        7,
        [],
        {"path": None},
        {"path": {"path": "private.npz"}},
        {},
    ],
    ids=lambda trick: repr(trick)[:40],
)
def test_nothing_else_on_the_machine_is_opened(folder, trick, monkeypatch):
    monkeypatch.chdir(folder.parent)
    with pytest.raises(GeoTLMError) as caught:
        Uploads(folder).path_of(trick)
    assert str(caught.value) == REFUSED


def test_a_link_out_of_the_folder_is_refused(folder):
    (folder / "abc" / "link.npz").symlink_to(folder.parent / "private.npz")
    with pytest.raises(GeoTLMError, match="^The clip is no upload"):
        Uploads(folder).path_of(str(folder / "abc" / "link.npz"))


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
        with Uploads(folder).unpacked(data_uri(stored, "data:a/b;x=../y;base64")) as path:
            assert (path.suffix, path.read_bytes()) == (suffix, stored)
            assert path.is_relative_to(folder)
        assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize(
    ("uri", "said"),
    [
        (
            "data:application/zip,PK",
            "The clip's data URI is not in base64; send 'data:;base64,' and the file in base64.",
        ),
        ("data:;base64,PK*", "The clip's data URI is cut off or no base64; send the whole file."),
        (
            "data:;base64,\u00e4",
            "The clip's data URI is cut off or no base64; send the whole file.",
        ),
        (
            "data:;base64," + "A" * (3 * 2**20),
            "The clip is 2 MiB long, expected at most 1 inside a message; upload it and send its "
            "address.",
        ),
    ],
    ids=["plain", "no base64", "no ascii", "too long"],
)
def test_a_message_that_holds_no_recording_is_told(folder, monkeypatch, uri, said):
    monkeypatch.setattr(uploads, "INLINE_BYTES", 2**20)
    with pytest.raises(GeoTLMError) as caught, Uploads(folder).unpacked(uri):
        pytest.fail("it was opened")
    assert str(caught.value) == said
