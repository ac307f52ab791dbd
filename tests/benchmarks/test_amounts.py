"""How far, and each component of a mixed motion: truths by hand, imprints moved by a known way."""

from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from geotlm_lm.benchmarks.amounts import (
    AMOUNTS,
    amount_in,
    amount_row,
    amount_rows,
    belief_prediction,
    fitted_twist,
    grades,
    is_near,
    known_amount,
    mixture_rows,
    words_prediction,
)
from geotlm_lm.benchmarks.candidates import CANDIDATES
from geotlm_lm.benchmarks.cases import half_of
from geotlm_lm.benchmarks.harness import Row, Run
from geotlm_lm.benchmarks.judging import Case
from geotlm_lm.benchmarks.rendering import tables
from geotlm_lm.benchmarks.variants import BELIEF, FITS, RIVALS
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import CAMERA_PX, IMAGE_SIDE
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.core.twist import COMPONENTS, Component, Twist
from geotlm_lm.data.labelled_recordings import WindowRow
from geotlm_lm.motion.belief import Belief
from geotlm_lm.query.values import Measure
from tests.probe.imprints import moved_clip, textured_imprint


def window(motion=Motion.CLOCKWISE, **values):
    return WindowRow(Path("x.mov"), 0, 9, motion, "cap", "caps", values)


@pytest.mark.parametrize(
    ("values", "amount"),
    [
        ({"rotation_deg_cw": "-20.0"}, 20.0),
        ({"rotation_deg_cw": "20.0", "rotation_deg_cw_search": "24.1"}, None),
        ({"rotation_deg_cw": "3.0", "rotation_deg_cw_cumulative": "4.9"}, 3.0),
        ({"rotation_deg_cw": "20.0", "rotation_deg_cw_search": ""}, 20.0),
        ({"rotation_deg_cw": "many"}, None),
    ],
)
def test_a_turn_is_known_where_its_measurements_agree(values, amount):
    assert known_amount(window(**values), "rotation") == amount


def moved(amount=20.0, size=(224, 224), motion=Motion.LEFT):
    frames = np.zeros((4, *size, 3), np.uint8)
    return Case(Clip(frames, background=frames[0]), motion, "caps", amount=amount)


@pytest.mark.parametrize(
    ("case", "value", "is_right"),
    [
        (moved(), 24.0, True),
        (moved(amount=5.0), 7.1, False),
        (moved(amount=5.0, size=(240, 320)), 7.8, True),
        (moved(amount=5.0, size=(240, 320), motion=Motion.UP), 7.2, False),
        (moved(5.0, (240, 320), Motion.CLOCKWISE), 7.1, False),
    ],
)
def test_a_pixel_of_the_tolerance_is_one_of_a_224_pixel_image(case, value, is_right):
    assert is_near(case, value) is is_right


def test_a_row_tells_nearness_span_and_probability():
    clips = [moved(amount=20.0), moved(amount=10.0)]
    told = [Measure("slide", 22.0, 2.0, "px", 2.0), Measure("slide", 20.0, 4.0, "px", 2.0)]
    found = amount_row("slides", BELIEF, list(zip(clips, told, strict=True)), seed=0)
    assert (found.count, found.error, found.detail["in_span"]) == (2, 0.5, 0.5)
    assert found.detail["off_by"] == pytest.approx((0.1 + 1.0) / 2)
    assert found.detail["mean_probability"] == pytest.approx(np.mean([p.probability for p in told]))


@pytest.mark.parametrize("rival", FITS.values())
@pytest.mark.parametrize("way", [(12.0, 0.0), (0.0, -9.0)])
def test_a_rival_tells_a_slide_in_the_pixels_of_the_picture_it_was_given(way, rival):
    rows, columns = CAMERA_PX
    taken = moved_clip(textured_imprint(3, rows, columns), [0, 0], [(0.0, 0.0), way], noise=0)
    square = (IMAGE_SIDE, IMAGE_SIDE)
    frames = [cv2.resize(frame, square, interpolation=cv2.INTER_AREA) for frame in taken.frames]
    squashed = Clip(np.stack(frames), background=cv2.resize(taken.background, square))
    for clip, height, width in ((taken, rows, columns), (squashed, *square)):
        found = amount_in(Case(clip, Motion.LEFT, "caps"), fitted_twist(rival, clip))
        expected = np.hypot(way[0] * width / columns, way[1] * height / rows)
        assert found == pytest.approx(expected, rel=0.05)


@pytest.fixture
def folder(tmp_path):
    """A recording of noise and a table that tells one turn and one slide, and not another."""
    rng = np.random.default_rng(0)
    (tmp_path / "clips").mkdir()
    np.save(tmp_path / "clips" / "a.npy", rng.integers(90, 110, (12, 48, 64, 3)).astype(np.uint8))
    (tmp_path / "windows.csv").write_text(
        "clip,first_frame,last_frame,direction,rotation_deg_cw,dx_px,dy_px\n"
        "clips/a.npy,2,8,clockwise,12.0,,\nclips/a.npy,2,8,left,,-6.0,1.0\n"
        "clips/a.npy,2,8,left,,,\n"
    )
    return tmp_path


def test_every_method_is_told_of_every_source_and_half(folder, tiny_answerer):
    run = Run(is_quick=True, real=folder, answerer_given=tiny_answerer)
    rows = [Row.from_dict(one.to_dict()) for one in amount_rows(run)]
    cases = list(dict.fromkeys(one.case for one in rows))
    assert cases[:2] == ["simulated rotation", "simulated sliding"]
    half = half_of("a")
    assert cases[2:] == [f"real {folder.name}, {task}, {half}" for task in ("rotation", "sliding")]
    assert [one.variant for one in rows] == [BELIEF, *CANDIDATES, *FITS] * 4
    assert {one.count for one in rows[16:]} == {2}  # one turn, one slide, both played backwards too
    assert sum(one.count("\n") - 1 for one in tables(AMOUNTS, rows) if one[0] == "|") == len(rows)


SHOWS = (9.0, 9.0, 9.0)


def label(turn=12.0, travel=(-6.0, 1.0), inward=0.0, visible=SHOWS):
    return MotionLabel(
        Motion.CLOCKWISE,
        rotation_deg=turn,
        depth_change_mm=inward,
        travel_px=travel,
        radius_px=30.0,
        visible_grey=visible,
    )


def belief(turn=11.0, travel=(-5.0, 2.0), inward=0.02, turns=0.9, slides=0.8, presses=0.1):
    ways = dict.fromkeys(Motion, 0.0)
    ways[Motion.CLOCKWISE if turn > 0 else Motion.COUNTERCLOCKWISE] = turns
    ways[Motion.LEFT] = slides
    ways[Motion.PRESS] = presses
    return Belief(
        mean=Twist(turn, *travel, inward),
        covariance=np.diag([1.0, 1.0, 1.0, 0.01]),
        ways=ways,
        contact=1.0,
        radius_px=30.0,
        readable=dict.fromkeys(COMPONENTS, True),
    )


def graded(truth, told):
    return dict(grades(truth, belief_prediction(told)))


@pytest.mark.parametrize(
    ("told", "wrong"),
    [
        (belief(), []),
        (belief(turn=-11.0), ["turn: way", "turn and slide: both ways"]),
        (belief(turn=20.0), ["turn: how far", "turn: span"]),
        (belief(slides=0.4), ["slide: counts", "turn and slide: both ways"]),
    ],
)
def test_each_part_is_wrong_for_its_own_reason(told, wrong):
    assert [name for name, right in graded(label(), told).items() if not right] == wrong


@pytest.mark.parametrize(
    ("truth", "left_out"),
    [
        (label(turn=0.4), "turn"),  # 0.21 px at the radius: ambiguous
        (label(visible=(1.0, 9.0, 9.0)), "turn"),
        (label(inward=0.03), "press"),
        (label(inward=0.3, visible=(9.0, 9.0, 1.0)), "press"),
    ],
)
def test_what_is_ambiguous_or_does_not_show_is_left_out(truth, left_out):
    found = graded(truth, belief())
    assert not any(name.startswith(f"{left_out}:") for name in found)
    assert ("turn and slide: both ways" in found) == (left_out == "press")


def test_what_moves_barely_is_graded_apart():
    found = graded(label(turn=1.2, inward=0.1), belief())  # 0.63 px at the radius
    barely = {name.partition(", ")[0] for name in found if name.endswith(", 0.3 to 1 px")}
    parts = {f"turn: {what}" for what in ("counts", "way", "how far", "span")}
    assert barely == parts | {"turn and slide: both ways"}
    assert {"slide: way", "press: counts, 0.06 to 0.15 mm"} <= set(found)
    assert not parts & set(found)


def test_words_are_asked_of_each_component_and_name_its_way_or_deny_it():
    def ask(encoded, question):
        decided = "yes" if "lifting" in question else "no"
        return SimpleNamespace(in_the_image=Motion.CLOCKWISE, decided=decided)

    told = words_prediction(SimpleNamespace(ask=ask), None)
    counting = {Component.TURN: True, Component.SLIDE: False, Component.PRESS: True}
    assert told.counting == counting
    found = dict(grades(label(inward=-0.4), told))
    assert {name for name, right in found.items() if not right} == {
        "slide: counts",
        "slide: way",
        "turn and slide: both ways",
    }


def test_mixtures_of_the_simulator_are_graded_by_every_method(tiny_answerer):
    rows = mixture_rows(Run(is_quick=True, answerer_given=tiny_answerer))
    assert {row.variant for row in rows} == {BELIEF, "words", *CANDIDATES, *RIVALS}
    assert all("simulated mixtures, " in row.case and 0 < row.count <= 6 for row in rows)
