"""A server's uploads live as long as the server, and no server touches those of another."""

import os
import signal
import subprocess
import sys

import pytest

from app.cache_folder import LOCK, PREFIX, VARIABLE, own_cache_folder

pytest.importorskip("fcntl", reason="folders are locked where the system can")

SERVER = """
import sys, time
from pathlib import Path
from app.cache_folder import own_cache_folder
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


def test_a_live_servers_folder_is_left_alone(server, tmp_path):
    _, theirs = server
    with own_cache_folder(tmp_path) as ours:
        assert ours != theirs
    assert (theirs / "abc" / "clip.npz").read_bytes() == b"PK"


def test_a_dead_servers_folder_is_removed_at_the_next_start(server, tmp_path):
    process, theirs = server
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert (theirs / "abc" / "clip.npz").exists()
    with own_cache_folder(tmp_path) as ours:
        assert sorted(tmp_path.iterdir()) == [ours]


def test_what_is_no_abandoned_folder_is_left_alone(tmp_path):
    (tmp_path / f"{PREFIX}new").mkdir()  # its server has not locked it yet
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / LOCK).write_bytes(b"")
    (tmp_path / f"{PREFIX}link").symlink_to(tmp_path / "other")
    before = sorted(tmp_path.iterdir())
    with own_cache_folder(tmp_path):
        pass
    assert sorted(tmp_path.iterdir()) == before
    assert (tmp_path / "other" / LOCK).exists()
