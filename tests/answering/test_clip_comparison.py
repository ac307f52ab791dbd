"""Questions about two clips, through the seam: compared, told of one of them, or declined."""

import pytest

from tests.answering.scripted import answerer_saying, recording


@pytest.mark.parametrize(
    "question",
    ["Are they the same object?", "Are both round?", "Is it the same person?", "Tell me a story."],
)
def test_what_is_about_neither_directions_nor_amounts_is_declined(bundle, question):
    answerer = answerer_saying(bundle, {"*": "Clockwise, in the camera image."}, temperature=0.1)
    clips = [answerer.encode(recording(seed=seed)) for seed in (1, 2)]
    compared = answerer.compare(*clips, question)
    assert compared.text.startswith("Of two clips I tell whether they go the same way, which one")
    assert (compared.relation, compared.confidence, compared.abstained) == ("unknown", 0.0, True)


@pytest.mark.parametrize(
    "said", ["It is pressing in.", "It is still: touching but not moving.", "It is lifting off."]
)
@pytest.mark.parametrize("question", ["Which one goes further?", "Which is faster?"])
def test_what_goes_no_way_has_no_amount_to_compare(bundle, said, question):
    answerer = answerer_saying(bundle, {"*": said}, temperature=0.1)
    clips = [answerer.encode(recording(seed=seed)) for seed in (1, 2)]
    compared = answerer.compare(*clips, question)
    assert compared.text.startswith("I cannot compare them: not both of them turn or slide.")
    assert (compared.relation, compared.abstained) == ("unknown", True)
