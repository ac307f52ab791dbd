"""Question types, their wordings and their answers, read from data_templates/ and checked.

Knows the schema of the files and how to fill a wording; not which clip is asked about.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from geotlm_lm.core.errors import GeoTLMError
from geotlm_lm.core.files import training_templates
from geotlm_lm.core.labels import Motion
from geotlm_lm.language.parse_answer import KINDS, AnswerGrammar, Slots

FORMS = ("doing", "naming", "short")
"""Grammatical forms every motion is written in: "Is it ...?", "Is this ...?", "...?"."""

FILLED_BY_QUESTION = {"T2": FORMS, "T3": ("options",), "T4": FORMS, "T18": FORMS}
"""Slots that depend on the clip and are filled by `data.questions`, per type."""

_BRACES = re.compile(r"\{(\w+)\}")
_ALTERNATIVES = re.compile(r"\[([^\[\]]*\|[^\[\]]*)\]")
_SPACE_BEFORE_MARK = re.compile(r" +(?=[?.,;])")
MADE_UP_SHARE = 0.25
"""Share of nouns made up of syllables: the answer never depends on what the object is called."""

SYLLABLES = tuple(
    c + v + e for c in "bdfghklmnprstvw" for v in "aeiou" for e in ("", "n", "r", "l")
)

_NESTING = 4  # {object} -> the {noun} -> a noun; deeper than this is a slot that holds itself


class UnreadableTemplate(GeoTLMError):
    """A template file is missing, or does not follow the schema."""


@dataclass(frozen=True)
class Wording:
    """One way to ask; held-out ones are never trained on."""

    id: str
    text: str
    is_held_out: bool


@dataclass(frozen=True)
class QuestionType:
    """A sort of question: how it may be asked, and every answer it may get."""

    id: str
    kind: str
    title: str
    wordings: tuple[Wording, ...]
    answers: Mapping[str, Slots]

    def among(self, wordings: str) -> tuple[Wording, ...]:
        """Return the "seen" or the "held_out" wordings."""
        return tuple(w for w in self.wordings if w.is_held_out == (wordings == "held_out"))


@dataclass(frozen=True)
class Templates:
    """All question types and the words that fill their slots."""

    types: Mapping[str, QuestionType]
    words: Mapping[str, tuple[str, ...]]
    held_out_words: Mapping[str, tuple[str, ...]]
    phrases: Mapping[Motion, Mapping[str, tuple[str, ...]]]

    def grammar(self) -> AnswerGrammar:
        """Return the closed set of answers of every type."""
        return AnswerGrammar(
            {s: x for kind in self.types.values() for s, x in kind.answers.items()}
        )

    def fill(self, text: str, rng: np.random.Generator, *, held_out: bool = False) -> str:
        """Choose one of every "[a|b]" in `text` and a word for every slot, with `rng`.

        Args:
            text: A wording or a phrase.
            rng: Draws the words.
            held_out: Draw from a slot's held-out words where it has some.
        """
        text = _ALTERNATIVES.sub(lambda match: _one_of(match[1].split("|"), rng), text)
        for _ in range(_NESTING):
            if "{" not in text:
                break
            text = _BRACES.sub(lambda match: self._draw(match[1], rng, held_out), text)
        return _SPACE_BEFORE_MARK.sub("", text)

    def _draw(self, slot: str, rng: np.random.Generator, held_out: bool) -> str:
        if slot == "noun" and not held_out and rng.random() < MADE_UP_SHARE:
            return "".join(_one_of(SYLLABLES, rng) for _ in range(int(rng.integers(1, 4))))
        words = self.held_out_words.get(slot, ()) if held_out else ()
        return _one_of(words or self.words[slot], rng)


def _one_of(words: Sequence[str], rng: np.random.Generator) -> str:
    return words[int(rng.integers(len(words)))]


@lru_cache(maxsize=4)
def load_templates(folder: Path | None = None) -> Templates:
    """Read and check every template file.

    Args:
        folder: Where the files lie; None for those that ship with the package.

    Raises:
        UnreadableTemplate: If a file is missing or breaks the schema in data_templates/README.md.
    """
    folder = training_templates() if folder is None else Path(folder)
    slots_path = folder / "slots.toml"
    slots = _read(slots_path)
    words = {name: _texts(slots_path, name, x) for name, x in _table(slots_path, slots, "slots")}
    held_out = {
        name: tuple(entry["held_out"])
        for name, entry in slots["slots"].items()
        if "held_out" in entry
    }
    types = {}
    for path in sorted(folder.glob("t[0-9]*.toml")):
        kind = _question_type(path, _read(path))
        if kind.id in types:
            raise UnreadableTemplate(f"{path}: repeats the id {kind.id}; give it another one.")
        types[kind.id] = kind
    templates = Templates(types, words, held_out, _phrases(slots_path, slots))
    _check_slots(folder, templates)
    return templates


def _read(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UnreadableTemplate(
            f"{path}: cannot be read ({error.strerror}); expected a template file, restore it."
        ) from error
    except tomllib.TOMLDecodeError as error:
        raise UnreadableTemplate(f"{path}: is not TOML ({error}); correct that line.") from error


def _table(path: Path, values: Mapping[str, Any], name: str) -> list[tuple[str, Any]]:
    if not isinstance(values.get(name), dict) or not values[name]:
        raise UnreadableTemplate(f"{path}: has no table [{name}.*]; add one.")
    return list(values[name].items())


def _texts(path: Path, name: str, entry: Any) -> tuple[str, ...]:
    words = entry.get("words") if isinstance(entry, dict) else entry
    if not isinstance(words, list) or not words or not all(isinstance(w, str) for w in words):
        raise UnreadableTemplate(f"{path}: '{name}' holds {words!r}, expected a list of words.")
    return tuple(words)


def _phrases(path: Path, slots: Mapping[str, Any]) -> dict[Motion, dict[str, tuple[str, ...]]]:
    motions = dict(_table(path, slots, "motions"))
    missing = sorted({m.value for m in Motion} ^ set(motions))
    if missing:
        raise UnreadableTemplate(
            f"{path}: motions {missing} are missing or unknown; expected exactly "
            f"{[m.value for m in Motion]}."
        )
    return {
        motion: {form: _texts(path, form, motions[motion.value].get(form)) for form in FORMS}
        for motion in Motion
    }


def _question_type(path: Path, values: dict[str, Any]) -> QuestionType:
    unknown = set(values) - {"id", "kind", "title", "letters", "wordings", "answers"}
    missing = {"id", "kind", "title", "wordings", "answers"} - set(values)
    if unknown or missing:
        raise UnreadableTemplate(
            f"{path}: fields {sorted(unknown)} are unknown and {sorted(missing)} are missing; "
            f"follow data_templates/README.md."
        )
    if values["kind"] not in KINDS:
        raise UnreadableTemplate(
            f"{path}: kind is {values['kind']!r}, expected one of {list(KINDS)}; correct it."
        )
    return QuestionType(
        id=values["id"],
        kind=values["kind"],
        title=values["title"],
        wordings=_wordings(path, values["wordings"]),
        answers=_answers(path, values),
    )


def _wordings(path: Path, rows: list[dict[str, Any]]) -> tuple[Wording, ...]:
    wordings: dict[str, Wording] = {}
    for row in rows:
        if not {"id", "text"} <= set(row) <= {"id", "text", "held_out"} or row["id"] in wordings:
            raise UnreadableTemplate(
                f"{path}: wording {row} needs its own id, a text and at most held_out; correct it."
            )
        wordings[row["id"]] = Wording(row["id"], row["text"], bool(row.get("held_out", False)))
    held_out = sum(wording.is_held_out for wording in wordings.values())
    if held_out != round(len(wordings) / 4):
        raise UnreadableTemplate(
            f"{path}: {held_out} of {len(wordings)} wordings are held out, expected a quarter "
            f"({round(len(wordings) / 4)}); mark more or fewer."
        )
    return tuple(wordings.values())


def _answers(path: Path, values: dict[str, Any]) -> dict[str, Slots]:
    answers: dict[str, Slots] = {}
    for row in values["answers"]:
        slots = {name: value for name, value in row.items() if name != "text"}
        for letter in values.get("letters", (None,)):
            extra = {} if letter is None else {"letter": letter}
            try:
                text = row["text"].replace("{letter}", letter or "{letter}")
                parsed = Slots.from_dict({"kind": values["kind"], **slots, **extra})
            except (KeyError, ValueError) as error:
                raise UnreadableTemplate(
                    f"{path}: answer {row} has no text or a wrong slot ({error}); correct it."
                ) from error
            if text in answers or parsed in answers.values() or "{" in text:
                raise UnreadableTemplate(
                    f"{path}: answer {text!r} repeats a sentence or its slots, or holds an "
                    f"unfilled slot; every filling needs exactly one sentence."
                )
            answers[text] = parsed
    return answers


def _check_slots(folder: Path, templates: Templates) -> None:
    """Refuse a slot nothing fills, and a sentence that two types would share."""
    own = [(slot, text) for slot, words in templates.words.items() for text in words]
    own += [(m, t) for m, forms in templates.phrases.items() for f in forms.values() for t in f]
    own += [
        (type_id, wording.text)
        for type_id, kind in templates.types.items()
        for wording in kind.wordings
    ]
    for where, text in own:
        known = {*templates.words, *FILLED_BY_QUESTION.get(str(where), ())}
        unknown = sorted(set(_BRACES.findall(text)) - known)
        if unknown:
            raise UnreadableTemplate(
                f"{folder}: {text!r} of {where} holds the slots {unknown}, which nothing fills; "
                f"known are {sorted(known)}."
            )
    sentences = [s for kind in templates.types.values() for s in kind.answers]
    shared = sorted({s for s in sentences if sentences.count(s) > 1})
    if shared:
        raise UnreadableTemplate(
            f"{folder}: answers {shared} stand under two types; reword one so that it parses back."
        )
