"""Laws: a series is the scenes of its seed, simulated, wherever it is entered."""

import numpy as np

from geotlm_lm.core.labels import DIRECTED
from geotlm_lm.simulation.indenters import TRAINING_OBJECTS
from geotlm_lm.simulation.randomise import random_scenes
from geotlm_lm.simulation.series import simulate_series
from geotlm_lm.simulation.simulate import simulate


def test_a_series_is_its_scenes_simulated():
    scenes = random_scenes(9, 3, objects=TRAINING_OBJECTS, first_index=4, motions=DIRECTED)
    expected = simulate(scenes, seed=9, first_index=4)
    made = list(simulate_series(9, 3, objects=TRAINING_OBJECTS, first_index=4, motions=DIRECTED))
    for one, other in zip(made, expected, strict=True):
        assert one.label == other.label
        assert np.array_equal(one.clip.frames, other.clip.frames)
