import re
import shutil
from dataclasses import replace

import numpy as np
import pytest

from geotlm_lm.core.files import resource_dir
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.data.questions import questions_for
from geotlm_lm.data.templates import UnreadableTemplate, load_templates
from geotlm_lm.language.tokenizer import clean_question

TEMPLATES = load_templates()
ANSWERS = [
    (text, slots) for kind in TEMPLATES.types.values() for text, slots in kind.answers.items()
]


@pytest.fixture
def folder(tmp_path):
    return shutil.copytree(resource_dir("data_templates"), tmp_path / "templates")


def edit(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


def test_no_wording_stands_twice():
    texts = [w.text.lower() for kind in TEMPLATES.types.values() for w in kind.wordings]
    assert len(texts) == len(set(texts))


@pytest.mark.parametrize(("text", "slots"), ANSWERS)
def test_every_answer_parses_back_to_its_slots_and_no_corruption_of_one_word_does(text, slots):
    grammar, words = TEMPLATES.grammar(), text.split()
    assert grammar.parse(text) == slots
    assert grammar.sentence(slots) == text
    lexicon = {word for answer, _ in ANSWERS for word in answer.split()} | {"banana", ""}
    corrupted = [
        " ".join([*words[:i], other, *words[i + 1 :]])
        for i, word in enumerate(words)
        for other in lexicon - {word}
    ]
    parsed = [grammar.parse(candidate) for candidate in corrupted]
    assert slots not in parsed
    assert {p.kind for p in parsed if p is not None} <= {slots.kind}


@pytest.mark.parametrize("motion", Motion)
def test_every_wording_renders_for_every_motion(motion):
    rng = np.random.default_rng(0)
    for kind in TEMPLATES.types.values():
        for wording in kind.wordings:
            alone = replace(kind, wordings=(wording,))
            which = "held_out" if wording.is_held_out else "seen"
            text = ask_only(alone, motion, rng, which)
            assert not re.search(r"[\[\]{}|]", text)
            assert text.strip("?. ")


def ask_only(kind, motion, rng, which):
    from geotlm_lm.data.questions import _ask

    return _ask(TEMPLATES, kind, MotionLabel(motion), rng, which).question


def test_held_out_wordings_use_no_word_unknown_to_seen_ones_but_the_held_out_nouns():
    rng = np.random.default_rng(0)

    def words(which, rounds):
        asked = [
            question.question
            for _ in range(rounds)
            for motion in Motion
            for question in questions_for(MotionLabel(motion), rng, wordings=which)
        ]
        return set(re.findall(r"[a-z]+", clean_question(" ".join(asked))))

    nouns = set(TEMPLATES.held_out_words["noun"])
    assert words("held_out", 60) - words("seen", 150) <= nouns


@pytest.mark.parametrize(
    ("name", "old", "new", "message"),
    [
        ("t06_contact.toml", "touching the {gel}?", "touching the {jelly}?", "which nothing fills"),
        ("t06_contact.toml", 'kind = "contact"', 'kind = "touch"', "kind is 'touch', expected one"),
        ("t06_contact.toml", ", held_out = true", "", "expected a quarter"),
        ("t06_contact.toml", 'title = "Contact"', "", "['title'] are missing"),
        ("t06_contact.toml", "verdict = false", "verdict = true", "repeats a sentence or its"),
        ("t06_contact.toml", "verdict = false", "certainty = 1", "no text or a wrong slot"),
        ("t16_moving.toml", "there is no contact.", "nothing is touching the gel.", "two types"),
        ("t05_class.toml", 'id = "T5"', 'id = "T6"', "repeats the id T6"),
        ("slots.toml", "[motions.left]", "[motions.leftt]", "['left', 'leftt'] are missing or"),
        ("slots.toml", "[slots.noun]", "[slots.noun", "is not TOML"),
    ],
)
def test_a_broken_template_says_what_is_wrong(folder, name, old, new, message):
    edit(folder / name, old, new)
    with pytest.raises(UnreadableTemplate) as caught:
        load_templates(folder)
    assert message in str(caught.value)
    assert str(folder) in str(caught.value)
    (folder / "slots.toml").unlink()
    with pytest.raises(UnreadableTemplate, match="restore it"):
        load_templates(folder)
