"""Numerics of the pooling, and the same model in other number formats; weights are random."""

import numpy as np
import pytest

from geotlm_lm.answering import Answerer
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import Motion
from geotlm_lm.experiments.model_numerics import (
    MASKS,
    SCALES,
    Truths,
    gradient_rows,
    mass_floor_rows,
    precision_rows,
    scale_rows,
)
from tests.tiny_bundle import tiny_bundle


@pytest.fixture(scope="module")
def answerer():
    return Answerer(tiny_bundle())


@pytest.fixture(scope="module")
def truths():
    idle = np.full((48, 48, 3), 100, np.uint8)
    frames = np.repeat(idle[None], 4, axis=0)
    for number in range(4):
        frames[number, 20:28, 10 + 4 * number : 20 + 4 * number] = 140
    return Truths([Clip(frames, background=idle)], [Motion.RIGHT])


def test_the_floor_shrinks_as_its_closed_form_says_and_the_mass_undoes_it():
    rows = [row for row in mass_floor_rows() if row["contact"] == "everywhere"]
    for row in rows:
        # 196 cells of the mask over themselves and the floor.
        expected = 196 * row["mask"] / (196 * row["mask"] + 1e-6)
        assert row["global"] == pytest.approx(expected, rel=1e-5)
        assert row["recovered"] == pytest.approx(1.0, rel=1e-5)
        assert row["mass"] == pytest.approx(row["mask"], rel=1e-5)
    assert len(rows) == len(MASKS)


def test_an_empty_half_reads_as_a_difference_and_its_mass_says_so():
    halves = [row for row in mass_floor_rows() if row["contact"] == "lower half"]
    full = halves[0]
    assert full["upper_minus_lower"] == pytest.approx(-1.0, rel=1e-5)
    assert full["mass_upper_minus_lower"] == 0


def test_gradients_stay_finite_and_right_while_contact_vanishes():
    rows = gradient_rows()
    assert all(
        np.isfinite([row["by_field"], row["by_mask"], row["by_logit"]]).all() for row in rows
    )
    assert all(row["checked"] for row in rows)
    by_logit = [row["by_logit"] for row in rows]
    assert by_logit[-1] < 1e-3 * max(by_logit)  # 98e-12 against a floor of 1e-6
    # By the mask itself it grows tenfold a decade until the floor holds it.
    assert rows[4]["by_mask"] / rows[3]["by_mask"] == pytest.approx(10, rel=0.2)


def test_coarser_formats_err_more(answerer, truths):
    rows = [r for r in precision_rows(answerer, truths) if r["parts"] == "geometry"]
    errors = {row["precision"]: row["descriptor_error"] for row in rows}
    assert 0 == errors["float64"] < errors["float32"] < errors["float16"] < errors["bfloat16"]
    assert errors["float32"] < 1e-4
    assert all(row["is_finite"] for row in rows)


def test_statistics_that_are_scaled_along_take_a_scale_out_again(answerer, truths):
    rows = scale_rows(answerer, truths)
    along = [row for row in rows if row["statistics"] == "scaled along"]
    assert [row["factor"] for row in along] == list(SCALES)
    said = [row["confidence"] or 0.0 for row in along]
    assert max(said) - min(said) < 1e-3
    assert len(rows) == 2 * len(SCALES)
