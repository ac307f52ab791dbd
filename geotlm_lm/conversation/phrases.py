"""Read the wordings of questions, which are data, from data_templates/phrases/ (see its README)."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from functools import cache
from typing import Any

from geotlm_lm.core.resources import resource_dir

FORMS = ("base", "third", "past", "gerund")
Verb = tuple[str, str, str, str]
_PLACEHOLDER = re.compile(
    r"\{(?:(?P<forms>[a-z ]+) of (?P<verbs>[A-Z ]+)|(?:(?P<file>\w+)\.)?(?P<name>[A-Z][A-Z_]*))\}"
)


@cache
def _tables(file: str) -> dict[str, Any]:
    path = resource_dir("data_templates") / "phrases" / f"{file}.toml"
    return tomllib.loads(path.read_text(encoding="utf-8"))


def verbs(name: str) -> Iterator[Verb]:
    """Yield the verbs of a list of motion_verbs.toml, each in its four forms."""
    for line in _tables("motion_verbs")[name]:
        yield from verbs(line) if line.isupper() else (tuple(line.split()),)


def forms_of(table: tuple[Verb, ...], *which: str) -> str:
    """Return a pattern of the given forms of verbs, of all of them where none is given."""
    places = [FORMS.index(form) for form in which or FORMS]
    return f"(?:{'|'.join(sorted({verb[at] for verb in table for at in places}))})"


class Phrases:
    """Tables of one file; what only code can tell of them, such as a number, is `given` by name."""

    def __init__(self, file: str, **given: str) -> None:
        self._file, self._given = file, given

    def text(self, name: str) -> str:
        """Return a table as a pattern, of which alternatives stand in no group of their own."""
        table = _tables(self._file)[name]
        if isinstance(table, dict):
            before, after = (self._resolved(table.get(key, "")) for key in ("before", "after"))
            return f"{before}(?:{'|'.join(map(self._resolved, table['any']))}){after}"
        return self._resolved(table) if isinstance(table, str) else "|".join(self.each(name))

    def group(self, name: str) -> str:
        """Return a table as a part of a pattern, as its placeholder stands for it."""
        several = isinstance(table := _tables(self._file)[name], list) and len(table) > 1
        return f"(?:{self.text(name)})" if several else self.text(name)

    def each(self, name: str) -> tuple[str, ...]:
        """Return the alternatives of a table, each a pattern."""
        return tuple(map(self._resolved, _tables(self._file)[name]))

    def pattern(self, name: str, flags: re.RegexFlag = re.NOFLAG) -> re.Pattern[str]:
        """Return a table, compiled."""
        return re.compile(self.text(name), flags)

    def words(self, name: str) -> tuple[str, ...]:
        """Return the words of a table of which each text holds several."""
        return tuple(" ".join(_tables(self._file)[name]).split())

    def _resolved(self, text: str | list[str]) -> str:
        return _PLACEHOLDER.sub(self._stands_for, "".join(text))

    def _stands_for(self, found: re.Match[str]) -> str:
        if found["verbs"]:
            table = tuple(verb for name in found["verbs"].split() for verb in verbs(name))
            return forms_of(table, *found["forms"].replace("all", "").split())
        tables = Phrases(found["file"]) if found["file"] else self
        return tables._given.get(found["name"]) or tables.group(found["name"])
