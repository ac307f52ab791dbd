"""Laws of points of view: a group that acts on twists, ways, labels and beliefs."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geotlm_lm.core.edit import MIRRORED, Edit, opposite
from geotlm_lm.core.labels import DIRECTED, Motion, MotionLabel
from geotlm_lm.core.twist import COMPONENTS, Component, Twist
from tests.core.test_frame_spec import FRAMES
from tests.query.strategies import beliefs, edits

numbers = st.floats(-60, 60).filter(lambda value: abs(value) > 1e-6)
twists = st.builds(Twist, numbers, numbers, numbers, numbers)


@given(edits, edits)
def test_the_matrix_of_two_edits_is_the_product_of_theirs(one, two):
    assert np.array_equal(one.then(two).matrix, two.matrix @ one.matrix)


@given(edits)
def test_an_edit_and_its_inverse_change_nothing(edit):
    assert edit.then(edit.inverse()) == Edit() == edit.inverse().then(edit)


@given(edits)
def test_the_words_of_an_edit_name_it(edit):
    assert Edit.of(*edit.words) == edit


def test_quarters_add_up():
    assert Edit.of("quarter-cw", "quarter-cw") == Edit.of("half")
    assert Edit.of("quarter-cw", "quarter-ccw") == Edit()
    assert Edit.of("mirror", "flip") == Edit.of("half")


@pytest.mark.parametrize(
    ("word", "ways"),
    {
        "mirror": "counterclockwise clockwise right left up down press release still none",
        "backwards": "counterclockwise clockwise right left down up release press still none",
        "sensor": "counterclockwise clockwise right left down up press release still none",
        "half": "clockwise counterclockwise right left down up press release still none",
        "quarter-ccw": "clockwise counterclockwise down up left right press release still none",
    }.items(),
)
def test_the_generators_rename_ways(word, ways):
    assert [Edit.of(word).of_way(way) for way in Motion] == ways.split()


@given(edits, edits)
def test_ways_are_renamed_by_a_group(one, two):
    for way in Motion:
        assert one.then(two).of_way(way) == two.of_way(one.of_way(way))
        assert one.inverse().of_way(one.of_way(way)) == way
        assert (Edit(one.rotation).of_way(way) in DIRECTED) == (way in DIRECTED)
        assert opposite(one.of_way(way)) == one.of_way(opposite(way))


@given(edits, twists)
def test_a_twist_goes_as_far_and_the_way_its_name_goes(edit, twist):
    seen = edit.of_twist(twist)
    for component in COMPONENTS:
        assert seen.path(component, 20.0) == pytest.approx(twist.path(component, 20.0))
        if abs(abs(twist.right_px) - abs(twist.down_px)) > 1e-6:  # else two ways are as near
            assert seen.way(component) == edit.of_way(twist.way(component))


@pytest.mark.parametrize("frame", FRAMES)
def test_a_frame_is_an_edit_of_the_recorded_image(frame):
    """An image is turned back first, then mirrored, then seen from its side, then by its mover."""
    words = {90: ["quarter-ccw"], 180: ["half"], 270: ["quarter-cw"]}.get(frame.turn_deg, [])
    words += ["mirror"] * frame.image_mirrored + ["behind"] * (frame.viewpoint == "object")
    assert frame.edit == Edit.of(*words, *["sensor"] * (frame.actor == "sensor"))
    assert Edit().within(frame.edit) == frame.edit


def test_naming_a_viewpoint_that_holds_already_changes_nothing():
    base = Edit.of("behind", "sensor")
    assert base.within(base) == base


@given(st.sampled_from([Edit(), MIRRORED, Edit.of("half"), Edit.of("flip")]), twists)
def test_a_label_is_seen_as_its_twist_is(edit, twist):
    label = MotionLabel(twist.way(Component.TURN), twist.turn_deg, twist.right_px, twist.down_px)
    seen = edit.of_label(replace(label, travel_px=(twist.right_px, twist.down_px)))
    expected = edit.of_twist(twist)
    assert (seen.rotation_deg, *seen.travel_px) == (
        expected.turn_deg,
        expected.right_px,
        expected.down_px,
    )
    assert (seen.slide_x_mm, seen.slide_y_mm) == seen.travel_px
    assert seen.motion == expected.way(Component.TURN)
    with pytest.raises(ValueError, match="a label is mirrored or turned by a half"):
        Edit.of("backwards").of_label(label)


@given(edits, beliefs())
@settings(max_examples=50)
def test_a_belief_is_seen_as_its_twist_and_ways_are(edit, belief):
    seen = belief.seen(edit)
    assert seen.mean == edit.of_twist(belief.mean)
    assert all(seen.ways[edit.of_way(way)] == share for way, share in belief.ways.items())
    back = seen.seen(edit.inverse())
    assert back.ways == belief.ways
    assert np.allclose(back.covariance, belief.covariance)
