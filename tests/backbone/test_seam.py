"""Every encoder stands behind the embedded backbone's seam: DGR and the probes read its tokens."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from geotlm_lm.backbone.encoders import ENCODERS
from geotlm_lm.backbone.released import load_encoder
from geotlm_lm.core.clip import Clip
from tests.backbone.small_files import write_small

RNG = np.random.default_rng(1)


def clip(size=(240, 320)):
    frames = RNG.integers(60, 180, (4, *size, 3)).astype(np.uint8)
    return Clip(frames, background=np.full((*size, 3), 120, np.uint8))


@pytest.fixture(scope="module", params=list(ENCODERS))
def encoder(request, tmp_path_factory):
    path = write_small(request.param, tmp_path_factory.mktemp(request.param))
    return load_encoder(path, None if request.param != "sparsh" else "sparsh", heads=2)


def test_tokens_have_the_shapes_the_encoder_tells_beforehand(encoder):
    tokens = encoder.encode([clip(), clip((224, 224))])
    assert tokens.global_token.shape == (2, encoder.width)
    assert tokens.patches.shape == (2, *encoder.patch_shape)
    assert tokens.patches.dtype == tokens.global_token.dtype == torch.float32
    assert len(tokens.views) == 2


def test_a_batch_equals_its_clips_one_by_one(encoder):
    clips = [clip() for _ in range(5)]
    together = encoder.encode(clips)
    for index, one in enumerate(clips):
        alone = encoder.encode([one])
        torch.testing.assert_close(together.patches[index], alone.patches[0], rtol=1e-4, atol=1e-5)
        torch.testing.assert_close(
            together.global_token[index], alone.global_token[0], rtol=1e-4, atol=1e-5
        )


def test_a_pair_changes_only_with_what_a_bin_sees(encoder):
    # a, a, b, b: transformers whose bins attend to each other are left out by construction.
    if encoder.row.name in ("anytouch2", "sparsh"):
        pytest.skip("its time-bins attend to each other")
    a, b, c = (clip().frames[0] for _ in range(3))
    idle = clip().background

    def patches(*frames):
        return encoder.encode([Clip(np.stack(frames), background=idle)]).patches[0]

    first, second = patches(a, a, b, b), patches(a, a, c, c)
    torch.testing.assert_close(first[0], second[0], rtol=1e-4, atol=1e-5)
    assert not torch.allclose(first[1], second[1], atol=1e-3)


def test_a_clip_that_stands_still_has_equal_bins_where_bins_have_no_position(encoder):
    still = clip()
    frames = np.repeat(still.frames[:1], 4, axis=0)
    early, late = encoder.encode([replace(still, frames=frames)]).patches[0]
    has_time = encoder.row.name in ("anytouch2", "sparsh")
    assert torch.allclose(early, late, atol=1e-5) != has_time
