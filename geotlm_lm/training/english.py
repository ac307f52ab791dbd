"""English to learn from before any question is: passages of free texts that Debian packages hold.

Dictionaries, help, manuals and the dialogues of games, fetched by `apt-get`. No text of theirs is
part of this repository; what a folder holds, and under which licence, its `english.json` tells.
"""

from __future__ import annotations

import gzip
import json
import os
import re
import subprocess
import tarfile
import tempfile
from collections.abc import Callable, Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

from geotlm_lm.core.errors import MissingDependency, UsageError, first_line
from geotlm_lm.core.files import replacing, write_text_atomically
from geotlm_lm.core.process import Progress, silent
from geotlm_lm.query.reader import cleaned_text

_LICENCES = {
    "WordNet": "wordnet-base",
    "public domain": "dict-jargon dict-devil sqlite3-doc",
    "BSD-3, of collected sayings": "fortunes fortunes-min",
    "GFDL-1.1+": "dict-foldoc",
    "GFDL-1.2+": "gimp-help-en",
    "CC-BY-SA-3.0": "gnome-user-docs gnome-devel-docs evolution-common",
    "GPL-2+ or CC-BY-SA-3.0": "debian-handbook",
    "GPL-1+": "dict-gcide",
    "GPL-1+ or Artistic": "perl-doc",
    "GPL-2": "git-doc installation-guide-amd64 r-doc-html",
    "GPL-2+": "debian-reference-en debian-policy developers-reference debian-history "
    "debian-edu-doc-en harden-doc aptitude-doc-en crawl-common "
    "wesnoth-1.16-did wesnoth-1.16-httt wesnoth-1.16-nr wesnoth-1.16-trow wesnoth-1.16-utbs",
    "GPL-3+": "endless-sky-data",
    "MPL-2.0": "libreoffice-help-en-us",
    "Apache-2.0": "apache2-doc",
    "BSD-3": "python-django-doc",
    "IPL-1.0 or EPL-2.0": "postfix-doc",
    "PostgreSQL": "postgresql-doc-15",
    "PSF-2": "python3.11-doc",
    "free, each page its own": "manpages",
    "free, unchanged terms": "debian-faq octave-doc",
}
PACKAGES = {name: licence for licence, names in _LICENCES.items() for name in names.split()}
"""Packages of Debian 12, and what their texts are free under."""


def fetch(folder: Path, progress: Progress = silent) -> Path:
    """Return the file of passages in a folder, one a line; make it where there is none.

    Packages are kept in a folder of their own beside it. One that the system's release of Debian
    does not know is left out; `english.json` tells which were read.

    Raises:
        MissingDependency: Without `apt-get` or a network.
    """
    path = folder / "english.txt"
    if path.is_file():
        return path
    record: dict[str, dict[str, str | int]] = {}
    seen: set[str] = set()
    with replacing(path) as stream:
        for done, name in enumerate(PACKAGES):
            progress(f"English, {name}", done, len(PACKAGES))
            package = _package(name, folder / "packages")
            if package is None:
                continue
            lines = [line for line in dict.fromkeys(_texts(package)) if line not in seen]
            seen.update(lines)
            written = stream.write("".join(f"{line}\n" for line in lines).encode())
            record[name] = {
                "version": unquote(package.name.split("_")[1]),
                "licence": PACKAGES[name],
                "passages": len(lines),
                "bytes": written,
            }
        if not seen:
            raise _missing(folder, "apt-get knows none of the packages")
        write_text_atomically(path.with_suffix(".json"), json.dumps(record, indent=1) + "\n")
    progress("English", len(PACKAGES), len(PACKAGES))
    return path


def passages(path: Path) -> list[str]:
    """Return the passages of a file that holds one a line."""
    try:
        lines = path.read_text(encoding="utf-8").split("\n")
    except (OSError, ValueError) as error:
        raise UsageError(
            f"{path}: cannot be read as passages ({first_line(error)}); give a file with one "
            f"passage a line in UTF-8."
        ) from error
    return [line for line in lines if line.strip()]


def _package(name: str, home: Path) -> Path | None:
    """Return a package's file, fetched if it is not there; none where its name is not known."""
    if kept := sorted(home.glob(f"{name}_*.deb")):
        return kept[-1]
    home.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory(dir=home) as work:
        command = ["apt-get", "download", "-q", name]
        plain = {**os.environ, "LC_ALL": "C"}
        try:
            ended = subprocess.run(command, cwd=work, env=plain, capture_output=True, text=True)
        except OSError as error:
            raise _missing(home.parent, f"apt-get does not run: {first_line(error)}") from error
        for package in Path(work).glob("*.deb"):
            if ended.returncode == 0:
                return package.replace(home / package.name)
    if re.search("Unable to locate|no installation candidate|Can't find a source", ended.stderr):
        return None
    reasons = [line for line in ended.stderr.splitlines() if line.startswith("E:")]
    raise _missing(home.parent, (reasons or [f"apt-get ended with {ended.returncode}"])[0])


def _missing(folder: Path, why: str) -> MissingDependency:
    return MissingDependency(
        f"English texts come from Debian's packages, which were not found ({why}); run `apt-get "
        f"update` on a Debian with a network, or give texts of your own, one passage a line, in "
        f"{folder / 'english.txt'}."
    )


def _texts(package: Path) -> Iterator[str]:
    """Yield the passages of a package; nothing of it is unpacked to disk."""
    command = ["dpkg-deb", "--fsys-tarfile", str(package)]
    try:
        with (
            subprocess.Popen(command, stdout=subprocess.PIPE) as unpacked,
            tarfile.open(fileobj=unpacked.stdout, mode="r|") as archive,
        ):
            for member in archive:
                reader = reader_of(member.name) if member.isfile() else None
                if reader is not None:
                    data = archive.extractfile(member).read()
                    data = gzip.decompress(data) if data[:2] == b"\x1f\x8b" else data
                    yield from passages_of(reader(data.decode("utf-8", "replace")))
    except (OSError, EOFError, tarfile.TarError) as error:
        raise UsageError(
            f"{package}: cannot be unpacked ({first_line(error)}); remove it, to have it fetched "
            f"again."
        ) from error


SHORTEST, LONGEST = 40, 600
"""Characters of a passage."""

_LETTERS = 0.88  # least share of letters and spaces; a table or code has fewer
_COMMON = 0.1  # least share of words that English is full of
_WORDS = (
    "a about all also an and any are as at be been but by can do for from had has have he her his "
    "how if in into is it its may more not of on one or other she so some such that the their them "
    "then there these they this to use was we what when where which who will with you your"
)
_FREQUENT = frozenset(_WORDS.split())
_REMAINS = re.compile(r"[][{}<>|\\_=~^#@$*`+]|https?:|www\.|::|\(\)|/\w+/|(^|\s)-\w|--\w|\.\w+/")
_PLAIN = str.maketrans("‘’“”–—−", "''\"\"---", "\u00ad\u200b")
_UNREAD = re.compile(
    r"[/._](ar|bg|ca|cs|da|de|el|es|eu|fa|fi|fr|gl|he|hr|hu|id|it|ja|ko|lt|lv|nb|nl|nn|no|pl|pt|ro"
    r"|ru|sk|sl|sr|sv|tr|uk|vi|zh)([-_@][\w@]+)?[/.]|(?i:changelog|copyright|licen[cs]e|legal|gfdl"
    r"|_sources|genindex|bookindex|/examples?/)"
)


def passages_of(text: str) -> Iterator[str]:
    """Yield the passages of a text whose paragraphs blank lines part, as the reader reads them.

    A heading that asks stays with what answers it; a long paragraph ends where a sentence does.
    """
    asked = ""
    for paragraph in re.split(r"\n\s*\n", text.translate(_PLAIN)):
        if re.search(r"\S {3,}\S", paragraph):  # columns
            continue
        plain = re.sub(r" +([,.;:?!)]+)(?= |$)", r"\1", cleaned_text(paragraph)).strip()
        plain = plain.lstrip("-,.;:) ")
        if plain.endswith("?") and len(plain) < 2 * SHORTEST and not asked:
            asked = f"{plain} "
            continue
        rest, asked = asked + plain, ""
        while rest:
            cut = len(rest)
            if cut > LONGEST:
                cut = 1 + max(rest.rfind(end, 0, LONGEST) for end in (". ", "? ", "! ", "; "))
            if is_english(rest[:cut]):
                yield rest[:cut]
            rest = rest[cut:].lstrip() if cut else ""
    if is_english(asked.strip()):
        yield asked.strip()


def is_english(passage: str) -> bool:
    """Tell whether a passage is English prose of a length, not code, mark-up or a table."""
    if not SHORTEST <= len(passage) <= LONGEST or not passage.isascii():
        return False
    words = re.findall(r"[a-z']+", passage)
    letters = sum(character.isalpha() or character == " " for character in passage)
    common = sum(word in _FREQUENT for word in words)
    is_prose = letters >= _LETTERS * len(passage) and common >= _COMMON * len(words)
    return is_prose and len(words) > 5 and _REMAINS.search(passage) is None


class _Page(HTMLParser):
    """Takes the paragraphs of HTML, DocBook or Mallard, without what is no prose."""

    skipped = re.compile(
        r"(head|script|style|pre|nav|header|footer|programlisting|screen|(cmd)?synopsis|math|svg"
        r"|select|button|table|legalnotice|bibliography)$"
    )
    breaks = re.compile(
        r"(p|br|div|li|d[ltd]|[uo]l|h\d|hr|body|blockquote|title|subtitle|desc|(sim|formal)?para"
        r"|listitem|item|term|section|sect\d|note|list|steps)$"
    )

    def __init__(self) -> None:
        super().__init__()
        self.depth = 0
        self.parts: list[str] = []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.depth += self.skipped.match(tag) is not None
        if self.breaks.match(tag):
            self.parts.append("\n\n")
        elif tag.startswith(("gui", "key")):
            self.parts.append(" ")

    def handle_endtag(self, tag: str) -> None:
        if self.depth and self.skipped.match(tag):
            self.depth -= 1
        if self.breaks.match(tag):
            self.parts.append("\n\n")

    def handle_data(self, data: str) -> None:
        if not self.depth:
            self.parts.append(re.sub(r"\s+", " ", data))


def _marked_up(text: str) -> str:
    page = _Page()
    page.feed(text)
    return "".join(page.parts)


def _glosses(text: str) -> str:
    """Return each meaning of WordNet as its words, what they mean, and examples."""
    entries = []
    for line in text.splitlines():
        fields, _, gloss = line.partition(" | ")
        names = fields.split()
        if gloss:
            words = names[4 : 4 + 2 * int(names[3], 16) : 2]
            plain = ", ".join(re.sub(r"\(\w+\)$", "", word) for word in words)
            entries.append(f"{plain.replace('_', ' ')}: {gloss}")
    return "\n\n".join(entries)


def _entries(text: str) -> str:
    """Return a dictionary's text without pronunciations, etymologies and names of sources."""
    text = re.sub(r"\[(1913 Webster|PJC|WordNet[^]]*)\].*$", "\n", text, flags=re.M)
    text = re.sub(r"\\[^\\\n]*\\|\([^()\n]*[?*`\"][^()\n]*\)|^\s*<[^>]*>", "", text, flags=re.M)
    for _ in range(2):  # brackets within brackets
        text = re.sub(r"\[[^][]*\]", "", text)
    text = re.sub(r"[{}]|--\s?[A-Z][^.\n]{0,30}(\.|$)(?=\s*\n)", "", text, flags=re.M)
    return re.sub(r"[ \t]+([,;.])", r"\1", text)


def _paragraphs(text: str) -> str:
    """Return a plain text, lines of signs alone taken for ends of paragraphs."""
    return re.sub(r"^\W+$", "\n", text, flags=re.M)


def _manual(text: str) -> str:
    """Return a manual page without the requests that set it."""
    is_set = r"^\.(nf|EX|Vb|TS|SY)\b.*?^\.(fi|EE|Ve|TE|YS)\b.*?$"
    text = re.sub(is_set, ".PP", text, flags=re.M | re.S)
    text = re.sub(
        r"^\.(B|I|BR|RB|IR|RI|BI|IB|SM|SB) (.*)$",
        lambda match: match[2].replace('"', ""),
        text,
        flags=re.M,
    )
    text = re.sub(r"^\.(PP|P|LP|TP|IP|SH|SS|RS|RE)\b.*$", "\n", text, flags=re.M)
    text = re.sub(r"^[.'].*\n", "", text, flags=re.M)
    text = re.sub(r"\\f(\(..|.)|\\[&|^%/,c]|\\s[-+]?\d|\\\*\(C['`]", "", text)
    text = re.sub(r"\\\*\([LR]\"", '"', text)
    return text.replace("\\-", "-").replace("\\(aq", "'").replace("\\ ", " ")


def _spoken(text: str) -> str:
    """Return what is told and said in a game."""
    matches = re.findall(r'_ *"((?:[^"]|"")*)"|`([^`\n]+)`', text)
    return "\n\n".join(quoted.replace('""', '"') or ticked for quoted, ticked in matches)


_READERS: tuple[tuple[str, Callable[[str], str]], ...] = (
    (r"/wordnet/data\.\w+$", _glosses),
    (r"/campaigns/.*\.cfg$|/endless-sky/data/.*\.txt$", _spoken),
    (r"\.dict\.dz$", _entries),
    (r"/fortunes/[\w-]+$|\.(txt|text)(\.gz)?$", _paragraphs),
    (r"\.(x?html?|docbook|page|xml)(\.gz)?$", _marked_up),
    (r"/man/man\d/[^/]+\.gz$", _manual),
)


def reader_of(name: str) -> Callable[[str], str] | None:
    """Return what takes the paragraphs out of such a file's text; none for one to leave unread."""
    if _UNREAD.search(name):
        return None
    return next((reader for pattern, reader in _READERS if re.search(pattern, name)), None)
