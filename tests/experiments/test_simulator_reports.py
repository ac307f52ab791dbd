"""The simulator's own reports on a few scenes: the presets' order, and every outcome's name."""

from dataclasses import replace

import numpy as np
import pytest

from geotlm_lm.core.record import RunRecord
from geotlm_lm.experiments.simulator_error import (
    overlap_surface,
    scenes,
    simulator_error,
    variants,
)
from geotlm_lm.experiments.simulator_omissions import omission_rows, omissions
from geotlm_lm.experiments.simulator_rate import simulator_rates
from geotlm_lm.experiments.simulator_stability import CASES, simulator_stability
from geotlm_lm.reports.simulator import (
    draw_error,
    error_table,
    omission_table,
    rate_table,
    stability_table,
)
from geotlm_lm.simulation.presets import PRESETS
from geotlm_lm.simulation.profile import build_profile


@pytest.fixture(scope="module")
def record() -> RunRecord:
    chosen = {name: scenes()[name] for name in ("ball, slide", "key, press")}
    names = ("good", "draft", "draft, no friction", "half-space, 64 cells", "geometric overlap")
    asked = {name: variants()[name] for name in names}
    return simulator_error(chosen=chosen, asked=asked, reference="accurate", repeats=1)


def row(record, scene, variant):
    return next(
        one for one in record.numbers["rows"] if (one["scene"], one["variant"]) == (scene, variant)
    )


def test_the_reference_has_no_error_against_itself(record):
    own = row(record, "ball, slide", "accurate")
    assert own["height_um"] == own["drift_share"] == own["image_grey"] == 0


def test_finer_presets_err_less_and_what_leaves_out_physics_more(record):
    def errors(variant, measure):
        return row(record, "ball, slide", variant)[measure]

    for measure in ("height_um", "drift_share"):
        assert errors("good", measure) < errors("draft", measure)
        assert errors("draft", measure) < errors("geometric overlap", measure)
    assert errors("good", "height_um") < 0.2 * errors("half-space, 64 cells", "height_um")


def test_what_was_not_asked_for_has_no_error(record):
    assert row(record, "ball, slide", "draft, no friction")["drift_share"] is None


def test_the_overlap_goes_along_with_the_object():
    scene = scenes()["key, slide"]
    surface = overlap_surface(scene, build_profile(scene.body))
    touched = surface.touches[-1]
    assert surface.drift_mm[-1, 0][touched] == pytest.approx(0.9, abs=1e-5)
    assert not surface.drift_mm[-1, 1][touched].any()
    assert not surface.drift_mm[0].any()


def test_the_table_and_the_figure_hold_every_variant(record, tmp_path):
    text = error_table(record)
    for variant in ("good", "half-space, 64 cells", "geometric overlap"):
        assert f"| {variant} " in text
    draw_error(record, tmp_path / "errors.png")
    assert (tmp_path / "errors.png").stat().st_size > 10_000


def test_a_case_is_solved_or_refused_in_both_precisions():
    names = ("key, 9 degree turn", "depth -0.5 mm", "depth NaN", "friction 1e6")
    rows = simulator_stability(cases={name: CASES[name] for name in names}).numbers["rows"]
    assert [one["precision"] for one in rows] == ["float32", "float64"] * 4
    outcomes = {one["case"]: one["outcome"] for one in rows}
    assert outcomes == dict.fromkeys(names, "solved") | {"depth NaN": "refused"}
    single, double = (one["farthest_drift_mm"] for one in rows[:2])
    assert single == pytest.approx(double, rel=1e-3)
    assert np.isfinite([one.get("deepest_mm", 0) for one in rows]).all()


def test_the_stability_table_says_why_a_case_was_refused():
    asked = {name: CASES[name] for name in ("depth 0", "friction NaN")}
    text = stability_table(simulator_stability(cases=asked))
    assert "refused: the friction coefficient is nan, expected 0 to 1e+09" in text
    assert text.count("| depth 0 ") == 2


@pytest.fixture(scope="module")
def omitted() -> dict[str, list[dict]]:
    """One scene of each omission, at the coarsest preset, timed twice."""
    asked = {
        name: replace(one, scenes=dict([next(iter(one.scenes.items()))]))
        for name, one in omissions(PRESETS["draft"]).items()
    }
    rows = omission_rows(asked, repeats=2)
    return {name: [row for row in rows if row["omission"] == name] for name in asked}


def only(omitted, name):
    (found,) = omitted[name]
    return found


def test_every_omission_leaves_out_what_it_says(omitted):
    free = only(omitted, "friction, where no shear is asked for")
    assert "frictional_contact" in free["full_stages"]
    assert "frictional_contact" not in free["lean_stages"]
    smooth = only(omitted, "fine profile of smooth bodies")
    assert set(smooth["full_stages"]) - set(smooth["lean_stages"]) == {"fine_profile"}
    bare = only(omitted, "pictures, for labels only")
    assert set(bare["full_stages"]) - set(bare["lean_stages"]) == {"optics"}
    assert all(len(row[way]) == 2 for (row,) in omitted.values() for way in ("full_ms", "lean_ms"))


def test_an_omission_costs_what_it_cannot_tell_and_little_else(omitted):
    free = only(omitted, "friction, where no shear is asked for")
    # Of 0.9 mm at the rim of the turn, spread over the view; the height hardly changes.
    assert free["shear_um"] > 5
    assert free["height_um"] < 0.5 * free["shear_um"]
    assert only(omitted, "friction, in a press")["shear_um"] > 0.5
    assert only(omitted, "substeps of small steps")["shear_um"] < 0.2 * free["shear_um"]
    smooth = only(omitted, "fine profile of smooth bodies")
    assert smooth["height_um"] < 10
    assert smooth["shear_um"] is None
    bare = only(omitted, "pictures, for labels only")
    assert bare["height_um"] == 0
    assert bare["image_grey"] is None


def test_the_table_of_omissions_holds_every_one_with_what_it_saves():
    row = {"omission": "friction", "scene": "key", "timed": "surface", "height_um": 2.0}
    row |= {"shear_um": 30.0, "image_grey": None, "full_ms": [9.0, 5.0, 6.0]}
    row |= {"lean_ms": [3.0, 2.0, 2.0]}
    other = row | {"scene": "nut", "full_ms": [12.0] * 3, "lean_ms": [4.0] * 3}
    record = RunRecord("simulator", "", 0, 1.0, {"omissions": [row, other]})
    (line,) = [one for one in omission_table(record).splitlines() if one.startswith("| friction")]
    cells = [cell.strip() for cell in line.strip("|").split("|")]
    assert cells == [
        "friction (surface)",
        "key; nut",
        "6 (4-8)",
        "3 (3-3)",
        "2 (2-2)",
        "30 (30-30)",
        "-",
    ]


def test_rates_count_what_every_core_wrote_after_the_first_shard():
    kinds = {"pictures": {"preset": "draft"}, "labels": {"preset": "draft", "with_frames": False}}
    rows = simulator_rates(workers=2, kinds=kinds, repeats=1, shards_per_worker=2)
    assert [one["kind"] for one in rows] == ["pictures", "labels"]
    for one in rows:
        assert one["clips"] == 256
        assert 1 < one["clips_per_second"][0] < 1e5
        assert one["start_seconds"][0] > 0
    pictures, labels = (one["megabytes_per_worker"] for one in rows)
    assert (pictures is None and labels is None) or pictures > labels > 50
    text = rate_table(RunRecord("simulator", "", 0, 1.0, {"rates": rows}))
    assert "| pictures " in text
    assert "1 of 256" in text
