"""What is costly to make and the same for every test: made once."""

from pathlib import Path

import pytest
import torch

import geotlm_lm
from geotlm_lm.answering import Answerer
from tests.conversation.questions import encoded_examples, remembering
from tests.tiny_bundle import tiny_bundle

BUNDLE = Path(geotlm_lm.__file__).parent / "bundle"
REAL = Path(__file__).resolve().parents[2] / "shared" / "real"


@pytest.fixture(scope="session")
def bundle():
    """A bundle of random weights."""
    return tiny_bundle()


@pytest.fixture(scope="session")
def real():
    """The folder of real recordings."""
    if not REAL.is_dir():
        pytest.skip(f"needs the real recordings in {REAL}")
    return REAL


@pytest.fixture(scope="session")
def answerer():
    """The shipped model."""
    if not BUNDLE.is_dir():
        pytest.skip("needs the trained bundle")
    torch.set_num_threads(1)
    return Answerer.load()


@pytest.fixture(scope="session")
def shipped(answerer):
    """The shipped model, which works out nothing twice."""
    return remembering(answerer)


@pytest.fixture(scope="session")
def examples(shipped):
    """Example clips that the shipped model has perceived, by name."""
    return encoded_examples(shipped)
