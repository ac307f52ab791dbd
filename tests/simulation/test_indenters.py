import numpy as np
import pytest

from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS, INDENTERS, TRAINING_OBJECTS
from geotlm_lm.simulation.raster import object_grid


def test_there_are_at_least_eighty_bodies_to_train_on():
    assert len(set(TRAINING_OBJECTS)) == len(TRAINING_OBJECTS) >= 80


def test_the_twelve_everyday_things_are_never_trained_on():
    assert set(EVERYDAY_OBJECTS) == {
        *("bottle_cap", "key", "hex_nut", "screw_head", "coin", "bead", "pen_clip"),
        *("textured_ball", "can_rim", "corner", "cable", "table_edge"),
    }
    assert not set(EVERYDAY_OBJECTS) & set(TRAINING_OBJECTS)
    trained = {id(INDENTERS[name].height) for name in TRAINING_OBJECTS}
    assert not trained & {id(INDENTERS[name].height) for name in EVERYDAY_OBJECTS}


@pytest.mark.parametrize("name", INDENTERS)
def test_a_body_is_finite_and_has_something_to_touch(name):
    x, y = (axis[::2, ::2] for axis in object_grid())
    x, y = object_grid() if INDENTERS[name].is_extended else (x, y)
    height = INDENTERS[name].height(x, y, np.random.default_rng(7))
    assert height.shape == x.shape
    assert height.dtype == np.float32  # an accidental double slows every later pass
    assert np.all(np.isfinite(height))
    reachable = height < height.min() + 1.2
    assert reachable.mean() > 0.002
