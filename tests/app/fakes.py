"""A stand-in for the model that answers at once, from what the clip itself looks like."""

from types import SimpleNamespace

import numpy as np
import torch

from geotlm_lm import FrameSpec, Motion
from geotlm_lm.answering import Encoded, evidence, four_frames_with_background
from geotlm_lm.answering.several import compare_directions
from geotlm_lm.backbone.stem import View
from geotlm_lm.checkpoint import Calibration
from geotlm_lm.dgr.encoder import DGR
from geotlm_lm.model import Perception


class FakeProbe:
    def probabilities(self, tokens, among):
        odds = np.full((1, len(among)), 0.01)
        likely = Motion.RIGHT if Motion.RIGHT in among else Motion.STILL
        odds[0, list(among).index(likely)] = 0.9
        return odds


class FakeAnswerer:
    """Perceives a unit shear to the right in the left half; answers with the clip's grey level.

    A clip brighter than 100 moves to the right, a darker one to the left; one of a level below 20
    cannot be told.
    """

    bundle = SimpleNamespace(
        model=SimpleNamespace(probe=FakeProbe()),
        calibration=Calibration(contact_threshold=0.005),
    )

    def encode(self, clip, span=None):
        field, mask = torch.zeros(1, 14, 14, 2), torch.zeros(1, 14, 14)
        field[..., 0] = 1
        mask[:, :, :7] = 1
        with torch.no_grad():
            geometry = DGR(4).pool(torch.zeros(1, 2, 14, 14, 2), field, mask)
        token = torch.zeros(1, 4)
        perception = Perception(token, geometry, token, (View(),))
        return Encoded(four_frames_with_background(clip, span), perception, {"encode": 1.0})

    def ask(self, encoded, question):
        level = float(encoded.clip.frames.mean())
        direction = Motion.RIGHT if level > 100 else Motion.LEFT
        is_silent = level < 20
        text = "I cannot tell." if is_silent else f"To the {direction.value}, at {level:.0f}."
        return SimpleNamespace(
            text=text,
            confidence=0.97,
            abstained=is_silent,
            direction=None if is_silent else direction,
            frame=FrameSpec(),
            options={"right": 0.97, "left": 0.03},
            to_dict=lambda: {
                "text": text,
                "direction": None if is_silent else direction.value,
                "confidence": 0.97,
                "abstained": is_silent,
                "frame": FrameSpec().to_dict(),
                "question": question,
                "timing_ms": {"encode": 1.0},
                "evidence": evidence(encoded),
            },
        )

    def compare(self, first, second):
        return compare_directions(*(self.ask(one, "Which way?") for one in (first, second)))
