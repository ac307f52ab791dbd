"""Every table of wordings is read, complete and used."""

from __future__ import annotations

import ast
import re
import tomllib
from pathlib import Path

import pytest

import geotlm_lm
from geotlm_lm.conversation.clip_names import clip_named
from geotlm_lm.conversation.kind_choices import REST
from geotlm_lm.conversation.number_words import NUMBER, SHARE
from geotlm_lm.conversation.phrases import Phrases, forms_of, verbs
from geotlm_lm.conversation.quantities import UNIT
from geotlm_lm.core.resources import resource_dir

FILES = sorted((resource_dir("data_templates") / "phrases").glob("*.toml"))
GIVEN = {"NUMBER": NUMBER, "SHARE": SHARE, "UNIT": UNIT, "LENGTH_UNIT": UNIT, "ONE": REST} | {
    name: clip_named(f"of_{name.lower()}")
    for name in ("A_CLIP", "OTHER_CLIP", "ONE_CLIP", "SUBJECT_CLIP")
}
"""What modules give by name, in a form that can stand in any of their patterns."""


def texts_of(table: object) -> str:
    values = table.values() if isinstance(table, dict) else table
    return table if isinstance(table, str) else "\n".join(map(texts_of, values))


def names_in_code() -> set[tuple[str, str]]:
    """Return every text in a module of the package that may name a table, with its module."""
    return {
        (path.stem, node.value)
        for path in Path(geotlm_lm.__file__).parent.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_table_resolves_and_compiles(path: Path) -> None:
    tables = tomllib.loads(path.read_text(encoding="utf-8"))
    assert tables
    given = {name: text for name, text in GIVEN.items() if name not in tables}
    phrases = Phrases(path.stem, **given)
    for name, table in tables.items():
        for text in phrases.each(name) if isinstance(table, list) else (phrases.text(name),):
            assert not re.search(r"\{(?:\w+\.)?[A-Z]|\{[a-z ]+ of ", text), (
                f"{path.stem}.{name}: {text}"
            )
            re.compile(text)


def test_every_table_is_used() -> None:
    sources = {path.stem: tomllib.loads(path.read_text(encoding="utf-8")) for path in FILES}
    in_code = names_in_code()
    own = {file: texts_of(tables) for file, tables in sources.items()}
    everything = "\n".join(own.values())
    unused = [
        f"{file}.{name}"
        for file, tables in sources.items()
        for name in tables
        if (file, name) not in in_code
        and f"{{{name}}}" not in own[file]
        and f"{{{file}.{name}}}" not in everything
        and not (file == "motion_verbs" and re.search(rf"\b{name}\b", everything))
    ]
    assert unused == []


def test_verbs_are_told_in_the_forms_that_are_asked_for() -> None:
    assert forms_of((("go", "goes", "went", "going"),), "past", "base") == "(?:go|went)"
    assert ("head", "heads", "headed", "heading") in set(verbs("GOES")) - set(verbs("MOVES"))
