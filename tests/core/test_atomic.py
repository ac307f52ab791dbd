"""A file is replaced whole or stays as it was."""

import stat

import pytest

from geotlm_lm.core import atomic
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
    path = tmp_path / "file"
    with only_writer(path) as first, only_writer(path) as second:
        assert (first, second) == (True, False)
    with only_writer(path) as third:
        assert third


def test_a_file_taken_away_by_the_writer_before_is_made_anew(tmp_path, monkeypatch):
    path, claim = tmp_path / "file", atomic.fcntl.flock
    taken = []

    def late(stream, how):
        claim(stream, how)
        if not taken:
            taken.append(path.unlink())

    monkeypatch.setattr(atomic.fcntl, "flock", late)
    with only_writer(path) as is_alone:
        assert is_alone
        assert path.exists()


def test_without_claims_everybody_is_the_only_writer(tmp_path, monkeypatch):
    monkeypatch.setattr(atomic, "fcntl", None)
    with only_writer(tmp_path / "file") as first, only_writer(tmp_path / "file") as second:
        assert first
        assert second
