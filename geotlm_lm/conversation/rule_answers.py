"""Input and output of the rules that derive an answer."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from geotlm_lm.conversation.felt import Felt
from geotlm_lm.conversation.telling import Told, tell
from geotlm_lm.conversation.wording import capitalised
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion, MotionClass
from geotlm_lm.core.twist import Component


@dataclass(frozen=True)
class RuleInput:
    """What a rule derives an answer from.

    Args:
        kind: The sort of question.
        felt: What is believed, in the camera image.
        question: As it was asked, without facts about the frame.
        frame: In which to answer.
        verdict: What the model itself said of a claim; None where it was not asked.
        motion: What it told with that, in the camera image.
    """

    kind: str
    felt: Felt
    question: str
    frame: FrameSpec
    verdict: bool | None = None
    motion: Motion | None = None


@dataclass(frozen=True)
class RuleAnswer:
    """The answer that a rule derives.

    Args:
        text: One sentence.
        direction: The motion it claims, in `frame`; None if it claims none.
        frame: The frame of reference it is told in.
        options: Probability of each possible answer, by its deciding word.
        decided: The deciding word of this one.
        confidence: Probability of the least sure thing that it says.
        is_refusal: Whether it declines to say.
        is_plain: Whether the model's own sentence, of one motion, may stand for it.
        component: What it tells the amount of; None where it tells none.
        motion_class: The kind of motion it names without a way; None where it names none.
    """

    text: str
    direction: Motion | None
    frame: FrameSpec
    options: dict[str, float]
    decided: str
    confidence: float
    is_refusal: bool = False
    is_plain: bool = False
    component: Component | None = None
    motion_class: MotionClass | None = None


def answer_told(
    told: Told, text: str, frame: FrameSpec, options: Mapping[str, float], decided: str
) -> RuleAnswer:
    """Return an answer that says a clause on the motion, in a sentence of its own."""
    return RuleAnswer(
        text,
        told.direction,
        frame,
        dict(options),
        decided,
        told.confidence,
        is_plain=told.is_plain,
        component=told.component,
    )


def open_answer(felt: Felt, frame: FrameSpec, components: Collection[Component] = ()) -> RuleAnswer:
    """Return what is believed, named as `frame` does, of components or, without any, of all."""
    told = tell(felt, frame, components)
    return answer_told(told, f"{capitalised(told.text)}.", frame, felt.words, told.direction.value)
