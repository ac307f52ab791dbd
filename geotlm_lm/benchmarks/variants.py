"""What is held side by side: the language model, the linear probes and classical optical flow.

Binds the loaded model's parts to the form `judging` asks for; holds no numbers of its own.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING

from geotlm_lm.benchmarks.judging import Reply, Variant, timed
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.core.seeding import generator_for
from geotlm_lm.data.questions import WORDINGS, questions_for
from geotlm_lm.probe.rigid_flow import RigidFlow
from geotlm_lm.recordings.idle import estimate_background

if TYPE_CHECKING:
    from geotlm_lm.answering import Answer, Answerer, Encoded

GENERATED = "words"
GENERATED_UNSEEN = "words, unseen wordings"
SCORED = "ten answers scored, of the task"
SCORED_FREE = "ten answers scored"
PROBE = "linear probe, of the task"
PROBE_FREE = "linear probe"
GLOBAL_PROBE = "linear probe without DGR, of the task"
FLOW = "optical flow, of the task"
"""Names of the rows; those "of the task" choose among the task's motions, the others among ten."""

QUESTION = "Which way is it moving?"

CONTRASTS = (
    (GENERATED, PROBE),
    (GENERATED, PROBE_FREE),
    (GENERATED, FLOW),
    (GENERATED_UNSEEN, GENERATED),
    (PROBE, GLOBAL_PROBE),
)
"""Pairs whose difference every table reports."""

ALL_MOTIONS = tuple(Motion)

Read = Callable[["Encoded", tuple[Motion, ...]], Motion | None]
"""Takes a perceived clip and the motions in question."""


def perceived_once(answerer: Answerer) -> Callable[[Clip], Encoded]:
    """Return the model's view of a clip; the same object as last time is not encoded again."""
    return lru_cache(maxsize=1)(answerer.encode)


def all_variants(answerer: Answerer, seed: int) -> dict[str, Variant]:
    """Return every row by its name, in the order of the table.

    Args:
        answerer: The loaded model.
        seed: Root of the draw of question wordings.
    """
    perceive = perceived_once(answerer)
    model = answerer.bundle.model

    # Every row has its own source, so that all rows of one share of wordings ask the same
    # question about the same clip.
    def words(wordings: WORDINGS) -> Read:
        questions = direction_questions(seed, wordings)
        return lambda encoded, among: motion_told(answerer.ask(encoded, questions()))

    def scored() -> Read:
        questions = direction_questions(seed, "seen")
        return lambda encoded, among: most_probable(answerer.score(encoded, questions()), among)

    def probe(encoded: Encoded, among: tuple[Motion, ...]) -> Motion:
        return model.probe.predict(encoded.perception.fused_token, among)[0]

    def global_probe(encoded: Encoded, among: tuple[Motion, ...]) -> Motion:
        return model.global_probe.predict(encoded.perception.global_token, among)[0]

    def among_all(read: Read) -> Read:
        return lambda encoded, among: read(encoded, ALL_MOTIONS)

    return {
        GENERATED: after_perceiving(perceive, words("seen")),
        GENERATED_UNSEEN: after_perceiving(perceive, words("held_out")),
        SCORED: after_perceiving(perceive, scored()),
        SCORED_FREE: after_perceiving(perceive, among_all(scored())),
        PROBE: after_perceiving(perceive, probe),
        PROBE_FREE: after_perceiving(perceive, among_all(probe)),
        GLOBAL_PROBE: after_perceiving(perceive, global_probe),
        FLOW: timed(flow_on_the_guessed_gel),
    }


def flow_on_the_guessed_gel(clip: Clip, among: tuple[Motion, ...]) -> Motion:
    """Return optical flow's choice, given the background the model would guess where none is known.

    Against the mean frame, which it takes otherwise, the ghosts of the other frames' imprints drown
    a small motion.
    """
    background = clip.background
    if background is None:
        background = estimate_background(clip.frames)
    return RigidFlow().predict(clip, among, background)


def direction_questions(seed: int, wordings: WORDINGS) -> Callable[[], str]:
    """Return a source of open questions about direction, another wording at each call.

    The label they are drawn for is always the same, so that no question can give the truth away.
    """
    rng = generator_for(seed, "wordings", wordings)
    label = MotionLabel(Motion.CLOCKWISE)
    return lambda: questions_for(label, rng, types=("T1",), wordings=wordings)[0].question


def motion_told(answer: Answer) -> Motion | None:
    """Return the motion an answer claims, as the camera image shows it; None if it claims none.

    Who asks of "the robot" is told of the sensor, which goes the other way.
    """
    return None if answer.direction is None else answer.frame.in_the_image(answer.direction)


def most_probable(options: Mapping[str, float], among: tuple[Motion, ...]) -> Motion:
    """Return the one of `among` with the largest probability; a missing one has none."""
    return max(among, key=lambda motion: options.get(motion.value, 0.0))


def after_perceiving(perceive: Callable[[Clip], Encoded], read: Read) -> Variant:
    """Return a variant that reads the model's view of a clip.

    Only the reading is timed; what perceiving the clip took when it was done is added.
    """

    def whole(clip: Clip, among: tuple[Motion, ...]) -> Reply:
        started = time.perf_counter()
        try:
            encoded = perceive(clip)
        except UnreadableClip:
            # Whoever refuses a clip has not named its motion; the others are still asked.
            return Reply(None, 1e3 * (time.perf_counter() - started))
        started = time.perf_counter()
        motion = read(encoded, among)
        took = 1e3 * (time.perf_counter() - started)
        return Reply(motion, sum(encoded.timing_ms.values()) + took)

    return whole
