"""Laws of points of view: a group that acts on twists, ways and beliefs."""

import numpy as np
import pytest
from hypothesis import given, settings

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import mirror, reverse, turn_by_quarter
from geotlm_lm.core.twist import Twist
from geotlm_lm.query.edit import EDIT_WORDS, Edit
from tests.query.strategies import MOTIONS, beliefs, edits

FRAMES = [
    FrameSpec(
        image_mirrored=mirrored, viewpoint=view, actor=actor, **FrameSpec.fields_of_turn(turn)
    )
    for mirrored in (False, True)
    for view in ("sensor", "object")
    for actor in ("object", "sensor")
    for turn in (0, 90, 180, 270)
]


@given(edits, edits)
def test_the_matrix_of_two_edits_is_the_product_of_theirs(one, two):
    assert np.array_equal(one.then(two).matrix, two.matrix @ one.matrix)


@given(edits)
def test_an_edit_and_its_inverse_change_nothing(edit):
    assert edit.then(edit.inverse()) == Edit() == edit.inverse().then(edit)


@given(edits)
def test_the_words_of_an_edit_name_it(edit):
    assert Edit.of(*edit.words) == edit


@pytest.mark.parametrize("word", [one for one in EDIT_WORDS if "quarter" not in one])
def test_what_is_done_twice_is_undone(word):
    assert Edit.of(word, word) == Edit()


def test_quarters_add_up():
    assert Edit.of("quarter-cw", "quarter-cw") == Edit.of("half")
    assert Edit.of("quarter-cw", "quarter-ccw") == Edit()
    assert Edit.of("mirror", "flip") == Edit.of("half")


def test_backwards_turns_every_component_around():
    assert np.array_equal(Edit.of("backwards").matrix, -np.eye(4))
    assert np.array_equal(Edit.of("mirror").matrix, np.diag([-1, -1, 1, 1]))


@pytest.mark.parametrize("way", MOTIONS)
def test_edits_act_on_ways_as_on_names(way):
    assert Edit.of("mirror").of_way(way) == mirror(way)
    assert Edit.of("backwards").of_way(way) == reverse(way)
    assert Edit.of("quarter-ccw").of_way(way) == turn_by_quarter(way)


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("way", MOTIONS)
def test_a_frame_is_an_edit(frame, way):
    assert Edit.of_frame(frame).of_way(way) == frame.tell(way)
    assert Edit().within(frame) == Edit.of_frame(frame)


@pytest.mark.parametrize("way", MOTIONS)
def test_naming_a_viewpoint_that_holds_already_changes_nothing(way):
    frame = FrameSpec(viewpoint="object", actor="sensor")
    assert Edit.of("behind", "sensor").within(frame).of_way(way) == frame.tell(way)


@given(edits, beliefs())
@settings(max_examples=50)
def test_a_belief_is_seen_as_its_twist_and_ways_are(edit, belief):
    seen = edit.of_belief(belief)
    assert seen.mean == edit.of_twist(belief.mean)
    assert all(seen.ways[edit.of_way(way)] == share for way, share in belief.ways.items())
    back = edit.inverse().of_belief(seen)
    assert back.ways == belief.ways
    assert np.allclose(back.covariance, belief.covariance)


def test_mirrors_and_reversals_are_those_of_the_belief():
    twist = Twist(3.0, 4.0, -5.0, 0.2)
    assert Edit.of("mirror").of_twist(twist) == twist.mirrored()
    assert Edit.of("backwards").of_twist(twist) == twist.reversed()
