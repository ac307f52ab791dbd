"""How far: truths from tables and simulator, tolerances, and the page made of them."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import CAMERA_PX, IMAGE_SIDE
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.record import RunRecord
from geotlm_lm.data.labelled_recordings import WindowRow
from geotlm_lm.experiments.how_far import (
    FLOW,
    ODOMETER,
    Moved,
    Told,
    flow_tells,
    how_far,
    is_within_tolerance,
    known_amount,
    real,
    scores,
    simulated,
)
from geotlm_lm.reports.odometry import odometry_page
from tests.answering.scripted import answerer_saying
from tests.probe.imprints import moved_clip, textured_imprint
from tests.tiny_bundle import tiny_bundle


def row(motion=Motion.CLOCKWISE, **values):
    return WindowRow(Path("x.mov"), 0, 9, motion, "cap", "caps", values)


@pytest.mark.parametrize(
    ("values", "amount"),
    [
        ({"rotation_deg_cw": "-20.0"}, 20.0),
        ({"rotation_deg_cw": "20.0", "rotation_deg_cw_search": "23.9"}, 20.0),
        ({"rotation_deg_cw": "20.0", "rotation_deg_cw_search": "24.1"}, None),
        ({"rotation_deg_cw": "3.0", "rotation_deg_cw_cumulative": "4.9"}, 3.0),
        ({"rotation_deg_cw": "20.0", "rotation_deg_cw_search": ""}, 20.0),
        ({"rotation_deg_cw": "0"}, None),
        ({"rotation_deg_cw": "many"}, None),
        ({}, None),
    ],
)
def test_a_turn_is_known_where_its_measurements_agree(values, amount):
    assert known_amount(row(**values), "deg") == amount


def test_a_slide_is_known_by_both_its_components():
    told = {"dx_px": "-3.0", "dy_px": "4.0"}
    assert known_amount(row(Motion.LEFT, **told), "px") == pytest.approx(5.0)
    assert known_amount(row(Motion.LEFT, dx_px="3.0"), "px") is None
    assert known_amount(row(Motion.CLOCKWISE, **told), "px") is None
    apart = told | {"dx_px_cumulative": "-6.0", "dy_px_cumulative": "8.0"}
    assert known_amount(row(Motion.LEFT, **apart), "px") is None


def moved(unit="px", amount=20.0, size=(224, 224), motion=Motion.LEFT):
    frames = np.zeros((4, *size, 3), np.uint8)
    return Moved(Clip(frames, background=frames[0]), unit, amount, motion, "caps")


@pytest.mark.parametrize(
    ("one", "value", "is_right"),
    [
        (moved(), 24.0, True),
        (moved(), 24.1, False),
        (moved(amount=5.0), 6.9, True),
        (moved(amount=5.0), 7.1, False),
        (moved(amount=5.0, size=(240, 320)), 7.8, True),
        (moved(amount=5.0, size=(240, 320), motion=Motion.UP), 7.2, False),
        (moved(amount=5.0, size=(240, 320), motion=Motion.UP), 7.1, True),
        (moved("deg", 5.0, (240, 320)), 7.1, False),
    ],
)
def test_a_pixel_of_the_tolerance_is_one_of_a_224_pixel_image(one, value, is_right):
    assert is_within_tolerance(one, value) is is_right


def test_scores_tell_nearness_span_and_probability():
    clips = [moved(amount=20.0), moved(amount=10.0)]
    said = [Told(22.0, 19.0, 25.0, 0.9), Told(20.0, 15.0, 25.0, 0.5)]
    found = scores(clips, said, seed=0)
    assert (found["clips"], found["in_tolerance"], found["in_span"]) == (2, 0.5, 0.5)
    assert found["median_error"] == pytest.approx((0.1 + 1.0) / 2)
    assert found["median_ratio"] == pytest.approx((1.1 + 2.0) / 2)
    assert found["mean_probability"] == pytest.approx(0.7)
    plain = scores(clips, [Told(22.0), Told(20.0)], seed=0)
    assert plain["in_span"] is plain["mean_probability"] is None


def test_simulated_clips_know_their_amounts_and_flow_finds_most_of_a_slide():
    sources = simulated(2, seed=0)
    assert list(sources) == [
        "simulated rotation",
        "simulated sliding",
        "simulated rotation, unsteady hand",
        "simulated sliding, unsteady hand",
    ]
    (turn, _), (slide, other) = (list(sources[name]()) for name in list(sources)[:2])
    assert (turn.unit, slide.unit) == ("deg", "px")
    assert 3 <= turn.amount <= 40
    assert slide.amount > 0
    told = [flow_tells(one).value / one.amount for one in (slide, other)]
    assert all(0.2 < share < 1.5 for share in told)


@pytest.mark.parametrize("way", [(12.0, 0.0), (0.0, -9.0)])
def test_flow_tells_a_slide_in_the_pixels_of_the_picture_it_was_given(way):
    rows, columns = CAMERA_PX
    slides = [(0.0, 0.0), way]
    taken = moved_clip(textured_imprint(3, rows, columns), [0, 0], slides, noise=0)
    square = (IMAGE_SIDE, IMAGE_SIDE)
    squashed = Clip(
        np.stack(
            [cv2.resize(frame, square, interpolation=cv2.INTER_AREA) for frame in taken.frames]
        ),
        background=cv2.resize(taken.background, square),
    )
    for clip, height, width in ((taken, rows, columns), (squashed, *square)):
        found = flow_tells(Moved(clip, "px", 1.0, Motion.LEFT, "caps")).value
        expected = np.hypot(way[0] * width / columns, way[1] * height / rows)
        assert found == pytest.approx(expected, rel=0.05)


def recordings(folder):
    """A folder with one recording of noise and a table that tells one turn and one slide."""
    rng = np.random.default_rng(0)
    (folder / "clips").mkdir()
    np.save(folder / "clips" / "a.npy", rng.integers(90, 110, (12, 48, 64, 3)).astype(np.uint8))
    (folder / "windows.csv").write_text(
        "clip,first_frame,last_frame,direction,rotation_deg_cw,dx_px,dy_px\n"
        "clips/a.npy,2,8,clockwise,12.0,,\nclips/a.npy,2,8,left,,-6.0,1.0\n"
        "clips/a.npy,2,8,left,,,\n"
    )
    return folder


def test_real_windows_are_taken_where_a_table_tells_how_far(tmp_path):
    folder = recordings(tmp_path)
    sources = real(folder, seed=0)
    name = folder.name
    assert list(sources) == [f"real {name}, rotation", f"real {name}, sliding"]
    turns, slides = (list(found()) for found in sources.values())
    assert [one.amount for one in turns] == [12.0, 12.0]
    assert [one.amount for one in slides] == pytest.approx([np.hypot(6, 1)] * 2)
    assert (turns[1].clip.frames == turns[0].clip.frames[::-1]).all()


def test_the_record_and_its_page_hold_every_source(tmp_path):
    answerer = answerer_saying(tiny_bundle(), {})
    record = how_far(answerer, clips=2, seed=0, real_folder=recordings(tmp_path))
    assert len(record.numbers) == 6
    one = record.numbers["simulated rotation"]
    assert one["unit"] == "deg"
    assert one[ODOMETER]["clips"] == one[FLOW]["clips"] == 2
    path = tmp_path / "odometry.json"
    record.save(path)
    page = odometry_page(RunRecord.load(path))
    assert page.count("\n| ") == 2 + len(record.numbers)
    assert "| simulated sliding " in page
