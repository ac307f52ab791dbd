"""Passages come out of packages' texts as they are read, once each, and from a user's own file."""

import io
import json
import tarfile

import pytest

from geotlm_lm.core.errors import MissingDependency, UsageError
from geotlm_lm.training import english
from geotlm_lm.training.english import (
    LONGEST,
    fetch,
    is_english,
    passages,
    passages_of,
    reader_of,
)

GLOSS = (
    "00055142 29 v 02 slip 0 slip_away 0 001 @ 01617210 v 0000 01 + 02 00 | "
    'move smoothly and easily; "The pen slipped from her hand"\n'
)
PAGE = """<html><head><title>The title of a page that is not read</title></head><body>
<h2>How do I turn it?</h2><p>Take the <b>knob</b>, and turn it to the left until it stops.</p>
<pre>this is the code that nobody wants to read at all</pre>
<p>Call <code>turn_left()</code> of the object in order to turn it to the left.</p></body></html>"""
MANUAL = """.SH DESCRIPTION
.B turn
shows the way in which the two \\fIfiles\\fR were turned.
.nf
this is the code that nobody wants to read at all
.fi
"""
ENTRY = """Slip \\Slip\\, v. i. [OE. slippen ["u].]
   1. To move along the surface of a thing without bounding,
      rolling, or stepping; to {slide}. --Addison.
      [1913 Webster] Slipper
"""
SAID = 'message= _ "Do not let the stone roll down to the left of us!"\nname=_"Stone"\n'


def read(name, text):
    return list(passages_of(reader_of(name)(text)))


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        (
            "./usr/share/wordnet/data.verb",
            GLOSS,
            'slip, slip away: move smoothly and easily; "the pen slipped from her hand"',
        ),
        (
            "./usr/share/doc/turn/index.html",
            PAGE,
            "how do i turn it? take the knob, and turn it to the left until it stops.",
        ),
        (
            "./usr/share/man/man1/turn.1.gz",
            MANUAL,
            "turn shows the way in which the two files were turned.",
        ),
        (
            "./usr/share/dictd/gcide.dict.dz",
            ENTRY,
            "slip, v. i. 1. to move along the surface of a thing without bounding, rolling, or "
            "stepping; to slide.",
        ),
        (
            "./usr/share/games/data/campaigns/stone/one.cfg",
            SAID,
            "do not let the stone roll down to the left of us!",
        ),
    ],
)
def test_of_each_form_the_prose_is_left(name, text, expected):
    assert read(name, text) == [expected]


@pytest.mark.parametrize(
    "name",
    ["./usr/share/doc/turn/copyright", "./usr/share/help/de/turn.page", "./usr/bin/turn", "a.png"],
)
def test_files_in_other_languages_and_of_other_kinds_are_not_read(name):
    assert reader_of(name) is None


@pytest.mark.parametrize(
    "passage",
    [
        "too short to be of use.",
        "for (i = 0; i < 10; i++) { turn the thing to the left; }",
        "see https://example.org for all of the ways in which it turns",
        "the ways of it: 11 21 34 45 51 62 75 83 91 10 11 12 13 14 15",
        "der stein dreht sich langsam gegen den uhrzeigersinn nach links",
        "the word for it was d\u00e9j\u00e0 vu, as they say in the south of france",
    ],
)
def test_what_is_no_english_prose_is_left_out(passage):
    assert not is_english(passage)


def test_a_long_paragraph_is_cut_where_sentences_end():
    sentence = "The stone that lies at the top of the hill rolls down to the left of it."
    parts = list(passages_of(" ".join([sentence] * 30)))
    assert len(parts) > 1
    assert all(len(part) <= LONGEST and part.endswith("left of it.") for part in parts)
    assert " ".join(parts) == " ".join([sentence.lower()] * 30)


def test_a_question_at_the_end_of_a_text_is_kept():
    question = "Which way does the stone at the top of the hill roll?"
    assert list(passages_of(question)) == [question.lower()]


@pytest.fixture
def programs(tmp_path, monkeypatch):
    """Stand in for Debian's: packages are plain archives, and only one name is known."""
    home = tmp_path / "bin"
    home.mkdir()
    with tarfile.open(home / "known.tar", "w") as archive:
        for name, text in (("index", PAGE), ("again", PAGE), ("ja/index", PAGE)):
            member = tarfile.TarInfo(f"./usr/share/doc/known/{name}.html")
            member.size = len(text.encode())
            archive.addfile(member, io.BytesIO(text.encode()))

    def write(name, script):
        (home / name).write_text(f"#!/bin/sh\n{script}\n")
        (home / name).chmod(0o755)

    write(
        "apt-get",
        f'test "$3" = known && exec /bin/cp {home}/known.tar known_1%3a2_all.deb\n'
        'echo "E: Unable to locate package $3" >&2; exit 100',
    )
    write("dpkg-deb", 'exec /bin/cat "$2"')
    monkeypatch.setenv("PATH", str(home))
    monkeypatch.setattr(english, "PACKAGES", {"known": "GPL-2+", "unknown": "MIT"})
    return write


def test_packages_that_are_known_are_fetched_once_and_told_of(tmp_path, programs):
    path = fetch(tmp_path / "english")
    assert passages(path) == [
        "how do i turn it? take the knob, and turn it to the left until it stops."
    ]
    record = json.loads(path.with_suffix(".json").read_text())
    size = path.stat().st_size
    assert record == {
        "known": {"version": "1:2", "licence": "GPL-2+", "passages": 1, "bytes": size}
    }
    programs("apt-get", "exit 1")
    assert fetch(tmp_path / "english") == path
    path.unlink()
    english.PACKAGES.pop("unknown")
    assert fetch(tmp_path / "english").stat().st_size == size


def test_without_packages_one_is_told_to_give_texts(tmp_path, programs, monkeypatch):
    end = (
        f"run `apt-get update` on a Debian with a network, or give texts of your own, one passage "
        f"a line, in {tmp_path / 'english.txt'}."
    )
    programs("apt-get", 'echo "E: Failed to fetch it" >&2; exit 100')
    with pytest.raises(MissingDependency, match="not found .E: Failed to fetch it.; run") as failed:
        fetch(tmp_path)
    assert str(failed.value).endswith(end)
    programs("apt-get", 'echo "E: Unable to locate package $3" >&2; exit 100')
    with pytest.raises(MissingDependency, match="apt-get knows none of the packages"):
        fetch(tmp_path)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(MissingDependency, match="apt-get does not run"):
        fetch(tmp_path)
    assert not [*tmp_path.glob("english.*"), *tmp_path.glob(".english*")]


def test_a_broken_package_and_an_unreadable_file_are_told(tmp_path, programs):
    (tmp_path / "packages").mkdir()
    (tmp_path / "packages" / "known_1_all.deb").write_bytes(b"half")
    with pytest.raises(UsageError, match="cannot be unpacked"):
        fetch(tmp_path)
    (tmp_path / "own.txt").write_bytes(b"\xff\xfe")
    with pytest.raises(UsageError, match="cannot be read as passages"):
        passages(tmp_path / "own.txt")
