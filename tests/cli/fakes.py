"""A stand-in for the model: answers at once, remembers what it was asked."""

from dataclasses import dataclass
from types import SimpleNamespace

from geotlm_lm.recordings.span import frames_inside


class FakeAnswerer:
    abstained = False

    def __init__(self):
        self.clips, self.spans, self.questions, self.folders = [], [], [], []
        self.frames = []

    def load(self, folder=None):
        self.folders.append(folder)
        return self

    def encode(self, clip, span=None):
        self.clips.append(clip)
        self.spans.append(span)
        return clip if span is None else frames_inside(clip, span)

    def ask(self, encoded, question, *, frame):
        self.questions.append(question)
        self.frames.append(frame)
        return SimpleNamespace(
            text="Clockwise.",
            abstained=self.abstained,
            notes=("Frames 0, 1, 2, 3 are used.",),
            to_dict=lambda: {"text": "Clockwise.", "direction": "clockwise"},
        )

    def why(self, encoded, answer):
        return Why(("Contact fills the gel.", f"Therefore: {answer.text}"), "by rule")


@dataclass(frozen=True)
class Why:
    steps: tuple
    source: str
