"""What a picture holds of each component: nothing of what leaves it as it was."""

import numpy as np
import pytest

from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import COMPONENTS, Component
from geotlm_lm.simulation.indenter import Indenter
from geotlm_lm.simulation.motions import path_of
from geotlm_lm.simulation.scene import Body, Gel, Scene
from geotlm_lm.simulation.simulate import simulate
from geotlm_lm.simulation.trace import READABLE_GREY

BALL = Indenter(lambda x, y, rng: (x * x + y * y) / 10)
EDGE = Indenter(lambda x, y, rng: np.abs(0.6 * x + 0.8 * y) / 2, is_extended=True)
BLOCK = Indenter(lambda x, y, rng: np.maximum(np.abs(x) - 3, np.abs(y) - 2).clip(0) * 4)

MOVE = {"turn_deg": 15.0, "right_mm": 0.5, "down_mm": 0.3, "inward_mm": 0.3}


def visible(indenter, dome=1.0, texture_um=0.0, **move):
    body = Body("own", indenter=indenter, texture_um=texture_um)
    scene = Scene(body, path_of(**move), Motion.STILL, Gel(dome=dome))
    label = simulate([scene], seed=0, with_frames=False)[0].label
    return dict(zip(COMPONENTS, label.visible_grey, strict=True))


@pytest.mark.parametrize("dome", [0.0, 1.0])
@pytest.mark.parametrize(("indenter", "hidden"), [(BALL, Component.TURN), (EDGE, Component.SLIDE)])
def test_a_smooth_ball_hides_its_turn_and_an_edge_how_far_it_goes_along_itself(
    indenter, hidden, dome
):
    seen = visible(indenter, dome, **MOVE)
    assert seen.pop(hidden) < READABLE_GREY / 2
    assert min(seen.values()) > 2 * READABLE_GREY


def test_a_block_hides_nothing_and_a_texture_shows_a_balls_turn():
    assert min(visible(BLOCK, **MOVE).values()) > 2 * READABLE_GREY
    assert visible(BALL, texture_um=30.0, **MOVE)[Component.TURN] > 2 * READABLE_GREY


def test_nothing_is_seen_of_what_does_not_happen_and_twice_of_twice_as_much():
    assert visible(BLOCK)[Component.PRESS] == 0
    seen = visible(BLOCK, turn_deg=4.0)
    assert seen[Component.SLIDE] < READABLE_GREY / 2
    assert seen[Component.PRESS] == 0
    assert visible(BLOCK, turn_deg=8.0)[Component.TURN] == pytest.approx(
        2 * seen[Component.TURN], rel=0.1
    )
