"""The Simulate tab's function: truth beside reading, and the error between them."""

from dataclasses import replace

import numpy as np
import pytest

from app.simulate_tab import _rows, simulate, simulated, touch_of
from app.stage import stage_of
from geotlm_lm import GeoTLMError, Touch, simulate_touch
from geotlm_lm.core.geometry import IMAGE_SIDE
from tests.app.fakes import FakeAnswerer


@pytest.fixture(scope="module")
def made():
    return simulate(FakeAnswerer(), Touch("key", slide_x_mm=1.0, seed=1))


def test_the_truth_is_what_was_asked_for(made):
    true = made.facts["true"]
    assert true["rotation_deg"] == 0
    assert true["slide_x_px"] == pytest.approx(IMAGE_SIDE / 20.3, abs=0.01)
    assert (made.facts["true_motion"], made.facts["true_ways"]) == ("right", ["right"])
    assert made.shown.seen.depth_mm.shape[0] == 4


def test_a_slide_down_is_told_in_the_pixels_of_the_squashed_picture():
    true = simulate(FakeAnswerer(), Touch("key", slide_y_mm=-1.0, seed=1)).facts["true"]
    # The view is as high as three quarters of its width, and squashed to a square.
    assert true["slide_y_px"] == pytest.approx(-IMAGE_SIDE / 15.2, abs=0.01)
    assert true["slide_x_px"] == 0


def test_an_answer_is_right_only_where_all_that_shows_is_told():
    touch = Touch("key", twist_deg=20.0, slide_x_mm=-0.8, press_mm=0.1, seed=1)
    made = simulate(FakeAnswerer(), touch)  # the fake answers "left"
    facts = made.facts
    assert facts["true"]["rotation_deg"] == pytest.approx(20, abs=0.01)
    assert facts["true"]["slide_x_px"] == pytest.approx(-0.8 * IMAGE_SIDE / 20.3, abs=0.2)
    assert facts["true"]["press_mm"] == pytest.approx(0.1)
    assert facts["true_motion"] == "clockwise"
    assert facts["true_ways"] == ["clockwise", "left", "press"]
    assert facts["moves"] == {"turn": True, "slide": True, "press": True}
    assert facts["answer"].startswith("It slides left, about ")
    assert facts["how_far"].startswith("It slides left, about ")
    assert not facts["is_right"]
    assert "it also turned clockwise 20 degrees" in made.verdict
    assert not simulate(FakeAnswerer(), replace(touch, slide_x_mm=0.0)).facts["is_right"]
    alone = simulate(FakeAnswerer(), Touch("key", slide_x_mm=-0.8, seed=1))
    assert (alone.facts["is_right"], alone.verdict) == (True, "correct: it slid left 9 px")


def test_a_slide_between_two_ways_is_told_by_both():
    made = simulate(FakeAnswerer(), Touch("key", slide_x_mm=3, slide_y_mm=3, seed=1))
    assert made.facts["true_ways"] == ["down", "right"]
    assert not made.facts["is_right"]
    assert made.verdict.startswith("wrong: it slid down and right 55 px, not ")


def test_a_touch_that_the_gel_does_not_take_leaves_the_stage_and_says_what_to_change():
    with pytest.raises(GeoTLMError) as caught:
        touch_of("key", {"depth_mm": 1.2, "press_mm": 1.0}, 0)
    advice = "press by at most 0.6 mm, or about a depth of -0.5 to 1 mm."
    assert str(caught.value).endswith(advice)
    # Nothing is filled, so that the touch before stays on the stage.
    with pytest.raises(GeoTLMError, match="press by at most 0.6 mm"):
        next(simulated(FakeAnswerer(), "key", 0, 0, 0, 1.0, 1.2, 4, 1, 0))
    touch_of("key", {"depth_mm": 1.2, "press_mm": 0.6}, 0)
    touch_of("key", {"depth_mm": 1.0, "press_mm": 1.0}, 0)


def test_the_error_is_the_reading_less_the_truth(made):
    read, true, error = (made.facts[name] for name in ("read", "true", "error"))
    assert error["slide_x_px"] == pytest.approx(read["slide_x_px"] - true["slide_x_px"], abs=0.02)
    assert read["slide_x_px"] == pytest.approx(made.shown.encoded.belief.mean.right_px, abs=0.01)


def test_the_true_field_goes_to_the_right_wherever_it_touches_in_the_end(made):
    truth = simulate_touch(Touch("key", slide_x_mm=1.0, seed=1))
    right = (truth.contact[-1] > 0)[..., None] * np.float32([IMAGE_SIDE / 20.3, 0])
    assert made.truth.shear_change == pytest.approx(right, abs=0.01)
    assert np.array_equal(made.truth.mask, truth.contact.mean(axis=0))
    ends = stage_of(made.shown, "key", truth=made.truth)["truth"]
    tails, tips = np.array(ends).transpose(1, 0, 2)
    # To scale: where it touches it goes as far as it was slid.
    assert np.max(tips - tails, axis=0) == pytest.approx([1 / 20.3, 0], abs=1e-3)


def test_a_touch_is_made_of_numbers():
    assert touch_of("key", {"depth_mm": 1}, 2.0) == Touch("key", depth_mm=1.0, seed=2)


@pytest.mark.parametrize(
    ("name", "depth", "seed", "sentence"),
    [
        ("key", 0.6, "", "seed was left empty; give a number."),
        ("key", 0.6, float("nan"), "seed is nan, expected a whole number from 0."),
        ("key", None, 0, "depth_mm was left empty; give a number."),
        ("key", "deep", 0, "depth_mm is 'deep', expected a number."),
        (None, 0.6, 0, "There is no shape ''"),
    ],
)
def test_a_touch_that_is_not_whole_is_told_in_a_sentence(name, depth, seed, sentence):
    with pytest.raises(GeoTLMError) as caught:
        touch_of(name, {"depth_mm": depth}, seed)
    assert str(caught.value).startswith(sentence)


def test_what_is_read_and_what_is_true_stand_in_one_row(made):
    rows = {row["name"]: row for row in _rows(made)}
    assert list(rows) == ["turn", "across", "down", "press"]
    assert rows["across"]["true"] == made.facts["true"]["slide_x_px"]
    assert rows["across"]["text"].endswith(", true 11 px right")
    for row in rows.values():
        assert row["low"] < row["mean"] < row["high"]
