"""A stand-in for the model that believes what a clip's grey level says; clips for it."""

import base64
from types import SimpleNamespace

import numpy as np
import torch

from app.clips import perceive, read_named, span_of
from geotlm_lm import Answerer, Motion
from geotlm_lm.answering import Encoded
from geotlm_lm.answering.encoded import with_background
from geotlm_lm.backbone.stem import PATCH_INPUT_DIM
from geotlm_lm.backbone.view import View
from geotlm_lm.checkpoint import Calibration
from geotlm_lm.core.process import silent
from geotlm_lm.dgr.encoder import DGR
from geotlm_lm.model import Perception
from geotlm_lm.recordings.read import frames_inside
from geotlm_lm.track.tracker import Tracker, track_of, unfollowed
from tests.answering.scripted import ScriptedReader, Silent, believed

READ = {
    "What happens first and what then?": "way all",
    "Which way is the object turning?": "way turn",
    "Which way does it go?": "way all",
    "Which way is it moving?": "way all",
    "When did it stop?": "end last move-events",
    "How far did it go?": "extent",
    "it has turned 20 degrees clockwise": "~ amount cw #1",
    "it has turned 300 degrees": "~ amount turn #1",
    "I look from the object's side.": "fact seen object",
    "0.05 mm per pixel. Which way?": "fact scale #1 ; way all",
}


class FakeProbe:
    def probabilities(self, tokens, among):
        odds = np.full((1, len(among)), 0.01)
        likely = Motion.RIGHT if Motion.RIGHT in among else Motion.STILL
        odds[0, list(among).index(likely)] = 0.9
        return odds


class FakeAnswerer(Answerer):
    """Perceives a shear to the right in the left half; tells the rest by the clip's grey level.

    A clip brighter than 100 moves to the right, a darker one to the left, by a tenth of its level
    in pixels of the 224-pixel image; one of a level below 20 cannot be told.
    """

    def __init__(self):
        bundle = SimpleNamespace(
            model=SimpleNamespace(probe=FakeProbe()),
            calibration=Calibration(contact_threshold=0.005),
            reader=ScriptedReader(READ),
            speaker=Silent(),
        )
        super().__init__(bundle)

    def encode(self, clip, *, span=None, track=None, progress=silent, follow=unfollowed):
        field, mask = torch.zeros(1, 14, 14, 2), torch.zeros(1, 14, 14)
        field[..., 0] = 1
        mask[:, :, :7] = 1
        with torch.no_grad():
            geometry = DGR(4).pool(torch.zeros(1, 2, 14, 14, 2), field, mask)
        token = torch.zeros(1, 4)
        inputs = torch.zeros(1, 2, 14, 14, PATCH_INPUT_DIM)
        perception = Perception(token, geometry, token, (View(),), inputs)
        inside = clip if span is None else frames_inside(clip, span)
        places = np.linspace(0, len(inside) - 1, 4).round().astype(int).tolist()
        seen = ", ".join(str(inside.frame_numbers[place]) for place in places)
        clip = with_background(inside.select(places)).with_note(f"Frames {seen} are shown.")
        found = {}
        if inside.fps is not None and len(inside) > 4:
            found = {
                "track": track_of(inside, progress=progress, follow=follow),
                "recording": inside,
            }
        return Encoded(clip, perception, {"encode": 1.0}, believe=_belief, **found)

    def track(self, recording, *, progress=silent):
        return track_of(recording, progress=progress)

    def seen_closely(self, recording, track):
        return track

    def tracker(self, recording=None):
        return Tracker()  # measures alone: no model is asked


def _belief(encoded):
    level = float(encoded.clip.frames.mean())
    if level < 20:
        return believed("left", "clockwise", share=0.45)
    return believed("right" if level > 100 else "left", px=level / 10)


CAP = "example:bottle_cap_clockwise"


def clip(level):
    """Return six frames of a grey level, in the last of which a square is brighter."""
    frames = np.full((6, 48, 64, 3), level, np.uint8)
    frames[3:, 20:30, 20:30] += 9
    return frames


def in_message(stored):
    """Return a file as it travels inside a message."""
    return "data:;base64," + base64.b64encode(stored).decode()


def load_clip(answerer, path, first=None, last=None, topic=None):
    """Return what lies at a path, perceived as the page does, whole or from first to last frame."""
    return perceive(answerer, read_named(path, topic), span=span_of(first, last))
