"""Each target takes its own seeds, and refuses nonsense in one sentence."""

import pytest

from geotlm_lm.core.errors import GeoTLMError
from geotlm_lm.fuzzing.targets import TARGETS

SLOW = {"question", "conversation", "bundle"}


@pytest.mark.parametrize("name", sorted(set(TARGETS) - SLOW))
def test_a_target_takes_its_seeds_and_refuses_nonsense(tmp_path, name):
    target = TARGETS[name](tmp_path)
    for seed in target.seeds:
        target.run(seed)
    with pytest.raises(GeoTLMError):
        target.run(b"")


@pytest.mark.parametrize("name", sorted(SLOW))
def test_a_target_that_needs_the_model_takes_a_seed(tmp_path, name):
    target = TARGETS[name](tmp_path)
    target.run(target.seeds[0])
    with pytest.raises(GeoTLMError):
        target.run(b"")
