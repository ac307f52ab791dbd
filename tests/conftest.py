"""What is costly to make and the same for every test: made once."""

from pathlib import Path

import pytest
import torch

import geotlm_lm
from geotlm_lm.answering import Answerer
from geotlm_lm.recordings.read import read_clip
from tests.tiny_bundle import tiny_bundle

BUNDLE = Path(geotlm_lm.__file__).parent / "bundle"
REAL = Path(__file__).resolve().parents[2] / "shared" / "real"
EXAMPLES = Path(__file__).resolve().parents[1] / "app" / "examples"
SHOWN = ("bottle_cap_clockwise", "hex_nut_counterclockwise", "pen_clip_left")


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
def examples(answerer):
    """Example clips that the shipped model has perceived, by name."""
    return {name: answerer.encode(read_clip(EXAMPLES / f"{name}.npz")) for name in SHOWN}
