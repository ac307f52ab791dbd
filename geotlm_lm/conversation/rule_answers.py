"""Input and output of the rules that derive an answer."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion


@dataclass(frozen=True)
class RuleInput:
    """What a rule derives an answer from.

    Args:
        kind: The sort of question.
        motion: What the model felt, in the camera image.
        question: As it was asked, without facts about the frame.
        frame: In which to answer.
        probabilities: Of every motion, in the camera image.
        verdict: What the model itself said of a claim; None where it was not asked.
    """

    kind: str
    motion: Motion
    question: str
    frame: FrameSpec
    probabilities: Mapping[Motion, float]
    verdict: bool | None = None


@dataclass(frozen=True)
class RuleAnswer:
    """The answer that a rule derives.

    Args:
        text: One sentence.
        direction: The motion it claims, in `frame`; None if it claims none.
        frame: The frame of reference it is told in.
        options: Probability of each possible answer, by its deciding word.
        decided: The deciding word of this one.
        is_refusal: Whether it declines to say.
    """

    text: str
    direction: Motion | None
    frame: FrameSpec
    options: dict[str, float]
    decided: str
    is_refusal: bool = False


def directed_answer(
    felt: RuleInput, frame: FrameSpec, text: Callable[[Motion], str], change: Callable = lambda m: m
) -> RuleAnswer:
    """Return an answer that names one motion: `change` of the perceived one, in `frame`."""

    def tell(motion: Motion) -> Motion:
        return frame.tell(change(motion))

    told = tell(felt.motion)
    options: dict[str, float] = {}
    for motion, probability in felt.probabilities.items():
        word = tell(motion).value
        options[word] = options.get(word, 0.0) + probability
    return RuleAnswer(text(told), told, frame, options, told.value)
