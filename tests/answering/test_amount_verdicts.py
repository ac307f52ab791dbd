"""Ranges, numbers in words, other units and speeds, judged by what is measured."""

from dataclasses import replace

import pytest

from geotlm_lm.answering import OPEN_QUESTION, Answerer
from geotlm_lm.checkpoint import Calibration
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from tests.answering.scripted import feeling, measuring, recording


def test_a_speed_is_declined_where_no_time_is_known(bundle):
    answerer = measuring(bundle, Motion.CLOCKWISE, "deg", deg=12.0)
    answer = answerer.ask(answerer.encode(recording()), "faster than 100 degrees per second?")
    assert answer.text.startswith("I cannot tell the speed: ")
    assert (answer.abstained, answer.decided) == (True, None)


def test_a_speed_in_millimetres_takes_the_size_of_a_pixel(bundle):
    answerer = measuring(bundle, Motion.LEFT, "px", px=14.0)
    encoded = answerer.encode(recording(fps=25.0))
    unknown = answerer.ask(encoded, "Does it slide faster than 2 mm/s?")
    assert unknown.abstained
    assert unknown.text.startswith("I cannot judge millimetres: about ")
    asked = "Does it slide faster than 2 mm/s, at 0.06 mm per pixel?"
    known = answerer.ask(encoded, asked, frame=FrameSpec(mm_per_px=0.06))
    assert (known.decided, known.amount.unit) == ("no", "mm/s")


def test_a_number_that_cannot_be_judged_is_declined_without_a_model_run(bundle):
    answerer = measuring(bundle, Motion.CLOCKWISE, "deg", deg=12.0)
    answer = answerer.ask(answerer.encode(recording()), "Did it turn a few degrees?")
    assert answer.text == (
        "I cannot judge that number: I judge how far or how fast it turned or slid, one amount or "
        "one range at a time; ask for example 'did it turn 10 to 20 degrees?'."
    )
    assert (answer.abstained, answer.decided) == (True, None)
    assert answerer.bundle.speaker.heard == []


@pytest.mark.parametrize(
    ("question", "text"),
    [
        ("Did it turn 45 degrees?", "I cannot tell how far it moved: this model was not trained"),
        ("at 5 rpm?", "I cannot tell how fast it moved: this model was not trained"),
    ],
)
def test_a_model_without_amounts_judges_none(bundle, question, text):
    answerer = feeling(bundle, "clockwise")
    answer = answerer.ask(answerer.encode(recording()), question)
    assert answer.text.startswith(text)
    assert answer.abstained


def test_a_verdict_hears_the_open_question_once(bundle, monkeypatch):
    answerer = measuring(bundle, Motion.CLOCKWISE, "deg", deg=12.0)
    asked, weigh = [], answerer.bundle.speaker.weigh
    monkeypatch.setattr(
        answerer.bundle.speaker,
        "weigh",
        lambda token, question, options: asked.append(question) or weigh(token, question, options),
    )
    answerer.ask(answerer.encode(recording()), "Did it turn 12 degrees clockwise?")
    assert asked.count(OPEN_QUESTION) == 1


@pytest.mark.parametrize(
    ("way_px", "decided"), [(2.4, "no"), (3.6, "yes"), (5.0, "yes"), (6.6, "yes"), (8.0, "no")]
)
def test_a_speed_is_as_far_off_as_its_amount_may_be(bundle, way_px, decided):
    answerer = measuring(bundle, Motion.RIGHT, "px", px=5.0)
    encoded = answerer.encode(recording(fps=25.0, size=(224, 224)))
    seconds = 3 / 25
    for claim in (f"about {way_px} px", f"at about {way_px / seconds:.4g} px/s"):
        assert answerer.ask(encoded, f"Did it slide {claim}?").decided == decided


def test_a_claim_of_an_amount_is_no_surer_than_that_it_turns_at_all(bundle):
    sure = measuring(bundle, Motion.CLOCKWISE, "deg", deg=12.0).bundle
    unsure = Answerer(replace(sure, calibration=Calibration(temperature=1.0)))
    encoded = unsure.encode(recording())
    open_answer, claim = (
        unsure.ask(encoded, asked) for asked in ("how far?", "Did it turn 12 degrees?")
    )
    assert 0.5 < open_answer.options["rotation"] < 0.9
    assert claim.options["yes"] == pytest.approx(open_answer.options["rotation"])
    elsewhere = unsure.ask(encoded, "Did it turn 50 degrees?")
    assert elsewhere.options == pytest.approx({"yes": 0.0, "no": 1.0})
