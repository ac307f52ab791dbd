"""Reasons read off fields whose motion is known in closed form."""

import numpy as np
import pytest
import torch

from geotlm_lm.answering.reasons import (
    contact_place,
    halves,
    own_view,
    pattern_of,
    reasoning_steps,
    times_step,
)
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.geometry import REGIONS
from geotlm_lm.core.labels import Motion
from geotlm_lm.dgr.regions import pool_regions, region_mass
from geotlm_lm.query.answers import answers
from geotlm_lm.query.lines import read
from geotlm_lm.query.reader import MISSING
from tests.query.programs import there_and_back

SIDE = 14
Y, X = np.mgrid[:SIDE, :SIDE] - (SIDE - 1) / 2


def regions_of(field_x, field_y, mask=None):
    """Pool a field as the model does: x right, y down."""
    mask = np.ones((SIDE, SIDE)) if mask is None else mask
    weights = torch.tensor(mask)[None]
    pooled = [
        pool_regions(torch.tensor(f * np.ones((SIDE, SIDE)))[None], weights)[0]
        for f in (field_x, field_y)
    ]
    mass = region_mass(weights)[0]
    return {
        name: {
            "shear_change_x": float(pooled[0][i]),
            "shear_change_y": float(pooled[1][i]),
            "contact_mass": float(mass[i]),
        }
        for i, name in enumerate(REGIONS)
    }


# Clockwise as drawn, y down: a point at (x, y) goes by (-y, x).
FIELDS = {
    Motion.CLOCKWISE: (-Y, X),
    Motion.COUNTERCLOCKWISE: (Y, -X),
    Motion.RIGHT: (1.0, 0.0),
    Motion.LEFT: (-1.0, 0.0),
    Motion.DOWN: (0.0, 1.0),
    Motion.UP: (0.0, -1.0),
    Motion.PRESS: (X, Y),
    Motion.RELEASE: (-X, -Y),
}


@pytest.mark.parametrize("motion", FIELDS)
def test_a_pure_motion_is_the_only_strength_of_its_pattern(motion):
    pattern = pattern_of(regions_of(*FIELDS[motion]))
    strengths = {one: pattern.along(one) for one in FIELDS}
    assert max(strengths, key=strengths.get) == motion
    others = {one: s for one, s in strengths.items() if abs(s) < 1e-5}
    assert len(others) == len(FIELDS) - 2
    # Rows of a half stand 0.5 to 6.5 patches from the middle: 3.5 on average.
    turn = {Motion.CLOCKWISE: 3.5, Motion.COUNTERCLOCKWISE: -3.5}.get(motion, 0.0)
    assert pattern.turn == pytest.approx(turn, abs=1e-4)


UPPER_FREE = np.ones((SIDE, SIDE))
UPPER_FREE[:7] = 0


@pytest.mark.parametrize(
    ("regions", "told"),
    [
        (
            regions_of(-Y, X + 4.0),
            "the whole contact goes down, the upper half goes right against the lower half, "
            "the left half goes up against the right half",
        ),
        (
            regions_of(-1.0, 0.0),
            "the whole contact goes left, the upper and lower halves go alike, "
            "the left and right halves go alike",
        ),
        (regions_of(-Y, X, UPPER_FREE), "the upper half is untouched"),
    ],
)
def test_the_halves_are_told_against_each_other(regions, told):
    assert told in halves(regions)


def test_the_place_of_contact_is_where_the_mass_is():
    mask = np.zeros((SIDE, SIDE))
    mask[8:12, 1:4] = 1
    regions = regions_of(1.0, 0.0, mask)
    assert contact_place(regions, 12 / 196) == (
        "contact fills 6% of the square looked at, most of it lower left"
    )
    whole = regions_of(1.0, 0.0)
    assert contact_place(whole, 1.0).endswith("most of it in the middle")


def steps(field, motion):
    evidence = {"regions": regions_of(*field), "contact_share": 1.0}
    return reasoning_steps(evidence, "So it is.", motion)


@pytest.mark.parametrize(
    ("motion", "claim", "sums"),
    [
        (Motion.CLOCKWISE, Motion.CLOCKWISE, "halves, which add up clockwise."),
        (Motion.PRESS, Motion.PRESS, "halves, which add up outwards."),
        (Motion.UP, Motion.UP, "cancels in the mean, which goes up."),
        (
            Motion.COUNTERCLOCKWISE,
            Motion.CLOCKWISE,
            "add up counterclockwise; this speaks against the conclusion, which rests on the whole "
            "token.",
        ),
    ],
)
def test_the_chain_says_what_adds_up_for_the_claim_or_against_it(motion, claim, sums):
    told = steps(FIELDS[motion], claim)
    assert len(told) == 4
    assert told[2].endswith(sums)
    assert told[-1] == "Therefore: So it is."
    assert len(steps((0.0, 0.0), None)) == len(steps((0.0, 0.0), Motion.STILL)) == 3


@pytest.mark.parametrize(
    ("line", "step"),
    [
        ("length contact", "the contact, from 0.0 to 4.0 s"),
        ("delay begin first ccw-events end nth 3 turn-events",
         "the first counterclockwise turn, from 2.0 to 3.0 s; turn number 3, from 3.0 to 4.0 s"),
        ("within part 1 2 contact begin first turn-events", "the first turn, from 1.0 to 2.0 s"),
        ("record amount turn , length longest turn-events end",
         "the longest turn, from 1.0 to 2.0 s"),
    ],
)  # fmt: skip
def test_times_name_the_events_that_they_rest_on(line, step):
    evidence = there_and_back()
    values = answers(read(line), (evidence,), FrameSpec())
    assert times_step(values, evidence, FrameSpec()) == f"It rests on this: {step}."


def test_a_time_of_no_event_in_particular_rests_on_what_it_looked_at():
    evidence = there_and_back()
    for line, begin in (("time-while cw", "It rests on this: it turns clockwise"), ("turn", "")):
        values = answers(read(line), (evidence,), FrameSpec())
        assert times_step(values, evidence, FrameSpec()).startswith(begin)
        assert begin or not times_step(values, evidence, FrameSpec())


def test_only_a_whole_sentence_of_the_model_is_quoted():
    slots = {"turn": {"cw": 0.9, "none": 0.1}}
    whole = own_view(slots, "it turns, about 14 degrees.", is_same=False)
    assert whole.endswith("; it says 'it turns, about 14 degrees.'.")
    cut_off = own_view(slots, f"about 14 degrees, likely {MISSING} to {MISSING}.", is_same=False)
    assert cut_off == "The language model itself: turn cw (90%)."
