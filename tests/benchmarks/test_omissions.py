"""What is left out is timed both ways and costs what it cannot tell; laws of physics and timing."""

from geotlm_lm.benchmarks.omissions import (
    OMISSIONS,
    Omission,
    model_omissions,
    omission_rows,
    scene_omissions,
)
from geotlm_lm.benchmarks.pareto_simulator import DRIFT, HEIGHT
from geotlm_lm.benchmarks.rendering import tables
from geotlm_lm.benchmarks.rows import Run
from geotlm_lm.simulation.contact import PRESETS


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
    assert "2 um; 0 grey" in tables(OMISSIONS.section("saved"), [row])[0]


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
