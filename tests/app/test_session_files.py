"""What a visitor uploaded goes with the visitor, and a live picture once it was seen."""

import os
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from app.cache_folder import own_cache_folder  # noqa: E402
from app.session_files import SessionFiles, remove_seen  # noqa: E402

from app import session_files, ui  # noqa: E402
from tests.app.browser import NAME, SHOWN  # noqa: E402
from tests.app.fakes import FakeAnswerer  # noqa: E402
from tests.app.test_browser_camera import TEXT, start_camera  # noqa: E402


def stored(folder, name):
    path = folder / name / "clip.npz"
    path.parent.mkdir()
    path.write_bytes(b"PK")
    return str(path)


def test_uploads_go_with_the_last_session_that_holds_them(tmp_path):
    own, shared = stored(tmp_path, "own"), stored(tmp_path, "shared")
    files = SessionFiles()
    files.hold("first", [own, shared])
    files.hold("second", shared)
    files.hold("third", None)
    files.drop("first")
    assert [one.name for one in tmp_path.iterdir()] == ["shared"]
    files.drop("unknown")
    files.drop("second")
    assert list(tmp_path.iterdir()) == []


def test_an_upload_that_is_told_of_after_the_end_goes_at_once(tmp_path, monkeypatch):
    files, now = SessionFiles(), time.time()
    files.drop("first")
    files.hold("first", stored(tmp_path, "late"))
    assert list(tmp_path.iterdir()) == []
    monkeypatch.setattr(session_files, "time", SimpleNamespace(time=lambda: now + 20))
    files.hold("first", stored(tmp_path, "back"))
    assert [one.name for one in tmp_path.iterdir()] == ["back"]


def test_a_live_picture_is_removed_once_it_was_seen(tmp_path, monkeypatch):
    part = SimpleNamespace(temp_files={stored(tmp_path, "seen"), str(tmp_path / "gone" / "x")})
    now = time.time()
    monkeypatch.setattr(session_files, "time", SimpleNamespace(time=lambda: now + 5))
    remove_seen(part)
    assert part.temp_files == {str(tmp_path / "seen" / "clip.npz")}
    monkeypatch.setattr(session_files, "time", SimpleNamespace(time=lambda: now + 15))
    remove_seen(part)
    assert (part.temp_files, list(tmp_path.iterdir())) == (set(), [])


@pytest.fixture
def page(camera_browser, tmp_path):
    """The page in a browser with a camera, and the folder it keeps its files in."""
    with own_cache_folder(tmp_path) as folder:
        served = ui.build(FakeAnswerer())
        camera_browser.open(ui.launch(served))
        yield camera_browser, folder
        served.close()


def files_in(folder):
    return [Path(home) / name for home, _, names in os.walk(folder) for name in names]


def test_an_upload_is_gone_when_its_page_was_closed(page, recordings):
    browser, folder = page
    browser.upload("Recording", recordings["dark"])
    browser.wait_for(f"{SHOWN} && {NAME}.innerText == 'dark.npy'")
    assert [one.name for one in files_in(folder)].count("dark.npy") == 1
    browser.call("Page.navigate", url="about:blank")
    until = time.monotonic() + 60
    while any(one.name == "dark.npy" for one in files_in(folder)):
        assert time.monotonic() < until, "the upload is still there"
        time.sleep(0.5)


def test_live_pictures_do_not_pile_up(page, monkeypatch):
    browser, folder = page
    monkeypatch.setattr(session_files, "SHOWN_S", 0.5)
    before = len(files_in(folder))
    start_camera(browser)
    browser.wait_for(f"/· [4-9][0-9] frames/.test({TEXT})", seconds=120)
    assert len(files_in(folder)) - before < 15
