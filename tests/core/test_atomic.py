"""A file is replaced whole or stays as it was."""

import errno
import stat
import subprocess
import sys

import pytest

from geotlm_lm.core.atomic import only_writer, replacing, write_text_atomically


def test_text_comes_back_whatever_its_letters(tmp_path):
    path = tmp_path / "folder" / "text.txt"
    write_text_atomically(path, "17 \N{DEGREE SIGN}\n")
    assert path.read_text(encoding="utf-8") == "17 \N{DEGREE SIGN}\n"


def test_the_old_file_stands_until_the_new_one_is_whole(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(b"old")
    with replacing(path) as stream:
        stream.write(b"new")
        stream.flush()
        assert path.read_bytes() == b"old"
    assert path.read_bytes() == b"new"


@pytest.mark.parametrize("error", [OSError, KeyboardInterrupt])
def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, error):
    path = tmp_path / "file"
    path.write_bytes(b"old")

    def write_half():
        with replacing(path) as stream:
            stream.write(b"half")
            raise error

    with pytest.raises(error):
        write_half()
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_others_may_read_what_was_written(tmp_path):
    write_text_atomically(tmp_path / "file", "x")
    assert stat.S_IMODE((tmp_path / "file").stat().st_mode) == 0o644


def test_one_writer_at_a_time(tmp_path):
    path = tmp_path / "folder" / "file"
    with only_writer(path) as first, only_writer(path) as second:
        assert (first, second) == (True, False)
    with only_writer(path) as third:
        assert third
    assert list(path.parent.iterdir()) == []


def test_another_process_is_told_that_it_is_not_alone(tmp_path):
    code = (
        "import sys; from pathlib import Path; from geotlm_lm.core.atomic import only_writer\n"
        "with only_writer(Path(sys.argv[1])) as alone: print(alone)"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "file")]
    with only_writer(tmp_path / "file"):
        told = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert told == "False\n"


@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError])
def test_whoever_stops_in_an_error_leaves_the_way_free(tmp_path, error):
    def stop():
        with only_writer(tmp_path / "file"):
            raise error

    with pytest.raises(error):
        stop()
    with only_writer(tmp_path / "file") as is_alone:
        assert is_alone


def test_where_nothing_can_be_locked_everybody_is_the_only_writer(tmp_path, monkeypatch):
    def acquire(*_, **__):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr("filelock.BaseFileLock.acquire", acquire)
    with only_writer(tmp_path / "file") as first, only_writer(tmp_path / "file") as second:
        assert first
        assert second
