"""The sets of reference checkpoints every oracle test runs on."""

from functools import partial

import pytest

from tests.backbone.oracles import Oracle, oracle_sets


@pytest.fixture(params=oracle_sets(), ids=str)
def oracles(request):
    """Return what loads one encoder's folder by name, from each set in turn."""
    return partial(Oracle, request.param)
