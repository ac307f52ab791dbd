"""Methods, commands and presets in turn, fronts, and what is left out; numbers by hand."""

import itertools
import subprocess

import numpy as np
import pytest

from geotlm_lm.benchmarks.harness import Row, Run
from geotlm_lm.benchmarks.judging import Case, Reply
from geotlm_lm.benchmarks.omissions import (
    SAVED,
    Omission,
    model_omissions,
    omission_rows,
    scene_omissions,
)
from geotlm_lm.benchmarks.pareto import (
    DRIFT,
    HEIGHT,
    METHODS,
    SIMULATOR,
    SOLVERS,
    case_sets,
    error_rows,
    rows_in_turn,
    run_fresh,
    scenes,
    with_front,
)
from geotlm_lm.benchmarks.rendering import tables
from geotlm_lm.benchmarks.variants import RIVALS, all_variants
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import ROTATIONS, Motion
from geotlm_lm.simulation.contact import PRESETS


def known(motion):
    return Case(Clip(np.zeros((4, 16, 16, 3), np.uint8)), motion, "ball")


def method(log, name):
    """Return a method that says "clockwise" and whose milliseconds count its calls."""
    calls = itertools.count(1)

    def ask(clip, among):
        log.append(name)
        return Reply(Motion.CLOCKWISE, float(next(calls)))

    return ask


def test_methods_are_asked_clip_by_clip_and_timed_in_the_rounds_that_count():
    log = []
    asked = {"a": method(log, "a"), "b": method(log, "b")}
    cases = [known(Motion.CLOCKWISE), known(Motion.LEFT)]
    first, second = rows_in_turn(asked, ("here", tuple(Motion), cases), 2, 0)
    assert "".join(log) == "abab" * 3
    assert (first.variant, second.variant, first.count, first.error) == ("a", "b", 2, 0.5)
    assert first.ms_p50 == np.median([3, 4, 5, 6])  # 1 and 2 warmed up


def test_clips_come_in_four_frames_and_two():
    found = list(case_sets(Run(is_quick=True)))
    assert [(title, len(cases), len(cases[0].clip)) for title, _, cases in found] == [
        ("simulated rotation, four frames", 2, 4),
        ("simulated rotation, pairs", 2, 2),
        ("simulated sliding, four frames", 2, 4),
        ("simulated sliding, pairs", 2, 2),
    ]
    assert all(case.motion in among for _, among, cases in found for case in cases)


def test_an_unreadable_clip_is_named_by_no_read_out_of_the_model(tiny_answerer):
    black = Clip(np.zeros((4, 32, 32, 3), np.uint8), background=np.zeros((32, 32, 3), np.uint8))
    asked = {
        name: own for name, own in all_variants(tiny_answerer, 0).items() if name not in RIVALS
    }
    assert {ask(black, ROTATIONS).motion for ask in asked.values()} == {None}


def row(name, error, ms, source="rotation", p95=None):
    case = f"simulated {source}, four frames"
    return Row(case, name, 9, error, interval=(0, 1), ms_p50=ms, ms_p95=p95 or ms)


ROWS = with_front(
    [
        row("optical flow, fast", 0.10, 5.0),
        row("linear probe", 0.025, 30.0, p95=38.0),
        row("another probe", 0.02, 36.0, p95=45.0),
        row("words", 0.005, 42.0, p95=60.0),
        row("words, rarer", 0.01, 39.0, p95=50.0),
        row("words, slower", 0.005, 60.0, p95=80.0),
    ]
)
BOTH = ROWS + [Row(**vars(one) | {"case": "simulated sliding, four frames"}) for one in ROWS]


def test_the_front_holds_what_nothing_beats_in_both():
    def front(rows):
        return [one.variant for one in with_front(rows) if one.detail["is_on_front"]]

    assert front(ROWS) == [one.variant for one in ROWS[:5]]
    assert front([row("a", 0.1, 5.0), row("b", 0.1, 5.0)]) == ["a", "b"]


def test_the_methods_are_shown_in_a_table_and_drawn(tmp_path):
    methods = METHODS
    simulated, _, real = "\n".join(
        tables(methods, [*BOTH, Row(**vars(ROWS[1]) | {"case": "real set, four frames"})])
    ).rpartition("### Real recordings")
    assert "optical flow, fast * |        5.0 |  5.0 | 0.100" in simulated
    assert "real set" in real
    methods.figure(BOTH, tmp_path / "methods.png")
    assert (tmp_path / "methods.png").stat().st_size > 5_000


def test_a_process_that_fails_raises_and_others_give_their_lines():
    assert run_fresh("import sys; print(sys.argv[1], input())", "asked") == [
        "asked Which way is it moving?"
    ]
    with pytest.raises(subprocess.CalledProcessError, match="exit status 3"):
        run_fresh("exit(3)")


def test_finer_presets_err_less_and_what_leaves_out_physics_more(tmp_path):
    asked = {
        name: SOLVERS[name]
        for name in ("fast", "draft", "half-space, 64 cells", "geometric overlap")
    }
    rows = list(error_rows({"slide": scenes()["ball, slide"]}, asked, "good", 1))
    for measure in dict.fromkeys(one.case for one in rows):
        errors = {one.variant: one.error for one in rows if one.case == measure}
        assert errors["good"] == 0
        assert errors["fast"] < errors["draft"]
        assert errors["fast"] < 0.2 * errors["half-space, 64 cells"]
        # No elasticity: it is cheap, wrong, and tells no drift.
        assert errors.get("geometric overlap", np.inf) > errors["draft"]
    SIMULATOR.figure(rows, tmp_path / "simulator.png")
    assert (tmp_path / "simulator.png").stat().st_size > 5_000


def test_both_ways_take_turns_and_are_told_with_their_difference():
    log = []
    one = Omission(
        "all of it",
        "always",
        lambda: log.append("full") or 5.0,
        lambda: log.append("lean") or 3.0,
        lambda full, lean: {"um": full - lean, "grey": 0.0},
    )
    (row,) = omission_rows([one], 2)
    assert log == ["full", "lean", "lean", "full", "full", "lean"]  # to warm up, and twice
    assert (row.case, row.count, row.detail["costs"]) == ("all of it", 2, {"um": 2.0, "grey": 0.0})
    low, middle, high = row.detail["saved_ms"]
    assert low <= middle <= high
    assert "2 um; 0 grey" in tables(SAVED, [row])[0]


def test_what_the_model_leaves_out_changes_no_answer(tiny_answerer):
    omissions = model_omissions(Run(answerer_given=tiny_answerer))
    rows = {one.case: one for one in omission_rows(omissions, 1)}
    assert rows["encoding again"].detail["costs"] == {"of answers changed": 0}
    assert rows["the language model"].detail["costs"] == {}


def test_an_omission_costs_what_it_cannot_tell_and_little_else():
    untold, slippery, coarse = (
        one.cost(one.full(), one.lean()) for one in scene_omissions(PRESETS["draft"])
    )
    # The key is pressed in by 600 um: none of it moves the surface by a twentieth of that.
    assert all(0 < one[HEIGHT] < 30 for one in (untold, slippery, coarse))
    assert DRIFT not in untold
    assert coarse[DRIFT] < 0.2 < slippery[DRIFT]
