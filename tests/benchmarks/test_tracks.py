"""Tracks of known turns are graded by labels that are off by known amounts."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from geotlm_lm.benchmarks import tracks
from geotlm_lm.benchmarks.harness import Run
from geotlm_lm.benchmarks.tracks import TRACKS, graded_rows, passed_s, track_grades
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.twist import Component
from geotlm_lm.data.touch_table import CurvePoint, GoldTurn, Moment, Quality, TouchRow
from tests.track.tracks import moving_track

FPS, FIRST, LAST = 25.0, 10, 50


def turning(turn_deg):
    """A track that turns evenly from the first labelled frame to the last, and rests before it."""
    steps = np.zeros((60, 4))
    steps[FIRST + 1 : LAST + 1, 0] = turn_deg / (LAST - FIRST)
    return moving_track(steps, ())


def label(turn_deg=80.0, quality=Quality.SURE, **course):
    recording = TouchRow(Path("a.mov"), FPS, 8, 55, "cap", "caps")
    return GoldTurn(recording, FIRST, LAST, turn_deg, 6.0, quality, (FIRST, LAST), "", **course)


def grades(gold, turn_deg):
    return dict(track_grades(gold, turning(turn_deg).between(FIRST, LAST)))


@pytest.mark.parametrize(
    ("turn_deg", "gold", "right"),
    [
        (72.5, label(), {"direction", "within a fifth", "within a tenth"}),
        (68.0, label(), {"direction", "within a fifth"}),
        (60.0, label(), {"direction"}),
        (68.0, label(quality=Quality.FAIR), {"direction", "within a fifth", "within a tenth"}),
        (60.0, label(quality=Quality.FAIR), {"direction", "within a fifth"}),
        (-72.5, label(-80.0), {"direction", "within a fifth", "within a tenth"}),
        (15.5, label(20.0), {"direction", "within a fifth", "within a tenth"}),
        (-80.0, label(), set()),
        (0.0, label(), set()),
    ],
)
def test_a_turn_is_right_within_its_tolerance(turn_deg, gold, right):
    graded = grades(gold, turn_deg)
    shares = ("direction", "within a fifth", "within a tenth")
    assert {what for what in shares if graded[what]} == right
    assert graded["error, degrees"] == pytest.approx(abs(turn_deg - gold.turn_deg))
    assert graded["ratio to the label"] == pytest.approx(turn_deg / gold.turn_deg)


def test_a_span_may_miss_a_fair_label_by_its_half_width():
    net = turning(80.0).between(FIRST, LAST).net(Component.TURN)
    beyond = net.high + 3.0
    held = [grades(label(beyond, own), 80.0)["span"] for own in (Quality.SURE, Quality.FAIR)]
    assert held == [False, True]
    width = grades(label(), 80.0)["half-width of the span, share of its turn"]
    assert width == pytest.approx((net.high - net.low) / 2 / 80.0)


def test_a_curve_is_graded_beyond_its_first_frame():
    # True is 0 at frame 10, 40 at frame 30, 80 at frame 50.
    near, far = CurvePoint(30, 48.5, 4.0), CurvePoint(50, 95.0, 4.0)
    curve = (CurvePoint(FIRST, 0.0, 0.0), near, far)
    graded = list(track_grades(label(curve=curve), turning(80.0).between(FIRST, LAST)))
    assert [grade for what, grade in graded if what == "curve within a tenth"] == [True, False]
    errors = [grade for what, grade in graded if what == "curve, error, degrees"]
    assert errors == pytest.approx([8.5, 15.0])


@pytest.mark.parametrize(
    ("turn_deg", "half", "past_30", "right"),
    [
        (80.0, 30.0, 25.0, (True, True)),
        (80.0, 33.9, 28.9, (False, False)),
        (80.0, 33.4, 28.4, (True, True)),
        (20.0, 30.0, 25.0, (True, False)),
        (-80.0, 30.0, 25.0, (False, False)),
    ],
)
def test_a_moment_is_right_within_a_tenth_of_a_second(turn_deg, half, past_30, right):
    gold = label(half_turn=Moment(half, 1.0), past_30_deg=Moment(past_30, 1.0))
    graded = grades(gold, turn_deg)
    assert (graded["half the turn within 0.1 s"], graded["30 degrees within 0.1 s"]) == right
    if turn_deg == 80.0:
        assert graded["half the turn, error, seconds"] == pytest.approx((half - 30.0) / FPS)


def test_a_moment_lies_between_frames():
    track = turning(80.0).between(FIRST, LAST)
    assert passed_s(track, 31.0) == pytest.approx((FIRST + 15.5) / FPS)
    assert (passed_s(track, -31.0), passed_s(track, 81.0)) == (None, None)


def test_shares_and_medians_have_rows_of_their_own():
    graded = [("a", "track", right, "caps") for right in (True, False)]
    graded += [("b", "track", number, "caps") for number in (1.0, 2.0, 9.0)]
    share, median = graded_rows(graded, seed=0)
    assert (share.right, share.count, median.detail, median.count) == (0.5, 2, {"median": 2.0}, 3)


def test_poor_labels_are_left_out_and_rivals_stand_beside(monkeypatch):
    frames = np.full((60, 24, 32, 3), 100, np.uint8)
    shown = []

    class Model:
        def track(self, clip):
            shown.append((clip.frame_numbers[0], clip.background is not None))
            return turning(80.0) if len(clip) == 60 else turning(80.0).between(FIRST, LAST)

    monkeypatch.setattr(tracks, "read_clip", lambda path: Clip(frames, fps=FPS))
    monkeypatch.setattr(tracks, "streams", lambda count, seed: ())
    real = SimpleNamespace(folder=None)
    monkeypatch.setattr(tracks, "recordings_by_half", lambda folder: [("mine", "report", real)])
    turns = [label(), label(quality=Quality.POOR)]
    monkeypatch.setattr(tracks, "read_gold_turns", lambda folder: turns)
    monkeypatch.setattr(tracks, "rows_of_half", lambda rows, half: tuple(rows))
    rows = list(TRACKS.run(Run(answerer_given=Model())))
    assert {row.count for row in rows} == {1}
    assert shown == [(0, False), (FIRST, True)]
    rivals = {row.variant for row in rows if row.case.startswith("real mine, bracketed, report:")}
    assert rivals == {"track", "optical flow", "direct alignment"}
