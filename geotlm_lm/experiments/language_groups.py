"""Questions and clips that belong together: all of a group must be answered right.

Guessing, a habit of saying yes, or an eye on the order of the options gets single questions right
and groups wrong. Answers come through the product's own seams: `Answerer` and its sessions.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from geotlm_lm.answering import Comparison, Order
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import ROTATIONS, SLIDES, mirror, reverse
from geotlm_lm.core.seeding import generator_for
from geotlm_lm.data.contents import amount_of
from geotlm_lm.data.groups import in_every_order, reworded, said_and_denied
from geotlm_lm.data.questions import QuestionAnswer, questions_for
from geotlm_lm.experiments.language_cases import Touched, mirrored
from geotlm_lm.experiments.language_truth import is_right, truth_of

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer

WORDINGS_OF_ONE = 4
"""How many wordings of one question a group holds."""

STATEMENTS = (
    ("The image is mirrored. ", FrameSpec(image_mirrored=True)),
    ("The camera is mounted upside down. ", FrameSpec(image_upside_down=True)),
    ("I look from the object's side. ", FrameSpec(viewpoint="object")),
    ("The sensor moved, not the object. ", FrameSpec(actor="sensor")),
)
"""Facts put before a question, and the frame it is then to be answered in."""

DOUBTS = ("Are you sure?", "No, that is wrong.", "Really?", "I don't think so.")

SIMILAR, SURELY_APART = 0.2, 0.33
"""Amounts apart by at most a fifth are similar; from a third on they are not, though each is told
to within a fifth at best. Between the two either answer is right."""

_AMOUNT = re.compile(r"\b(?:further|farther|more|larger|less|smaller|faster|slower)\b", re.I)
_LESS = re.compile(r"\b(?:less|smaller|slower)\b", re.I)


@dataclass(frozen=True)
class Group:
    """One group and what became of it.

    Args:
        name: Of the sort of group.
        family: The unit of resampling.
        right: Whether each of its questions was answered right.
        said: Deciding word of each answer.
    """

    name: str
    family: str
    right: tuple[bool, ...]
    said: tuple[str | None, ...]


def ask_groups(
    answerer: Answerer,
    touches: Sequence[Touched],
    seed: int,
    progress: Callable[[int, int], None],
) -> list[Group]:
    """Ask every group about every clip; a clip is compared with the one before it."""
    groups: list[Group] = []
    for index, touch in enumerate(touches):
        rng = generator_for(seed, "language groups", index)
        groups += _wordings(answerer, touch, rng)
        groups += _claims_and_orders(answerer, touch, rng)
        groups += [_turned_round(answerer, touch, rng), _doubted(answerer, touch, rng)]
        groups += _stated_frames(answerer, touch, rng)
        before = touches[index - 1] if len(touches) > 1 else None
        groups += [] if before is None else _two_clips(answerer, before, touch, rng)
        progress(index + 1, len(touches))
    return groups


def _group(
    answerer: Answerer, touch: Touched, name: str, questions: Sequence[QuestionAnswer]
) -> Group:
    answers = [answerer.ask(touch.encoded, one.question) for one in questions]
    right = tuple(
        is_right(one, answer, truth_of(one, touch.motion, FrameSpec()))
        for one, answer in zip(questions, answers, strict=True)
    )
    return Group(name, touch.family, right, tuple(answer.decided for answer in answers))


def _wordings(answerer: Answerer, touch: Touched, rng: np.random.Generator) -> list[Group]:
    """One open question, and one claim, in several wordings."""
    return [
        _group(answerer, touch, name, reworded(touch.label, type_id, WORDINGS_OF_ONE, rng, share))
        for type_id, share, name in (
            ("T1", "seen", "open question, 4 seen wordings"),
            ("T1", "held_out", "open question, 4 unseen wordings"),
            ("T2", "seen", "one claim, 4 seen wordings"),
        )
    ]


def _claims_and_orders(answerer: Answerer, touch: Touched, rng: np.random.Generator) -> list[Group]:
    """One claim said and denied, and one choice with its options in every order."""
    return [
        _group(answerer, touch, "claim and its denial", said_and_denied(touch.label, rng)),
        _group(answerer, touch, "choice in every order", in_every_order(touch.label, rng)),
    ]


def _turned_round(answerer: Answerer, touch: Touched, rng: np.random.Generator) -> Group:
    """One open question about the clip, its mirror image, and the clip played backwards."""
    (asked,) = questions_for(touch.label, rng, types=["T1"])
    clip, motion = touch.encoded.clip, touch.motion
    seen = [touch.encoded, *(answerer.encode(one) for one in (mirrored(clip), clip.reversed()))]
    answers = [answerer.ask(one, asked.question) for one in seen]
    truths = (motion, mirror(motion), reverse(motion))
    right = tuple(
        is_right(asked, answer, truth_of(asked, truth, FrameSpec()))
        for answer, truth in zip(answers, truths, strict=True)
    )
    name = "clip, mirrored, backwards"
    return Group(name, touch.family, right, tuple(answer.decided for answer in answers))


def _doubted(answerer: Answerer, touch: Touched, rng: np.random.Generator) -> Group:
    """An answer and two doubts about it: "right" is to keep the direction, if one was claimed."""
    (asked,) = questions_for(touch.label, rng, types=["T1"])
    session = answerer.session(touch.encoded)
    first = session.ask(asked.question)
    doubts = rng.permutation(len(DOUBTS))[:2]
    later = [session.ask(DOUBTS[int(i)]) for i in doubts]
    kept = tuple(one.direction == first.direction is not None for one in later)
    return Group("kept under doubt", touch.family, kept, tuple(one.decided for one in later))


def _stated_frames(answerer: Answerer, touch: Touched, rng: np.random.Generator) -> list[Group]:
    """An open question and a claim after a fact about the recording."""
    said, frame = STATEMENTS[int(rng.integers(len(STATEMENTS)))]
    groups = []
    for type_id in ("T1", "T2"):
        (asked,) = questions_for(touch.label, rng, types=[type_id])
        answer = answerer.ask(touch.encoded, said + asked.question)
        right = is_right(asked, answer, truth_of(asked, touch.motion, frame))
        name = f"{type_id} after a stated fact"
        groups.append(Group(name, touch.family, (right,), (answer.decided,)))
    return groups


def _two_clips(
    answerer: Answerer, first: Touched, second: Touched, rng: np.random.Generator
) -> list[Group]:
    """A question that compares two clips, and one for their order, in a conversation."""
    session = answerer.session(first.encoded)
    session.add_clip(second.encoded)
    groups = []
    for type_id, name, grade in (("T9", "two clips", compares), ("T22", "order", orders)):
        (asked,) = questions_for(second.label, rng, types=[type_id])
        if grade is compares and not first.has_amounts and _AMOUNT.search(asked.question):
            continue
        reply = session.ask(asked.question)
        said = getattr(reply, "relation", None) or getattr(reply, "decided", None)
        right = grade(asked.question, reply, first, second)
        groups.append(Group(f"{type_id} {name}", second.family, (right,), (said,)))
    return groups


def orders(question: str, reply: object, first: Touched, second: Touched) -> bool:
    """Tell whether a reply names the motions of both clips in order."""
    return isinstance(reply, Order) and reply.motions == (first.motion, second.motion)


def compares(question: str, reply: object, first: Touched, second: Touched) -> bool:
    """Tell whether a reply compares two clips rightly: their directions, or what is asked for."""
    if not isinstance(reply, Comparison):
        return False
    if not _AMOUNT.search(question):
        one, other = first.motion, second.motion
        opposite = one in (*ROTATIONS, *SLIDES) and other == reverse(one)
        same = "same" if one == other else "opposite" if opposite else "different"
        return reply.relation == same
    amounts = [amount_of(one.label) for one in (first, second)]
    turns = [one.motion in ROTATIONS for one in (first, second)]
    if None in amounts or turns[0] != turns[1]:
        return reply.abstained
    apart = abs(amounts[0] - amounts[1]) / max(amounts)
    is_first = (amounts[0] > amounts[1]) != bool(_LESS.search(question))
    allowed = {"similar"} if apart <= SURELY_APART else set()
    allowed |= {"first" if is_first else "second"} if apart > SIMILAR else set()
    return reply.relation in allowed
