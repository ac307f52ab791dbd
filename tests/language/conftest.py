import pytest
import torch

from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.language.decoder import LanguageSize
from geotlm_lm.training.language import LanguageTraining, new_speaker

FUSED_WIDTH = 24
LABELS = [MotionLabel(motion) for motion in Motion for _ in range(3)]
TINY = LanguageSize(width=32, layers=2, heads=2, mlp=48, tactile_tokens=3, max_tokens=104)


@pytest.fixture(scope="session")
def fused_tokens():
    torch.set_num_threads(1)
    return torch.randn(len(LABELS), FUSED_WIDTH, generator=torch.Generator().manual_seed(3))


@pytest.fixture(scope="session")
def speaker(fused_tokens):
    """Fresh weights, embeddings widened so that its answers differ from clip to clip."""
    made = new_speaker(fused_tokens, LanguageTraining(size=TINY))
    with torch.no_grad():
        made.model.decoder.embed_tokens.weight.mul_(10)
    return made
