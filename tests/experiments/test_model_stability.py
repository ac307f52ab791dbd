"""What is done to clips is what the table says, and whatever comes of it becomes a row."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import GeoTLMError, UnreadableClip
from geotlm_lm.core.labels import Motion
from geotlm_lm.experiments import extreme_clips as extremes
from geotlm_lm.experiments.compare import Case
from geotlm_lm.experiments.degradations import degradations
from geotlm_lm.experiments.judging import Verdict, judge, tally
from geotlm_lm.experiments.model_stability import damage_rows, extreme_rows, stiff_rows
from geotlm_lm.experiments.simulator_stability import CASES as STIFF

SIDE = 64


class Saying:
    """Answers every clip by one function of it."""

    def __init__(self, motion=Motion.RIGHT, confidence=0.95, abstained=False, error=None):
        self.answer = SimpleNamespace(
            direction=motion, confidence=confidence, abstained=abstained, text="Right."
        )
        self.error, self.clips = error, []

    def encode(self, clip):
        self.clips.append(clip)
        if self.error:
            raise self.error
        return clip

    def ask(self, encoded, question):
        return self.answer


def touched():
    """A square imprint left of the middle that travels to the right over a flat gel."""
    idle = np.full((SIDE, SIDE, 3), 100, np.uint8)
    frames = np.repeat(idle[None], 4, axis=0)
    for number in range(4):
        frames[number, 28:36, 8 + 2 * number : 16 + 2 * number] = 140
    return Clip(frames, background=idle, name="touch")


def degraded(name, level):
    return degradations()[name].levels[level](touched(), np.random.default_rng(0))


def change(clip):
    return np.abs(clip.frames.astype(float) - touched().frames).mean()


@pytest.mark.parametrize("name", ["camera noise", "JPEG", "brightness drift", "gain drift"])
def test_every_level_of_a_damage_changes_more_than_the_one_before(name):
    changes = [change(degraded(name, level)) for level in degradations()[name].levels]
    assert changes == sorted(changes)
    assert changes[0] < changes[-1]


def test_a_pixel_that_is_exposed_too_long_is_white_and_not_dark_again():
    clip = degraded("overexposed", "5")
    assert clip.frames.min() == 255
    assert degraded("underexposed", "0.1").background.max() == 10


def test_an_imprint_near_the_border_is_the_same_imprint_further_right():
    moved = degraded("contact at the border", "80").frames[0, 32, :, 0]
    distance = round(80 * SIDE / 224)  # px of the 224 image
    before = touched().frames[0, 32, :, 0]
    assert np.argmax(moved > 120) == pytest.approx(np.argmax(before > 120) + distance, abs=1)
    assert moved.max() == 140


def test_dropped_frames_leave_fewer_and_repeated_ones_as_many():
    assert [len(degraded("frames dropped", count)) for count in "123"] == [3, 2, 1]
    ends = [degraded("frames dropped", count).frame_numbers for count in "12"]
    assert [(one[0], one[-1]) for one in ends] == [(0, 3), (0, 3)]  # as far as the whole clip
    frames = degraded("frames repeated", "2").frames
    assert np.array_equal(frames[0], frames[2])
    assert np.array_equal(frames[3], touched().frames[3])


def test_a_fainter_contact_keeps_its_share_of_the_contrast():
    assert degraded("fainter contact", "0.2").frames.max() == 108


@pytest.mark.parametrize("codec", ["MJPG", "XVID", "mp4v"])
def test_a_film_of_a_clip_looks_like_it(codec):
    clip = degraded("video", codec)
    assert clip.frames.shape == touched().frames.shape
    assert 0 < change(clip) < 8


@pytest.mark.parametrize(
    ("answerer", "outcome"),
    [
        (Saying(Motion.RIGHT), "right"),
        (Saying(Motion.LEFT), "wrong"),
        (Saying(None, 0.0, abstained=True), "abstained"),
        (Saying(error=UnreadableClip("touch: is black")), "refused"),
        (Saying(error=ZeroDivisionError("division by zero")), "crashed"),
    ],
)
def test_every_end_of_a_question_has_its_name(answerer, outcome):
    verdict = judge(answerer, touched, {Motion.RIGHT})
    assert verdict.outcome == outcome
    assert verdict.says in ("Right.", "touch: is black", "ZeroDivisionError: division by zero")


def test_where_nothing_can_be_told_every_answer_is_wrong():
    assert judge(Saying(Motion.NONE), touched, frozenset()).outcome == "wrong"


def test_a_row_counts_outcomes_and_quotes_the_gravest():
    row = tally(
        [
            Verdict("right", 0.8, "yes", 0.1),
            Verdict("wrong", 0.95, "no", 0.3, Motion.LEFT),
            Verdict("wrong", 0.5, "hm", 0.1, Motion.STILL),
            Verdict("wrong", 0.75, "hm", 0.1, Motion.UP),
            Verdict("wrong", 0.9, "hm", 0.1, Motion.NONE),
            Verdict("refused", 0.0, "black", 0.1),
        ]
    )
    assert (row["right"], row["wrong"], row["refused"], row["crashed"]) == (1, 4, 1, 0)
    assert row["accuracy_of_answers"] == pytest.approx(1 / 5)
    assert row["confidence"] == pytest.approx(0.78)
    assert row["confidence_wrong"] == 0.95
    assert (row["false_directions"], row["confident_false_directions"]) == (2, 1)
    assert row["confident_oversights"] == 1
    assert (row["says"], row["slowest_s"]) == ("no", 0.3)


def test_a_row_without_an_answer_has_no_confidence():
    row = tally([Verdict("refused", 0.0, "black", 0.1)])
    assert row["confidence"] is row["accuracy_of_answers"] is row["confidence_wrong"] is None


CASE = Case(touched(), Motion.RIGHT, "block", "block", {})


def test_damage_is_asked_about_level_by_level():
    kinds = {name: degradations()[name] for name in ("as recorded", "frames dropped")}
    kinds["as recorded"] = replace(kinds["as recorded"], clips=1)
    answerer = Saying(Motion.RIGHT)
    rows = damage_rows(answerer, [CASE, CASE], kinds, 0)
    assert [(row["case"], row["level"], row["clips"]) for row in rows] == [
        ("as recorded", "-", 1),
        ("frames dropped", "1", 2),
        ("frames dropped", "2", 2),
        ("frames dropped", "3", 2),
    ]
    assert len(answerer.clips) == 7


def test_every_extreme_recording_is_made_or_refused_in_a_sentence(monkeypatch):
    monkeypatch.setattr(extremes, "LONG_FRAMES", 400)
    refused = {}
    for name, extreme in extremes.extreme_clips(touched(), Motion.RIGHT).items():
        try:
            extreme.make()
        except GeoTLMError as error:
            refused[name] = str(error)
    assert set(refused) == {
        "7x7 pixels",
        "four colours",
        "no colour axis",
        "16-bit values",
        "a NaN in one frame",
        "background of another size",
    }


def test_an_extreme_recording_that_crashes_the_model_is_a_row(monkeypatch):
    monkeypatch.setattr(extremes, "LONG_FRAMES", 400)
    rows = extreme_rows(Saying(error=KeyError("token")), [CASE])
    assert {row["case"]: row["says"] for row in rows}["black"] == "KeyError: 'token'"


def test_stiff_scenes_are_simulated_and_asked_about_or_refused():
    names = ("friction 0", "depth -0.5 mm", "slide 8 mm", "depth NaN")
    answerer = Saying(Motion.CLOCKWISE)
    rows = {row["case"]: row for row in stiff_rows(answerer, {n: STIFF[n] for n in names}, 0)}
    assert rows["friction 0"]["right"] == 1
    assert rows["depth -0.5 mm"]["wrong"] == 1  # nothing touches, and clockwise was said
    assert rows["slide 8 mm"]["wrong"] == 1
    assert rows["depth NaN"]["refused"] == 1
    assert rows["friction 0"]["solver"] == "good, converged"
    assert all(len(clip) == 4 for clip in answerer.clips)
