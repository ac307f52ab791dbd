"""One question of every type about every clip, put to the product and to what it is held against.

Answers come from `Answerer.ask`, as a user gets them; whether a type is the model's own or told by
rule is read off the answer. Knows how to grade, not how to sum up.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from geotlm_lm.answering import NOT_UNDERSTOOD
from geotlm_lm.answering.amounts import amount_in
from geotlm_lm.answering.replying import UNTRAINED
from geotlm_lm.conversation.reasons import pattern_of
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import DIRECTED, Motion
from geotlm_lm.core.seeding import generator_for
from geotlm_lm.data.questions import QuestionAnswer, askable_types, questions_for
from geotlm_lm.experiments.language_cases import FLOW, PROBE, Touched, blind
from geotlm_lm.experiments.language_evidence import claims_right
from geotlm_lm.experiments.language_truth import (
    Truth,
    is_right,
    is_understood,
    scored_is_right,
    truth_of,
)

if TYPE_CHECKING:
    from geotlm_lm.answering import Answer, Answerer, Encoded

WORDS, UNSEEN, SCORED = "words", "unseen wordings", "scored"
BLIND, SHUFFLED = "blind", "shuffled clips"
METHODS = (WORDS, UNSEEN, SCORED, PROBE, FLOW, BLIND, SHUFFLED)
"""What is graded, in the order of the table's columns."""

AMOUNTS, THREAD, EVIDENCE = ("T7", "T8"), "T13", "T10"


@dataclass(frozen=True)
class Row:
    """One question and what became of it; `right` holds a method only where it could be right.

    Args:
        type_id: What was asked.
        clip: Number of the clip.
        family: The unit of resampling.
        right: Whether each method had the right answer.
        truth: Deciding word of the right answer; "declined" where to decline is right.
        fault: Why the words are wrong: "no words", "not trained", "refused", "other kind",
            "withheld" or "wrong"; "" where they are right.
        confidence: What the answer in words states; 0 where it is withheld.
        said: Deciding word of the answer in words; None where it decides nothing.
        told_by: Whose sentence it is.
        amount_error: Off the true amount by this much, relative to it; None where none was said.
        unit: Of the amount.
        claims: Of stated evidence, claim by claim: whether the true field agrees.
        own_claims: Likewise for the geometry the model read.
    """

    type_id: str
    clip: int
    family: str
    right: dict[str, bool]
    truth: str
    fault: str
    confidence: float
    said: str | None
    told_by: str
    amount_error: float | None = None
    unit: str | None = None
    claims: tuple[bool, ...] = field(default=())
    own_claims: tuple[bool, ...] = field(default=())


def ask_every_type(
    answerer: Answerer,
    touches: Sequence[Touched],
    seed: int,
    progress: Callable[[int, int], None],
) -> list[Row]:
    """Ask one question of every type about every clip, in seen and in unseen wordings."""
    nobody = blind(list(touches))
    rows = []
    for index, touch in enumerate(touches):
        rng = generator_for(seed, "language", index)
        others = [one for one in touches if one.object_id != touch.object_id] or list(touches)
        stranger = others[int(rng.integers(len(others)))].encoded
        for type_id in askable_types(touch.label):
            if type_id in AMOUNTS and not touch.has_amounts:
                continue
            row = _ask_type(answerer, touch, index, type_id, (nobody, stranger), rng)
            rows += [] if row is None else [row]
        progress(index + 1, len(touches))
    return rows


def _ask_type(
    answerer: Answerer,
    touch: Touched,
    index: int,
    type_id: str,
    others: tuple[Encoded, Encoded],
    rng: np.random.Generator,
) -> Row | None:
    """Return the row of one type; None where the answer cannot be judged."""
    frame = thread_frame(rng) if type_id == THREAD else FrameSpec()
    asked, unseen = (
        questions_for(touch.label, rng, types=[type_id], wordings=wordings)[0]
        for wordings in ("seen", "held_out")
    )

    def ask(question: QuestionAnswer, encoded: Encoded) -> Answer:
        return answerer.ask(encoded, question.question, frame=frame)

    is_timed = touch.encoded.seconds is not None
    truth, unseen_truth = (
        truth_of(one, touch.motion, frame, is_timed=is_timed) for one in (asked, unseen)
    )
    answer = ask(asked, touch.encoded)
    graded = grade(touch, asked, answer, truth)
    if graded is None:
        return None
    right = {
        WORDS: graded,
        UNSEEN: grade(touch, unseen, ask(unseen, touch.encoded), unseen_truth),
        SCORED: scored_is_right(answer, truth),
        **{name: _reads_right(asked, touch.readings[name], frame, truth) for name in (PROBE, FLOW)},
    }
    # What every clip is answered alike, no view of the clip can give away.
    for name, encoded in () if truth.abstains else zip((BLIND, SHUFFLED), others, strict=True):
        right[name] = grade(touch, asked, ask(asked, encoded), truth)
    return _row(touch, index, asked, answer, truth, right)


def _row(
    touch: Touched,
    index: int,
    asked: QuestionAnswer,
    answer: Answer,
    truth: Truth,
    right: dict[str, bool | None],
) -> Row:
    said = amount_in(answer.decided)
    is_measured = truth.amount is not None and said is not None and said[1] == truth.unit
    is_evidence = asked.type_id == EVIDENCE and touch.motion in DIRECTED and not answer.abstained
    has_field = is_evidence and touch.field is not None
    return Row(
        type_id=asked.type_id,
        clip=index,
        family=touch.family,
        right={name: value for name, value in right.items() if value is not None},
        truth=expected_word(truth),
        fault="" if right[WORDS] else fault_of(asked, answer),
        confidence=answer.confidence,
        said=answer.decided,
        told_by=answer.told_by,
        amount_error=abs(said[0] - truth.amount) / truth.amount if is_measured else None,
        unit=truth.unit,
        claims=tuple(claims_right(answer, touch.field)) if has_field else (),
        own_claims=tuple(claims_right(answer, answer.evidence["regions"])) if is_evidence else (),
    )


def grade(touch: Touched, asked: QuestionAnswer, answer: Answer, truth: Truth) -> bool | None:
    """Tell whether an answer is right; None where it is evidence that nothing can be held to.

    Evidence by rule says where the halves go, not which motion that is: every claim must have the
    true field's sign, or, where the field is not known, the whole must go the way of the motion.
    """
    is_by_rule = asked.type_id == EVIDENCE and answer.told_by == "rule"
    if not is_by_rule or answer.kind != "evidence" or answer.abstained:
        return is_right(asked, answer, truth)
    if touch.motion not in DIRECTED:
        return None
    if touch.field is None:
        return bool(pattern_of(answer.evidence["regions"]).along(touch.motion) > 0)
    claims = claims_right(answer, touch.field)
    return bool(claims) and all(claims)


def fault_of(asked: QuestionAnswer, answer: Answer) -> str:
    """Return why a wrong answer is wrong; one that does not parse has "no words"."""
    if answer.text == NOT_UNDERSTOOD:
        return "no words"
    if answer.text in UNTRAINED.values():
        return "not trained"
    if answer.kind == "refusal":
        return "refused"
    if not is_understood(asked, answer):
        return "other kind"
    return "withheld" if answer.abstained else "wrong"


def expected_word(truth: Truth) -> str:
    """Return the deciding word of a right answer, or what stands for one."""
    if truth.abstains:
        return "declined"
    return truth.decided if truth.amount is None else f"some {truth.unit}"


def thread_frame(rng: np.random.Generator) -> FrameSpec:
    """Draw what is known of a thread: each fact is missing a third or a quarter of the time."""
    sides, threads = ("head", "shank", "side", None), ("right", "left", None)
    return FrameSpec(
        contact_side=sides[int(rng.integers(len(sides)))],
        thread=threads[int(rng.integers(len(threads)))],
    )


def _reads_right(
    asked: QuestionAnswer, motion: Motion, frame: FrameSpec, truth: Truth
) -> bool | None:
    """Tell whether a motion that something else read leads to the right answer.

    None where no motion does: amounts, and questions that are always declined.
    """
    if asked.type_id in AMOUNTS:
        return None
    read = truth_of(asked, motion, frame)
    return None if read.abstains and truth.abstains else read == truth
