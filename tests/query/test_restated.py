"""Programs in plain words, and a sentence for every reason that something cannot be told."""

import re
from pathlib import Path

import pytest
from hypothesis import given, settings

import geotlm_lm
from geotlm_lm.query import program as p
from geotlm_lm.query.lines import FACTS, read
from geotlm_lm.query.phrases import _NOUNS, _PHRASES, _SO, replies, restated
from geotlm_lm.query.program import EVENTS, TALK, UNANSWERABLE, Fact, Program, Quantity
from tests.query.programs import expressions

NAMED = {"way", "choose", "choose-not", "record", "pi", *p.COUNTS}
"""Primitives that are put into words one by one, and numbers."""


def test_every_primitive_has_words():
    for name, words in p.ACCEPTED.items():
        for word, takes in words.items():
            if name in p.NAMES or word in NAMED:
                continue
            if word.endswith(EVENTS):
                assert word.removesuffix(EVENTS) in _NOUNS
            elif takes:
                assert {f"{{{place}}}" for place in range(len(takes))} >= {
                    *re.findall(r"{\d}", _PHRASES[word])
                }, word
            else:
                assert word in _SO or word in _PHRASES, word


@given(expressions())
@settings(max_examples=100, deadline=None)
def test_every_program_is_put_into_words(expression):
    text = restated(Program((expression,)))
    assert text
    assert "{" not in text


@pytest.mark.parametrize(("line", "text"), [
    ("cw", "whether it turns clockwise"),
    ("backwards way turn", "which way it turns, played backwards"),
    ("> amount turn 30.0:deg", "whether it turns by more than 30 degrees"),
    ("way turn ; count reverse-events", "which way it turns; how many reversals there are"),
    ("begin first turn-events", "the beginning of the first turn"),
    ("begin nth 2 left-events", "the beginning of slide to the left number 2"),
    ("length longest press-events", "how long the longest press takes"),
    ("fact mirrored ; fact thread left", "that the image is mirrored, left-hand thread"),
])  # fmt: skip
def test_a_program_in_words(line, text):
    assert restated(read(line)) == text


@pytest.mark.parametrize("name", FACTS)
def test_every_fact_has_words(name):
    values, count = FACTS[name]
    for value in values or (None,):
        assert restated(Program(facts=(Fact(name, value, (Quantity(25.0, "mm"),) * count),)))
    assert restated(Program(facts=(Fact(name, denied=True),)))


def test_every_reason_has_a_sentence():
    root = Path(geotlm_lm.__file__).parent
    used = {"unsure", "pixel", "before", "none-such", "unreadable"}
    for path in (root / "query").glob("*.py"):
        text = path.read_text(encoding="utf-8")
        given = r'(?:Untold\(|reason=|reason: str = |reason or |\.reason = )"([a-z-]+)"'
        used |= {*re.findall(given, text)}
    text = (root / "answering" / "understanding.py").read_text(encoding="utf-8")
    used |= {*re.findall(r'return \(?"([a-z-]+)"', text)}
    assert {"never", "contact", "mask", "reference", "unrecognised", "suspicion", "scale"} <= used
    assert used <= {*replies()["missing"]}
    assert {*UNANSWERABLE} == {*replies()["untold"]}
    assert {*TALK} == {*replies()["talk"]}
