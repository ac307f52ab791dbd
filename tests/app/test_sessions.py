"""Sessions are light and leave no files; a server's uploads live as long as it, and no longer."""

import os
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest
from gradio.state_holder import SessionState

from app import sessions
from app.__main__ import PREFIX, VARIABLE, own_cache_folder
from app.sessions import LightSession, LightSessions, SessionFiles, remove_seen
from tests.app.fakes import FakeAnswerer, load_clip


def test_a_session_shows_what_the_toolkits_own_does(page):
    light, own = page.app.state_holder["a visitor"], SessionState(page)
    assert isinstance(light, LightSession)
    assert light.config_values == {}
    assert list(light.components) == list(own.components)


def test_what_is_changed_for_one_visitor_is_not_for_another(page):
    page.state_session_capacity = 10
    held = LightSessions(page)
    key = next(one for one, block in page.blocks.items() if type(block).__name__ == "Textbox")
    held["one"]._update_value_in_config(key, "typed")
    values = {
        name: [part["props"].get("value") for part in held[name].components if part["id"] == key]
        for name in ("one", "other")
    }
    assert values["one"] == ["typed"]
    assert values["other"] != ["typed"]
    assert list(held["one"].config_values) == [key]


def test_what_the_visitor_has_open_who_was_away_longest_is_closed_first(page, recordings):
    page.state_session_capacity = 10
    held = LightSessions(page)
    shown = load_clip(FakeAnswerer(), str(recordings["dark"]))
    key = next(one for one, block in page.blocks.items() if type(block).__name__ == "State")
    for name in ("one", "other"):
        held[name][key] = shown
    held["one"]  # comes back
    assert held.let_go()
    assert [held[name][key] for name in ("one", "other")] == [shown, None]
    assert held.let_go()
    assert not held.let_go()


def stored(folder, name):
    path = folder / name / "clip.npz"
    path.parent.mkdir()
    path.write_bytes(b"PK")
    return str(path)


def visit(session):
    return SimpleNamespace(session_hash=session)


def test_uploads_go_with_the_last_session_that_holds_them(tmp_path):
    own, shared = stored(tmp_path, "own"), stored(tmp_path, "shared")
    files = SessionFiles()
    files.hold([own, shared], visit("first"))
    files.hold(shared, visit("second"))
    files.hold(None, visit("third"))
    files.drop(visit("first"))
    assert [one.name for one in tmp_path.iterdir()] == ["shared"]
    files.drop(visit("unknown"))
    files.drop(visit("second"))
    assert list(tmp_path.iterdir()) == []


def test_an_upload_that_is_told_of_after_the_end_goes_at_once(tmp_path, monkeypatch):
    files, now = SessionFiles(), time.time()
    files.drop(visit("first"))
    files.hold(stored(tmp_path, "late"), visit("first"))
    assert list(tmp_path.iterdir()) == []
    monkeypatch.setattr(sessions, "time", SimpleNamespace(time=lambda: now + 20))
    files.hold(stored(tmp_path, "back"), visit("first"))
    assert [one.name for one in tmp_path.iterdir()] == ["back"]


def test_a_live_picture_is_removed_once_it_was_seen(tmp_path, monkeypatch):
    part = SimpleNamespace(temp_files={stored(tmp_path, "seen"), str(tmp_path / "gone" / "x")})
    now = time.time()
    monkeypatch.setattr(sessions, "time", SimpleNamespace(time=lambda: now + 5))
    remove_seen(part)
    assert part.temp_files == {str(tmp_path / "seen" / "clip.npz")}
    monkeypatch.setattr(sessions, "time", SimpleNamespace(time=lambda: now + 15))
    remove_seen(part)
    assert (part.temp_files, list(tmp_path.iterdir())) == (set(), [])


SERVER = """
import sys, time
from pathlib import Path
from app.__main__ import own_cache_folder
with own_cache_folder(Path(sys.argv[1])) as folder:
    (folder / "abc").mkdir()
    (folder / "abc" / "clip.npz").write_bytes(b"PK")
    print(folder, flush=True)
    time.sleep(120)
"""


@pytest.fixture
def server(tmp_path):
    started = subprocess.Popen(
        [sys.executable, "-c", SERVER, str(tmp_path)], stdout=subprocess.PIPE, text=True
    )
    yield started, tmp_path / started.stdout.readline().strip()
    started.kill()
    started.wait()


def test_the_folder_is_told_to_the_toolkit_and_gone_in_the_end(tmp_path, monkeypatch):
    monkeypatch.setenv(VARIABLE, "before")
    with own_cache_folder(tmp_path) as folder:
        assert os.environ[VARIABLE] == str(folder)
        assert folder.stat().st_mode & 0o077 == 0
        (folder / "abc").mkdir()
        (folder / "abc" / "clip.npz").write_bytes(b"PK")
    assert os.environ[VARIABLE] == "before"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_a_live_servers_folder_is_left_alone_and_a_dead_ones_removed(server, tmp_path):
    process, theirs = server
    with own_cache_folder(tmp_path) as ours:
        assert ours != theirs
    assert (theirs / "abc" / "clip.npz").read_bytes() == b"PK"
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert (theirs / "abc" / "clip.npz").exists()
    with own_cache_folder(tmp_path) as ours:
        assert sorted(tmp_path.iterdir()) == [ours]


def test_what_is_no_abandoned_folder_is_left_alone(tmp_path):
    (tmp_path / f"{PREFIX}file").write_bytes(b"")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "kept").write_bytes(b"")
    (tmp_path / f"{PREFIX}link").symlink_to(tmp_path / "other")
    before = sorted(tmp_path.iterdir())
    with own_cache_folder(tmp_path):
        pass
    assert sorted(tmp_path.iterdir()) == before
    assert (tmp_path / "other" / "kept").exists()
