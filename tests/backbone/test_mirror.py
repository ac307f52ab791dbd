"""Laws: turned-over inputs are those of the turned-over clip, and a second mirror undoes the first.

Expected values: the stem looking at the frames themselves turned over.
"""

from dataclasses import replace

import numpy as np
import pytest
import torch

from geotlm_lm.backbone import imprint
from geotlm_lm.backbone.stem import Mirror, measure_clip, mirrored_inputs
from geotlm_lm.simulation.simulate import simulate_series
from tests.backbone.test_stem import moving_clip


def seen(clip):
    return torch.from_numpy(measure_clip(clip).inputs)[None]


def turned_over(clip, mirror):
    frames = np.flip(clip.frames, 1 + mirror.value)
    background = np.flip(clip.background, mirror.value)
    return replace(
        clip, frames=np.ascontiguousarray(frames), background=np.ascontiguousarray(background)
    )


@pytest.fixture(scope="module")
def clips():
    # Grey shading under the usual lights tells no slope down the image, so that lights above and
    # below are alike; the relief of coloured shading finds out by itself that left and right are
    # swapped.
    coloured = next(iter(simulate_series(3, 1, objects=("key",)))).clip
    return {
        Mirror.TOP_AND_BOTTOM: moving_clip((3.0, 2.0), turn_deg=5.0),
        Mirror.LEFT_AND_RIGHT: coloured,
    }


@pytest.fixture(autouse=True)
def usual_lights(monkeypatch):
    """Grey shading is not taken for that of one light."""
    found = imprint.lights_of
    monkeypatch.setattr(imprint, "lights_of", lambda *seen: replace(found(*seen), are_one=False))


@pytest.mark.parametrize("mirror", Mirror)
def test_turned_over_inputs_are_those_of_the_turned_over_clip(clips, mirror):
    expected = seen(turned_over(clips[mirror], mirror))
    found = mirrored_inputs(seen(clips[mirror]), mirror)
    error, size = (one.abs().mean(dim=(0, 1, 2, 3)) for one in (found - expected, expected))
    # Of the strongest two fifths of the gradients ties are taken in another order.
    assert (error / (size + 1e-3)).max() < 0.01


@pytest.mark.parametrize("mirror", Mirror)
def test_a_second_mirror_undoes_the_first(clips, mirror):
    inputs = seen(clips[mirror])
    once = mirrored_inputs(inputs, mirror)
    assert not torch.equal(once, inputs)
    assert torch.equal(mirrored_inputs(once, mirror), inputs)
