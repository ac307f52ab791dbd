"""A tracker that measures stands in for the model."""

import pytest

from geotlm_lm.answering.answerer import loaded
from tests.cli.recorded_touch import Measuring


@pytest.fixture
def without_model(monkeypatch):
    monkeypatch.setattr("geotlm_lm.answering.Answerer.load", lambda *_, **__: Measuring())
    loaded.cache_clear()
    yield
    loaded.cache_clear()
