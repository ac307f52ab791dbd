"""A touch that turns there and back, and a stand-in for the model that only measures it."""

from types import SimpleNamespace

import numpy as np

from geotlm_lm.track.tracker import Tracker
from tests.track.recordings import there_and_back

CLIP = there_and_back()


class Measuring:
    """Tracks by measurement alone: no model is loaded."""

    bundle = SimpleNamespace(digest=lambda: "measured")

    def tracker(self, recording=None):
        return Tracker(idle=(CLIP if recording is None else recording).frames[0])

    def seen_closely(self, recording, track):
        return track


def saved_touch(folder):
    """Return the path of the touch as an archive."""
    np.savez(folder / "clip.npz", frames=CLIP.frames, fps=CLIP.fps)
    return folder / "clip.npz"
