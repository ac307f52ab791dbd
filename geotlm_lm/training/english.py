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
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

from geotlm_lm.core.errors import MissingDependency, UsageError, first_line
from geotlm_lm.core.files import replacing, write_text_atomically
from geotlm_lm.core.process import Progress, silent
from geotlm_lm.training.prose import passages_of, reader_of

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
