"""What is costly to make and the same for every test: made once."""

import os
import signal
from pathlib import Path

import hypothesis
import pytest
import torch

import geotlm_lm
from geotlm_lm.answering import Answerer
from geotlm_lm.recordings.read import read_clip
from tests.tiny_bundle import tiny_bundle

# A machine beside other work is slow now and then: no example of a law has a deadline.
hypothesis.settings.register_profile("no deadline", deadline=None)
hypothesis.settings.load_profile("no deadline")
# Read by OpenCV when its codecs are first used, by whichever test that is.
os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")

BUNDLE = Path(geotlm_lm.__file__).parent / "bundle"
REAL = Path(__file__).resolve().parents[2] / "shared" / "real"
EXAMPLES = Path(__file__).resolve().parents[1] / "app" / "examples"
SHOWN = ("bottle_cap_clockwise", "hex_nut_counterclockwise", "pen_clip_left")


@pytest.fixture(scope="session", autouse=True)
def _own_surroundings(tmp_path_factory):
    """Nothing of the user's is read or written, and Ctrl-C arrives: also in a shell's background.

    There an interactive signal is ignored, and programs that tests start would inherit that.
    """
    home = tmp_path_factory.mktemp("home")
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HOME", str(home))
        for name in ("XDG_CACHE_HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME"):
            patch.setenv(name, str(home / name))
        yield
    signal.signal(signal.SIGINT, before)


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
