import re

import pytest

from geotlm_lm.core.errors import UsageError
from geotlm_lm.language.prompt import MAX_ANSWER_TOKENS


def test_a_prompt_is_the_prefix_the_question_and_the_turn_of_the_assistant(speaker):
    ids = speaker.prompts.prompt("  Which\n WAY? ")
    words = [speaker.prompts.tokenizer.id_to_token(i) for i in ids]
    assert words[:4] == ["<tactile>"] * 3 + ["<user>"]
    assert words[-1] == "<assistant>"
    assert speaker.prompts.tokenizer.decode(ids[4:-1]) == "which way?"


def test_an_answer_ends_and_reads_back(speaker):
    ids = speaker.prompts.answer("Left, in the camera image.")
    assert ids[-1] == speaker.prompts.eos_id
    assert speaker.prompts.decode([*ids, 77, 78]) == "Left, in the camera image."


def test_a_question_that_leaves_no_room_for_an_answer_is_refused(speaker):
    with pytest.raises(UsageError) as caught:
        speaker.prompts.prompt("\u6f22" * 60)
    said = re.fullmatch(
        r"The question has 60 characters, expected at most about (\d+) of this kind; shorten it\.",
        str(caught.value),
    )
    assert 0 < int(said[1]) < 60


def test_every_answer_of_the_templates_fits_its_room(speaker):
    from geotlm_lm.data.templates import load_templates

    longest = max(
        len(speaker.prompts.answer(text))
        for kind in load_templates().types.values()
        for text in kind.answers
    )
    assert longest <= MAX_ANSWER_TOKENS
