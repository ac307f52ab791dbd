"""The model of random weights that benches are tried on."""

import pytest

from geotlm_lm.answering import Answerer
from tests.tiny_bundle import tiny_bundle


@pytest.fixture(scope="session")
def tiny_answerer():
    return Answerer(tiny_bundle())


@pytest.fixture(autouse=True)
def _own_folder(tmp_path, monkeypatch):
    """Parts of a bench are kept below the current folder: those of an earlier run lie elsewhere."""
    monkeypatch.chdir(tmp_path)
