"""What is asked about, and what a program comes to there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.evidence_of import evidence_of
from geotlm_lm.answering.withholding import told_or_not
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.query.answers import answers
from geotlm_lm.query.evaluate import Evidence
from geotlm_lm.query.facts import with_facts
from geotlm_lm.query.program import Program
from geotlm_lm.query.values import Value


@dataclass(frozen=True)
class Asked:
    """The recordings that are asked about, and what held before the question.

    Args:
        bundle: The model.
        clips: One, or two that follow each other; the last is the one asked about.
        frame: What held before.
        named: The point of view that was named last, in words.
    """

    bundle: Bundle
    clips: tuple[Encoded, ...]
    frame: FrameSpec
    named: str | None = None

    @cached_property
    def evidence(self) -> tuple[Evidence, ...]:
        """What answers rest on; clips that are compared are independent."""
        return tuple(evidence_of(clip, seed) for seed, clip in enumerate(self.clips))

    def says(self, question: str, written: str, text: str) -> bool:
        """Tell whether an answer is what the language model itself says; it sees one clip."""
        if len(self.clips) > 1:
            return False
        return self.bundle.speaker.says(self.clips[-1].prefix, question, written, text)

    def values(self, program: Program) -> tuple[Value, ...]:
        """Return what everything that is asked comes to, or why it is withheld."""
        values = answers(program, self.evidence, self.frame)
        return tuple(told_or_not(each, self.clips, self.bundle) for each in values)

    def frame_after(self, program: Program) -> FrameSpec:
        """Return the frame in which what was stated holds; the one before if it cannot."""
        try:
            return with_facts(self.frame, program.facts, self.clips[-1].clip.frames.shape[2])
        except UsageError:  # no camera has such pixels: the values say so
            return self.frame
