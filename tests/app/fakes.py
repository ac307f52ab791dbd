"""A stand-in for the model that answers at once, from what the clip itself looks like."""

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import torch
from geotlm_lm.answering.multi_clip import compare_directions
from geotlm_lm.conversation.motion_answers import CAMERA

from geotlm_lm import FrameSpec, Motion
from geotlm_lm.answering import Encoded, evidence
from geotlm_lm.answering.encoded import with_background
from geotlm_lm.answering.session import Session
from geotlm_lm.backbone.stem import PATCH_INPUT_DIM
from geotlm_lm.backbone.view import View
from geotlm_lm.checkpoint import Calibration
from geotlm_lm.core.labels import reverse
from geotlm_lm.dgr.encoder import DGR
from geotlm_lm.model import Perception
from geotlm_lm.recordings.span import frames_inside
from geotlm_lm.track.tracker import Tracker
from tests.answering.scripted import believed


class FakeProbe:
    def probabilities(self, tokens, among):
        odds = np.full((1, len(among)), 0.01)
        likely = Motion.RIGHT if Motion.RIGHT in among else Motion.STILL
        odds[0, list(among).index(likely)] = 0.9
        return odds


NOTE = "The next likeliest is that it stays."


@dataclass(frozen=True)
class FakeAnswer:
    text: str
    direction: Motion | None
    frame: FrameSpec
    evidence: dict[str, Any]
    question: str
    abstained: bool
    confidence: float = 0.97
    kind: str = "direction"
    notes: tuple[str, ...] = ()

    @property
    def options(self):
        way = self.direction or Motion.RIGHT
        return {way.value: 0.97, reverse(way).value: 0.03}

    def to_dict(self):
        return {
            "text": self.text,
            "direction": None if self.direction is None else self.direction.value,
            "confidence": self.confidence,
            "abstained": self.abstained,
            "frame": self.frame.to_dict(),
            "question": self.question,
            "timing_ms": {"encode": 1.0},
            "evidence": self.evidence,
        }


class FakeAnswerer:
    """Perceives a slide to the right, a shear in the left half; answers with the clip's grey level.

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
        inputs = torch.zeros(1, 2, 14, 14, PATCH_INPUT_DIM)
        perception = Perception(token, geometry, token, (View(),), inputs)
        inside = clip if span is None else frames_inside(clip, span)
        places = np.linspace(0, len(inside) - 1, 4).round().astype(int).tolist()
        seen = ", ".join(str(inside.frame_numbers[place]) for place in places)
        clip = with_background(inside.select(places)).with_note(f"Frames {seen} are shown.")
        belief = believed("right")
        return Encoded(clip, perception, {"encode": 1.0}, believe=lambda _: belief)

    def tracker(self, recording=None):
        return Tracker()  # measures alone: no model is asked

    def session(self, encoded):
        return Session(self, encoded)

    def ask(self, encoded, question, *, frame=CAMERA, listen=None):
        level = float(encoded.clip.frames.mean())
        direction = frame.tell(Motion.RIGHT if level > 100 else Motion.LEFT)
        is_silent = level < 20
        text = "I cannot tell." if is_silent else f"To the {direction.value}, at {level:.0f}."
        if listen is not None:
            for word in text.split(" ")[:-1]:
                listen(f"{word} ")
        answer = FakeAnswer(
            text, None if is_silent else direction, frame, evidence(encoded), question, is_silent
        )
        return replace(answer, notes=(*encoded.clip.notes, NOTE))

    def compare(self, first, second):
        return compare_directions(*(self.ask(one, "Which way?") for one in (first, second)))
