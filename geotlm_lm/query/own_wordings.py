"""The wordings of the product's own question types as families of the grammar of questions.

What each means stands in data_templates/query/own.toml. Wordings that are held out of training
there are of the "test" split here.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from itertools import product
from typing import Any

from geotlm_lm.core.files import training_templates
from geotlm_lm.data.question_contents import OPTION_STYLES
from geotlm_lm.data.templates import FORMS, Wording, load_templates
from geotlm_lm.query.clauses import Clause, Family

ATOM_OF = {"clockwise": "cw", "counterclockwise": "ccw", "press": "in", "release": "out"}
"""Words of a query for motions that it calls otherwise."""

SEPARATORS = (", ", " ", "; ")
_SLOT = re.compile(r"\{(\w+)\}")
_CHOICE = re.compile(r"\[([^\[\]]*\|[^\[\]]*)\]")
_MARKS = ".?! "


def own_words() -> dict[str, Any]:
    """Return the word lists that own wordings are filled from, named "own-..."."""
    templates = load_templates()
    lists: dict[str, Any] = {
        f"own-{name}": [_renamed(word) for word in words] for name, words in templates.words.items()
    }
    for form in FORMS:
        lists[f"own-{form}"] = {
            ATOM_OF.get(motion.value, motion.value): [_renamed(text) for text in forms[form]]
            for motion, forms in templates.phrases.items()
        }
    rest = ("still", "none")
    lists["own-directed"] = {key: x for key, x in lists["own-doing"].items() if key not in rest}
    return lists


def own_clauses(words: dict[str, Any]) -> list[Clause]:
    """Return what the product's own questions have before and behind them."""
    behind = [word.strip() for word in words["own-closer"]]
    texts = {
        "before": tuple(word.strip() for word in words["own-opener"]),
        "after": tuple(word for word in behind if not word.endswith(".")),
        "alone_after": tuple(word[:-1] for word in behind if word.endswith(".")),
    }
    return [Clause("noise/own-openers-and-closers", "noise", "", texts)]


def own_families() -> list[Family]:
    """Return a family of every wording, and of every form that it offers a motion in."""
    path = training_templates() / "query" / "own.toml"
    meant = tomllib.loads(path.read_text(encoding="utf-8"))
    families = []
    for kind in load_templates().types.values():
        meanings = meant.get(kind.id, {})
        for wording in kind.wordings:
            query = meanings.get("of", {}).get(wording.id, meanings.get("query", ""))
            if query:
                families += _families(kind.id, wording, query)
    for row in meant["also"]:
        texts = tuple(row["texts"].strip().splitlines())
        families.append(Family(f"{row['id']}.train", row["query"], texts))
    return families


def _families(type_id: str, wording: Wording, query: str) -> Iterator[Family]:
    split = "blind" if wording.is_held_out else "train"
    name = f"own-{type_id}/own-{type_id}-{wording.id}"
    text = wording.text.rstrip(_MARKS)
    end = wording.text[len(text) :].strip()
    if "{options}" in query:
        for count in (2, 3, 4):
            texts, options = _with_options(text, count)
            offered = query.replace("{options}", options)
            yield Family(f"{name}-{count}.{split}", offered, texts, end)
    elif "{motion}" in query:
        for form in FORMS:
            texts = tuple(_renamed(each) for each in _of_form(text, form))
            meant = query.replace("{motion}", f"{{own-{form}}}")
            if texts:
                yield Family(f"{name}-{form}.{split}", meant, texts, end)
    else:
        yield Family(f"{name}.{split}", query, (_renamed(text),), end)


def _with_options(text: str, count: int) -> tuple[tuple[str, ...], str]:
    """Return a wording with so many lettered options written in every style, and their query."""
    phrases = [f"{{own-short{place or ''}}}" for place in (0, *range(2, count + 1))]
    labelled = list(zip("ABCD", phrases, strict=False))
    lists = [
        separator.join(
            style.replace("{letter}", letter).replace("{text}", phrase)
            for letter, phrase in labelled
        )
        for style, separator in product(OPTION_STYLES, SEPARATORS)
    ]
    renamed = _renamed(text.replace("{options}", "\0"))
    texts = tuple(renamed.replace("\0", listed) for listed in lists)
    return texts, " | ".join(f"{letter} {phrase}" for letter, phrase in labelled)


def _of_form(text: str, form: str) -> list[str]:
    """Return a wording's variants that have a motion in one form, its other choices left open."""
    others = [f"{{{each}}}" for each in FORMS if each != form]
    for match in _CHOICE.finditer(text):
        if any(f"{{{each}}}" in match[1] for each in FORMS):
            before, after = text[: match.start()], text[match.end() :]
            chosen = [f"{before}{part}{after}" for part in match[1].split("|")]
            return [each for part in chosen for each in _of_form(part, form)]
    return [text] if f"{{{form}}}" in text and not any(each in text for each in others) else []


def _renamed(text: str) -> str:
    return _SLOT.sub(r"{own-\1}", text)
