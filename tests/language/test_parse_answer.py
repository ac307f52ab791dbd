import pytest

from geotlm_lm.core.errors import IncompatibleBundle
from geotlm_lm.core.labels import Motion
from geotlm_lm.language.parse_answer import AnswerGrammar, Slots

ANSWERS = {
    "Left, in the camera image.": Slots("direction", Motion.LEFT),
    "No, it goes left in the camera image.": Slots("verify", Motion.LEFT, False),
    "Yes, left in the camera image.": Slots("verify", Motion.LEFT, True),
    "An amount of sliding, as measured.": Slots("magnitude", unit="px"),
}


@pytest.mark.parametrize("text", ["", "Left", "left, in the camera image.", "Left, perhaps."])
def test_anything_but_an_answer_does_not_parse(text):
    assert AnswerGrammar(ANSWERS).parse(text) is None


def test_two_sentences_for_the_same_slots_are_refused():
    with pytest.raises(ValueError, match="repeat the slots"):
        AnswerGrammar({**ANSWERS, "Leftwards.": Slots("direction", Motion.LEFT)})


def test_a_grammar_survives_its_file(tmp_path):
    grammar = AnswerGrammar(ANSWERS)
    grammar.save(tmp_path / "answers.json")
    assert AnswerGrammar.load(tmp_path / "answers.json") == grammar


@pytest.mark.parametrize("text", ["[", '[{"text": "x", "kind": "none"}]', '[{"kind": "verify"}]'])
def test_a_broken_file_says_what_to_do(tmp_path, text):
    (tmp_path / "answers.json").write_text(text)
    with pytest.raises(IncompatibleBundle, match="save or download the model again"):
        AnswerGrammar.load(tmp_path / "answers.json")
