"""What is held side by side: words, the model's slots, the linear probes, two classical rivals.

Binds the loaded model's parts to the form `judging` asks for; holds no numbers of its own.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

from geotlm_lm.alignment.dots import without_dots
from geotlm_lm.benchmarks.judging import Reply, Variant, timed
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion
from geotlm_lm.core.twist import WAYS, Component
from geotlm_lm.language.size import SLOTS
from geotlm_lm.probe.rigid_alignment import RigidAlignment
from geotlm_lm.probe.rigid_flow import RigidFlow
from geotlm_lm.query.program import WAY_ATOMS
from geotlm_lm.recordings.idle import estimate_background, touched_part
from geotlm_lm.training.grammar import grammar

if TYPE_CHECKING:
    from geotlm_lm.answering import Answer, Answerer, Encoded
    from geotlm_lm.checkpoint import Bundle
    from geotlm_lm.motion.belief import Belief

GENERATED = "words"
GENERATED_UNSEEN = "words, unseen wordings"
SLOTS_OWN = "language model's slots, of the task"
PROBE = "linear probe, of the task"
GLOBAL_PROBE = "linear probe without DGR, of the task"
"""Names of the rows; those "of the task" choose among the task's motions, words among ten. What
words say is decided by the belief; what the language model says itself stands at its slots."""

BELIEF = "belief"
LEANING = "belief, of the task"
"""What it leans to among the task's motions, where nothing is told as well."""

FITS: dict[str, RigidFlow | RigidAlignment] = {
    "optical flow": RigidFlow(),
    "direct alignment": RigidAlignment(),
}
"""Classical rivals that fit a rigid motion to a clip and learn nothing."""

RIVALS = FLOW, ALIGNMENT = tuple(f"{name}, of the task" for name in FITS)
"""What the belief's leaning may not be worse than."""

QUESTION = "Which way is it moving?"
"""Asked where any of the ten motions may come."""

COMPONENTS = {ROTATIONS: ("turn", "turning"), SLIDES: ("slide", "sliding")}
"""Motions of a task -> the word of programs that names it, and the one of questions."""

NamedWays = tuple[Motion | None, tuple[Motion, ...]]
"""The motion that is named, and every way that a turn or a slide is claimed to go."""

Read = Callable[["Encoded", tuple[Motion, ...]], Motion | NamedWays | None]
"""Takes a perceived clip and the motions in question."""


def all_variants(answerer: Answerer, seed: int) -> dict[str, Variant]:
    """Return every row by its name, in the order of the table; `seed` draws question wordings."""
    # The same clip as last time is not encoded again.
    perceive, model = lru_cache(maxsize=1)(answerer.encode), answerer.bundle.model
    probe, plain = model.probe, model.global_probe

    def slots(encoded: Encoded, among: tuple[Motion, ...]) -> NamedWays:
        belief = belief_of_slots(answerer.bundle, encoded)
        ways = (belief.way(part) for part in belief.by_size() if part is not Component.PRESS)
        return max(among, key=shares_of(belief).__getitem__), tuple(ways)

    reads = {
        GENERATED: words_of(answerer, question_for),
        GENERATED_UNSEEN: words_of(answerer, unseen_wordings(seed)),
        LEANING: lambda seen, among: leaning_of(seen.belief, among),
        SLOTS_OWN: slots,
        PROBE: lambda seen, among: probe.predict(seen.perception.fused_token, among)[0],
        GLOBAL_PROBE: lambda seen, among: plain.predict(seen.perception.global_token, among)[0],
    }
    return {name: after_perceiving(perceive, read) for name, read in reads.items()} | rivals()


def words_of(answerer: Answerer, question: Callable[[tuple[Motion, ...]], str]) -> Read:
    """Return what asks a question about motions of a task, and reads the answer."""

    def ask(encoded: Encoded, among: tuple[Motion, ...]) -> NamedWays:
        answer = answerer.ask(encoded, question(among))
        return answer.in_the_image, ways_claimed(answer)

    return ask


def rivals() -> dict[str, Variant]:
    """Return the two classical rivals by name."""
    return dict(zip(RIVALS, (rival(fit.predict) for fit in FITS.values()), strict=True))


def rival(predict: Callable[[Clip, tuple[Motion, ...]], Motion]) -> Variant:
    """Return a rival, given the idle gel that the model would guess where none is known.

    Against the mean frame, which it takes otherwise, the ghosts of the other frames' imprints drown
    a small motion. Of a whole recording it is given the part in contact: step by step the noise of
    an untouched gel would add up to any motion. Of a gel with dots its shading alone is taken off,
    as the model does: a rival sees the dots too.
    """
    return timed(lambda clip, among: predict(on_gel(clip), among))


def on_gel(clip: Clip) -> Clip:
    """Return what a rival is given of a clip, with its idle gel; see `rival`."""
    if clip.background is None:
        clip = replace(clip, background=estimate_background(clip.frames))
    clip = clip if len(clip) <= FRAME_COUNT else touched_part(clip)
    return replace(clip, background=without_dots(clip.background))


def belief_of_slots(bundle: Bundle, encoded: Encoded) -> Belief:
    """Return what the language model itself says at its slots, which decides nothing.

    How far it goes is no word of a slot, and stays as it is believed.
    """
    ways, contact = {}, 0.0
    for slot, likelihoods in encoded.prefix.slots.items():
        shares = bundle.calibration.slot_probabilities(likelihoods, doubt=encoded.doubt)
        by_word = dict(zip(SLOTS[slot], shares.tolist(), strict=True))
        if slot == "contact":
            contact = by_word["touch"]
        else:
            ways |= {WAY_ATOMS[word]: share for word, share in by_word.items() if word != "none"}
    ways = {way: share * contact for way, share in ways.items()}
    return replace(encoded.belief, ways=ways, contact=contact)


def shares_of(belief: Belief) -> dict[Motion, float]:
    """Return the probability of each motion; several may hold at once."""
    touching = max(belief.contact, *map(belief.moves, WAYS))
    still = touching
    for component in WAYS:
        still *= max(1 - belief.moves(component) / max(touching, 1e-9), 0.0)
    return {**belief.ways, Motion.STILL: still, Motion.NONE: 1 - touching}


def leaning_of(belief: Belief, among: Sequence[Motion]) -> Motion:
    """Return the likeliest of some motions; where probability tells none, by the mean's sign."""
    shares, mean = shares_of(belief), belief.mean
    speaks_for = ways_of(mean.turn_deg, mean.right_px, mean.down_px).values()
    return max(among, key=lambda way: (shares[way], way in speaks_for))


def ways_of(turn: float, right: float, down: float) -> dict[Component, Motion]:
    """Return the ways that a turn and a travel speak for, however short they are."""
    axes = (right, Motion.RIGHT), (-right, Motion.LEFT), (down, Motion.DOWN), (-down, Motion.UP)
    sense = Motion.CLOCKWISE if turn > 0 else Motion.COUNTERCLOCKWISE
    return {Component.TURN: sense, Component.SLIDE: max(axes)[1]}


def question_for(among: Sequence[Motion]) -> str:
    """Return the open question about motions of a task: which way it turns, slides or moves."""
    words = COMPONENTS.get(tuple(among))
    return f"Which way is it {words[1]}?" if words else QUESTION


def unseen_wordings(seed: int) -> Callable[[tuple[Motion, ...]], str]:
    """Return a source of open questions in wordings kept from training, another at each call.

    They are drawn by what is asked alone, so that no question can give the truth away.
    """
    words = {among: word for among, (word, _) in COMPONENTS.items()}
    asked = {
        word: grammar().wordings(seed, "test", f"way {word}") for word in (*words.values(), "all")
    }
    return lambda among: next(asked[words.get(tuple(among), "all")]).text


def ways_claimed(answer: Answer) -> tuple[Motion, ...]:
    """Return the ways a turn and a slide are claimed to go, as the camera image shows them.

    An answer claims what more probably counts in its `motion` than not, and a withheld answer
    nothing.
    """
    motion = answer.motion
    if motion is None or answer.abstained:
        return ()
    counting = (part for part in (Component.TURN, Component.SLIDE) if motion.moves[part] >= 0.5)
    return tuple(motion.ways[part] for part in counting)


def after_perceiving(perceive: Callable[[Clip], Encoded], read: Read) -> Variant:
    """Return a variant that reads the model's view of a clip.

    Only the reading is timed; what perceiving the clip took when it was done is added.
    """

    def whole(clip: Clip, among: tuple[Motion, ...]) -> Reply:
        started = time.perf_counter()
        try:
            encoded = perceive(clip)
        except UnreadableClip:
            # A refused clip's motion was not named; the other variants are still asked.
            return Reply(None, 1e3 * (time.perf_counter() - started))
        started = time.perf_counter()
        result = read(encoded, among)
        took = 1e3 * (time.perf_counter() - started)
        motion, claims = result if isinstance(result, tuple) else (result, None)
        return Reply(motion, sum(encoded.timing_ms.values()) + took, claims)

    return whole
