"""Ranges, numbers in words, other units and speeds, judged by what is measured."""

import pytest

from geotlm_lm.core.frame_spec import FrameSpec
from tests.answering.scripted import answerer_saying, believed, measuring, recording


def test_a_speed_is_declined_where_no_time_is_known(bundle):
    answerer = measuring(bundle, "clockwise", deg=12.0)
    answer = answerer.ask(answerer.encode(recording()), "faster than 100 degrees per second?")
    assert answer.text.startswith("I cannot tell the speed: ")
    assert (answer.abstained, answer.decided) == (True, None)


def test_a_speed_in_millimetres_takes_the_size_of_a_pixel(bundle):
    answerer = measuring(bundle, "left", px=14.0)
    encoded = answerer.encode(recording(fps=25.0))
    unknown = answerer.ask(encoded, "Does it slide faster than 2 mm/s?")
    assert unknown.abstained
    assert unknown.text.startswith("I cannot judge millimetres: about ")
    asked = "Does it slide faster than 2 mm/s, at 0.06 mm per pixel?"
    known = answerer.ask(encoded, asked, frame=FrameSpec(mm_per_px=0.06))
    assert (known.decided, known.amount.unit) == ("no", "mm/s")


def test_a_number_that_cannot_be_judged_is_declined_without_a_model_run(bundle):
    answerer = measuring(bundle, "clockwise", deg=12.0)
    answer = answerer.ask(answerer.encode(recording()), "Did it turn a few degrees?")
    assert answer.text == (
        "I cannot judge that number: I judge how far or how fast it turned or slid, one amount or "
        "one range at a time; ask for example 'did it turn 10 to 20 degrees?'."
    )
    assert (answer.abstained, answer.decided) == (True, None)
    assert answerer.bundle.speaker.heard == []


@pytest.mark.parametrize(
    ("way_px", "decided"), [(2.4, "no"), (3.6, "yes"), (5.0, "yes"), (6.6, "yes"), (8.0, "no")]
)
def test_a_speed_is_as_far_off_as_its_amount_may_be(bundle, way_px, decided):
    answerer = measuring(bundle, "right", px=5.0)
    encoded = answerer.encode(recording(fps=25.0, size=(224, 224)))
    seconds = 3 / 25
    for claim in (f"about {way_px} px", f"at about {way_px / seconds:.4g} px/s"):
        assert answerer.ask(encoded, f"Did it slide {claim}?").decided == decided


def test_a_claim_of_an_amount_is_no_surer_than_that_it_turns_at_all(bundle):
    belief = believed("clockwise", share=0.8)
    answerer = answerer_saying(bundle, {"*": "A rotation."}, belief=belief)
    encoded = answerer.encode(recording())
    claim = answerer.ask(encoded, "Did it turn 12 degrees?")
    assert claim.options == pytest.approx({"yes": 0.8, "no": 0.2})
    elsewhere = answerer.ask(encoded, "Did it turn 50 degrees?")
    assert elsewhere.options == pytest.approx({"yes": 0.0, "no": 1.0})


def test_what_does_not_turn_turns_by_no_number_of_degrees(bundle):
    answerer = measuring(bundle, "left")
    answer = answerer.ask(answerer.encode(recording()), "Did it turn 12 degrees?")
    assert answer.text.startswith("No, it does not turn; it slides left, about ")
    assert (answer.decided, answer.amount) == ("no", None)
    both = answerer_saying(bundle, {}, belief=believed("left", "clockwise", deg=30.0))
    answer = both.ask(both.encode(recording()), "Did it turn 12 degrees?")
    assert (answer.decided, answer.amount.unit) == ("yes", "deg")
