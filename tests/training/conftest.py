"""Small examples for the training tests: random inputs and truth of the right shapes."""

import numpy as np
import pytest

from geotlm_lm.backbone.motions import MOTIONS_SHAPE
from geotlm_lm.backbone.stem import PATCH_INPUT_DIM
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.training.examples import Examples


@pytest.fixture(scope="session")
def tiny_examples():
    rng = np.random.default_rng(0)
    count = 20

    def random(*shape):
        return rng.random((count, *shape)).astype(np.float16)

    motions = list(Motion) * 2
    return Examples(
        inputs=random(2, 14, 14, PATCH_INPUT_DIM),
        motions=random(*MOTIONS_SHAPE),
        displacement_px=random(2, 14, 14, 2),
        contact=(random(2, 14, 14) > 0.5).astype(np.float16),
        depth_mm=random(2, 14, 14),
        labels=tuple(MotionLabel(motion, is_readable=i > 1) for i, motion in enumerate(motions)),
        objects=("ball",) * count,
    )
