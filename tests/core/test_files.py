"""A file is replaced whole or stays as it was."""

import errno
import os
import stat

import pytest

from geotlm_lm.core.errors import Unwritten
from geotlm_lm.core.files import append_text, only_writer, replacing, write_text_atomically
from tests.full_disk import full_disk


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


@pytest.mark.skipif(os.name == "nt", reason="Windows has no umask")
@pytest.mark.parametrize("umask", [0o022, 0o077])
def test_who_may_read_what_was_written_is_the_umasks_to_say(tmp_path, umask):
    before = os.umask(umask)
    try:
        write_text_atomically(tmp_path / "file", "x")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "file").stat().st_mode) == 0o666 & ~umask


def test_content_is_on_disk_before_it_has_its_name_and_the_name_after(tmp_path, monkeypatch):
    done, sync, replace = [], os.fsync, os.replace

    def synced(handle):
        done.append("folder" if stat.S_ISDIR(os.fstat(handle).st_mode) else "file")
        sync(handle)

    def replaced(*paths):
        done.append("name")
        replace(*paths)

    monkeypatch.setattr("os.fsync", synced)
    monkeypatch.setattr("os.replace", replaced)
    write_text_atomically(tmp_path / "file", "x")
    assert done == ["file", "name", "folder"]


def test_names_as_long_as_a_file_system_takes_are_written(tmp_path):
    path = tmp_path / ("\N{DEGREE SIGN}" * 120 + ".csv")
    write_text_atomically(path, "x")
    assert [one.name for one in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("write", [write_text_atomically, append_text])
def test_where_nothing_may_be_written_the_file_is_told(tmp_path, write):
    (tmp_path / "file").touch()
    path = tmp_path / "file" / "below"
    with pytest.raises(Unwritten, match="^.*/file/below: cannot be written \\(.*; make room"):
        write(path, "x")


def test_a_text_that_does_not_fit_behind_another_is_left_out_whole(tmp_path):
    path = tmp_path / "file"
    append_text(path, "first\n")
    with full_disk(10), pytest.raises(Unwritten):
        append_text(path, "second\n")
    assert path.read_text() == "first\n"
    append_text(path, "third\n")
    assert path.read_text() == "first\nthird\n"


def test_one_writer_at_a_time(tmp_path):
    path = tmp_path / "folder" / "file"
    with only_writer(path) as first, only_writer(path) as second:
        assert (first, second) == (True, False)
    assert list(path.parent.iterdir()) == []


def test_a_writer_that_stops_in_an_error_leaves_the_way_free(tmp_path):
    with pytest.raises(KeyboardInterrupt), only_writer(tmp_path / "file"):
        raise KeyboardInterrupt
    with only_writer(tmp_path / "file") as is_alone:
        assert is_alone


def test_where_nothing_can_be_locked_everybody_is_the_only_writer(tmp_path, monkeypatch):
    def acquire(*_, **__):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr("filelock.BaseFileLock.acquire", acquire)
    with only_writer(tmp_path / "file") as first, only_writer(tmp_path / "file") as second:
        assert first
        assert second
