"""The model of random weights that benches are tried on."""

import pytest

from geotlm_lm.answering import Answerer
from tests.tiny_bundle import tiny_bundle


@pytest.fixture(scope="session")
def tiny_answerer():
    return Answerer(tiny_bundle())
