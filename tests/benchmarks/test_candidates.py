"""Each measurement alone beside what is fused from them, on sets of turns and of slides."""

from dataclasses import replace

import pytest

from geotlm_lm.benchmarks.candidates import (
    CANDIDATE_SECTION,
    CANDIDATES,
    TOLD,
    candidate_variants,
    leanings,
    mixed_rows,
)
from geotlm_lm.benchmarks.harness import Run
from geotlm_lm.benchmarks.rendering import tables
from geotlm_lm.benchmarks.variants import FITS, LEANING, leaning_of, ways_of
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion
from geotlm_lm.core.twist import WAYS, Component, Twist
from tests.answering.scripted import believed
from tests.probe.imprints import moved_clip, textured_imprint


@pytest.fixture(scope="module")
def slid():
    return moved_clip(textured_imprint(3, 96, 128), [0, 0], [(0.0, 0.0), (6.0, 1.0)], noise=0)


def test_each_measurement_names_the_way_of_the_asked_component_alone(slid, tiny_answerer):
    variants = candidate_variants(tiny_answerer, 0)
    sliding = {name: variants[name](slid, SLIDES).motion for name in variants}
    assert {sliding[name] for name in CANDIDATES[:2]} == {Motion.RIGHT}
    assert {variants[name](slid, ROTATIONS).motion for name in CANDIDATES} <= set(ROTATIONS)
    learned = {f"belief without {part}" for part in tiny_answerer.bundle.motion.PARTS}
    assert len(learned) == 4
    assert learned <= set(variants)
    weights = variants[LEANING](slid, SLIDES).weights
    assert set(weights) == set(CANDIDATES)
    assert sum(weights.values()) == pytest.approx(1)
    # Words and what is told may name nothing; all others are forced to choose.
    free = ("words", TOLD)
    assert all(motion in SLIDES for name, motion in sliding.items() if name not in free)


def test_leanings_hold_the_paths_that_the_belief_is_given(slid, tiny_answerer):
    seen = leanings(tiny_answerer, slid)
    assert set(seen.ways) == {"belief", *CANDIDATES, *FITS}
    assert set(seen.paths) == set(CANDIDATES)
    right, down = seen.paths["green_chained"][1:]
    assert (right, down) == pytest.approx((6 * 224 / 128, 1 * 224 / 96), abs=0.5)


def test_a_leaning_without_probability_is_that_of_the_mean():
    belief = replace(
        believed("still"),
        ways=dict.fromkeys((way for ways in WAYS.values() for way in ways), 0.0),
        mean=Twist(-0.2, 0.1, 0.3, 0.0),
    )
    assert leaning_of(belief, ROTATIONS) is Motion.COUNTERCLOCKWISE
    assert leaning_of(belief, SLIDES) is Motion.DOWN
    assert ways_of(0.1, -2.0, 1.0) == {
        Component.TURN: Motion.CLOCKWISE,
        Component.SLIDE: Motion.LEFT,
    }


def test_mixtures_are_told_by_size_and_every_row_is_shown(tiny_answerer):
    rows = list(mixed_rows(Run(is_quick=True, answerer_given=tiny_answerer)))
    assert {row.case.rpartition(", ")[2] for row in rows} <= {"0.1 to 1 px", "1 px or more"}
    assert {row.variant for row in rows} >= {TOLD, LEANING, *CANDIDATES}
    shown = "\n".join(tables(CANDIDATE_SECTION, rows))
    assert all(row.case in shown for row in rows)
