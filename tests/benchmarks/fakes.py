"""A stand-in for the loaded model, so that the experiments are tested without weights."""

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import torch

from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.backbone.view import View
from geotlm_lm.checkpoint import Calibration
from geotlm_lm.core.geometry import GRID_SIDE, PATCH_SIDE
from geotlm_lm.core.labels import Motion
from geotlm_lm.language.sequence import log_softmax
from geotlm_lm.language.size import SLOTS
from geotlm_lm.probe.linear import LinearProbe
from geotlm_lm.query.program import ATOM_OF
from tests.answering.scripted import believed

ALL = tuple(Motion)


def level_motion(clip):
    """Read the motion off the last pixel, where the tests have written its number."""
    return ALL[int(clip.frames[-1, -1, -1, 0]) % len(ALL)]


@dataclass
class FakeAnswerer:
    """Perceives the number in the last pixel; says it, but has no words for `mute`."""

    mute: Motion | None = None
    encoded_count: int = 0
    questions: list[str] = field(default_factory=list)

    def __post_init__(self):
        probe = LinearProbe(len(ALL), ALL)
        with torch.no_grad():
            probe.head.weight.copy_(torch.eye(len(ALL)))
            probe.head.bias.zero_()
        model = SimpleNamespace(probe=probe, global_probe=probe)
        self.bundle = SimpleNamespace(
            model=model,
            calibration=Calibration(),
        )

    def _prefix(self, seen):
        """Feel a motion at the slot that has a word for it."""
        atom = ATOM_OF.get(seen, "none")
        felt = {"contact": "none" if seen is Motion.NONE else "touch"}
        words = {slot: felt.get(slot, atom if atom in SLOTS[slot] else "none") for slot in SLOTS}
        return SimpleNamespace(
            slots={
                slot: log_softmax(np.array([4.0 * (one == words[slot]) for one in among]))
                for slot, among in SLOTS.items()
            }
        )

    def encode(self, clip):
        self.encoded_count += 1
        seen = level_motion(clip)
        token = torch.zeros(1, len(ALL))
        token[0, ALL.index(seen)] = 5.0
        return SimpleNamespace(
            clip=clip,
            seen=seen,
            perception=SimpleNamespace(fused_token=token, global_token=-token),
            timing_ms={"choose": 1.0, "encode": 10.0},
            belief=believed(seen.value),
            prefix=self._prefix(seen),
            doubt=1.0,
        )

    def ask(self, encoded, question):
        self.questions.append(question)
        direction = None if encoded.seen == self.mute else encoded.seen
        return SimpleNamespace(
            direction=direction,
            in_the_image=direction,
            decided=direction and direction.value,
            abstained=direction is None,
            motion=None,
        )


class PlainBackbone:
    """Encodes each patch's mean change by bins; `gain` is its only weight."""

    def __init__(self, gain=1.0):
        self.gain = gain

    def encode(self, clips):
        patches = torch.from_numpy(np.stack([self._patches(clip) for clip in clips]))
        return Tokens(patches.mean(dim=(2, 3)).flatten(1), patches, (View(),) * len(clips))

    def _patches(self, clip):
        change = (clip.frames.astype(np.float32) - clip.background) / 16 * self.gain
        cells = (GRID_SIDE, PATCH_SIDE, GRID_SIDE, PATCH_SIDE, 3)
        patches = change.reshape(4, *cells).mean(axis=(2, 4))
        return patches.reshape(2, 2, GRID_SIDE, GRID_SIDE, 3).mean(axis=1)
