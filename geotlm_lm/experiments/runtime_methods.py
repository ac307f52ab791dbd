"""Everything that names a motion, side by side: what it says, what it measures, how long it takes.

The model's rows share one perception of a clip, as an answer to several questions does; each counts
the perception's time in full.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import cv2

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.core.labels import ROTATIONS, Motion
from geotlm_lm.experiments.judging import QUESTION
from geotlm_lm.experiments.methods import most_probable
from geotlm_lm.model import rigid_motion
from geotlm_lm.precision import runnable
from geotlm_lm.probe.curl import CurlRegression
from geotlm_lm.probe.rigid_flow import RigidFlow, decide

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer, Encoded

FLOWS = {
    "flow + fit, ultrafast": RigidFlow(preset=cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST),
    "flow + fit, fast": RigidFlow(),
    "flow + fit, fast, no reweighting": RigidFlow(reweightings=0),
    "flow + fit, medium": RigidFlow(preset=cv2.DISOPTICAL_FLOW_PRESET_MEDIUM),
}
CURL = "Curl + LR"
PROBE_C, PROBE_Z, SCORED, WORDS, WHY = (
    "probe on c",
    "probe on z",
    "LM scored",
    "LM generated",
    "LM generated, --why",
)
"""Rows of the model, in each precision asked for."""

WHOLE_MOTION = {FRAME_COUNT: 1.5, 2: 1.0}
"""Frames -> the motion from the first to the last in parts of that between the two time-bins, which
hold the means of two frames each: 0.5 to 2.5 of 3 steps; or one frame each."""


@dataclass(frozen=True)
class Timed:
    """What one method made of one clip.

    Args:
        motion: Named; None where it named none.
        milliseconds: From the clip in memory.
        turn_deg: The turn it measured, clockwise; None where it measures none.
        slide_px: The travel it measured (right, down).
    """

    motion: Motion | None
    milliseconds: float
    turn_deg: float | None = None
    slide_px: tuple[float, float] | None = None


Ask = Callable[[Clip, Sequence[Motion]], dict[str, Timed]]
"""One clip and the motions in question -> what each of a group's methods made of it."""


def flow_group(among_turns_only: CurlRegression | None) -> Ask:
    """Return the classical methods; Curl + LR, where it is fitted, is asked about turns alone."""

    def ask(clip: Clip, among: Sequence[Motion]) -> dict[str, Timed]:
        found = {}
        for name, flow in FLOWS.items():
            started = time.perf_counter()
            moved = flow.fit(clip)
            motion = decide(moved, among)
            took = 1e3 * (time.perf_counter() - started)
            slide = (moved.slide_x_px, moved.slide_y_px)
            found[name] = Timed(motion, took, moved.rotation_deg, slide)
        if among_turns_only is not None and set(among) <= set(ROTATIONS):
            started = time.perf_counter()
            motion = among_turns_only.predict(clip)
            found[CURL] = Timed(motion, 1e3 * (time.perf_counter() - started))
        return found

    return ask


def model_group(answerer: Answerer, suffix: str = "", *, with_why: bool = False) -> Ask:
    """Return the model's read-outs; `suffix` ends their names.

    Args:
        answerer: The model, in whatever precision.
        suffix: What tells its rows from those of another precision.
        with_why: Whether the reasons are told as well, in a row of their own.
    """

    def ask(clip: Clip, among: Sequence[Motion]) -> dict[str, Timed]:
        names = [PROBE_C, PROBE_Z, SCORED, WORDS, *([WHY] if with_why else [])]
        started = time.perf_counter()
        try:
            encoded = answerer.encode(clip)
        except UnreadableClip:
            took = 1e3 * (time.perf_counter() - started)
            return {name + suffix: Timed(None, took) for name in names}
        perceived = 1e3 * (time.perf_counter() - started)
        measured = _measured(encoded, len(clip))
        return {
            name + suffix: _timed(perceived, read, measured)
            for name, read in _readers(answerer, encoded, tuple(among), with_why).items()
        }

    return ask


def model_groups(answerer: Answerer, precisions: Sequence[str]) -> dict[str, Ask]:
    """Return the model's methods in each precision; the reasons in float32 alone.

    A precision that this processor or this torch cannot run is left out of the groups.
    """
    groups = {}
    for precision in precisions:
        if precision == "float32":
            groups[precision] = model_group(answerer, with_why=True)
        elif (changed := changed_answerer(answerer, precision)) is not None:
            groups[precision] = model_group(changed, f", {precision}")
    return groups


def changed_answerer(answerer: Answerer, precision: str) -> Answerer | None:
    """Return the model in another precision; None where this machine cannot run it."""
    changed = runnable(answerer.bundle, precision)
    return None if changed is None else type(answerer)(changed)


def _readers(
    answerer: Answerer, encoded: Encoded, among: tuple[Motion, ...], with_why: bool
) -> Mapping[str, Callable[[], Motion | None]]:
    model, perception = answerer.bundle.model, encoded.perception

    def why() -> Motion | None:
        answer = answerer.ask(encoded, QUESTION)
        answerer.why(encoded, answer)
        return answer.direction

    readers = {
        PROBE_C: lambda: model.global_probe.predict(perception.global_token, among)[0],
        PROBE_Z: lambda: model.probe.predict(perception.fused_token, among)[0],
        SCORED: lambda: most_probable(answerer.score(encoded, QUESTION), among),
        WORDS: lambda: answerer.ask(encoded, QUESTION).direction,
    }
    return readers | ({WHY: why} if with_why else {})


def _timed(
    perceived_ms: float,
    read: Callable[[], Motion | None],
    measured: tuple[float, tuple[float, float]] | None,
) -> Timed:
    started = time.perf_counter()
    motion = read()
    took = perceived_ms + 1e3 * (time.perf_counter() - started)
    if measured is None:
        return Timed(motion, took)
    return Timed(motion, took, measured[0], measured[1])


def _measured(encoded: Encoded, frames: int) -> tuple[float, tuple[float, float]] | None:
    """Return the turn and the slide in the learned shear change, over the whole clip."""
    if encoded.view is None or frames not in WHOLE_MOTION:
        return None
    geometry = encoded.perception.geometry
    turn, x, y = rigid_motion(geometry, encoded.view, encoded.clip.frames.shape[1:3])
    whole = WHOLE_MOTION[frames]
    return whole * turn, (whole * x, whole * y)
