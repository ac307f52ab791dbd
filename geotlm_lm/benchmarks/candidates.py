"""The sign of the asked component: each measured candidate beside the belief, words and rivals.

A learned fusion is only needed where it is better than the best single thing that it is given.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from typing import TYPE_CHECKING

import torch

from geotlm_lm.backbone.motions import MEASURED
from geotlm_lm.benchmarks.cases import HALVES, MIXED_CLIPS, by_half, simulated_mixtures
from geotlm_lm.benchmarks.clips import clip_shares
from geotlm_lm.benchmarks.harness import Cell, Listing, Pivot, Row, Run, Section, Share
from geotlm_lm.benchmarks.judging import Reply, Variant, share_rows
from geotlm_lm.benchmarks.variants import (
    BELIEF,
    FITS,
    GENERATED,
    LEANING,
    Read,
    after_perceiving,
    leaning_of,
    on_gel,
    question_for,
    rivals,
    ways_of,
    words_of,
)
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion
from geotlm_lm.core.twist import COMPONENTS, Component, Twist
from geotlm_lm.motion.measured import Measured
from geotlm_lm.motion.network import belief_of_one
from geotlm_lm.probe.rigid_flow import classify_motion
from geotlm_lm.simulation.truth import READABLE_GREY, twist_of
from geotlm_lm.track.block import measured_of

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer, Encoded
    from geotlm_lm.core.labels import MotionLabel
    from geotlm_lm.motion.belief import Belief
    from geotlm_lm.motion.network import MotionNetwork

CANDIDATES = (*MEASURED, "learned shear")
"""Names of the rows of `Measured.paths`."""

TOLD = "told"
"""What is told by the belief's decision, beside what it leans to."""

TASK_NAMES = ("rotation", "sliding")

SIZES_PX = (0.1, 1.0)
"""Ends of the true paths of mixed motions that are told apart: below nothing is graded."""

METHODS = (BELIEF, *CANDIDATES, *FITS)
"""What is forced to choose."""

MOVING = {Component.TURN: ROTATIONS, Component.SLIDE: SLIDES}
"""Components with a direction in the image -> their ways."""

Ways = Mapping[Component, Motion]


@dataclass(frozen=True, eq=False)
class Leanings:
    """What each method makes of a clip, were it forced to choose."""

    belief: Belief | None = None  # None where the clip was refused: it then names nothing
    # Of the belief, each candidate and each rival.
    ways: Mapping[str, Ways] = field(default_factory=dict)
    # Of each candidate: turn, right, down, px.
    paths: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)

    def named(self, component: Component) -> Motion | None:
        """Return the way that is told of a component; None where it is not told to move."""
        belief = self.belief
        return belief.way(component) if belief and belief.moves(component) >= 0.5 else None

    def leans(self, name: str, component: Component) -> Motion | None:
        """Return the way of a component that a method speaks for."""
        return self.ways.get(name, {}).get(component)


def leanings(answerer: Answerer, clip: Clip) -> Leanings:
    """Return what the belief, its candidates and the rivals make of four frames."""
    try:
        encoded = answerer.encode(clip)
    except UnreadableClip:
        return Leanings()
    paths = paths_of(measured_of(encoded.clip, encoded.perception))
    ways = {BELIEF: {part: encoded.belief.way(part) for part in MOVING}}
    ways |= {name: ways_of(*path) for name, path in paths.items()}
    given = on_gel(clip)
    for name, rival in FITS.items():
        fit = rival.fit(given)
        ways[name] = {part: classify_motion(fit, among) for part, among in MOVING.items()}
    return Leanings(encoded.belief, ways, paths)


def paths_of(seen: Measured) -> dict[str, tuple[float, float, float]]:
    """Return the paths that are measured of a clip, by the names of what measures them."""
    paths = seen.paths[0].tolist()
    return {name: tuple(path) for name, path in zip(CANDIDATES, paths, strict=False)}


def twists_of(encoded: Encoded) -> dict[str, Twist]:
    """Return the motions that are measured of a clip, by the names of what measures them."""
    seen = measured_of(encoded.clip, encoded.perception)
    radius = float(seen.radius_px[0])
    return {
        name: Twist(math.degrees(turn / radius), right, down, 0.0)
        for name, (turn, right, down) in paths_of(seen).items()
    }


@torch.inference_mode()
def weights_of(answerer: Answerer, seen: Measured) -> dict[str, float]:
    """Return how much each of what is measured weighs."""
    weights = answerer.bundle.motion(seen).weights[0].tolist()
    return dict(zip(CANDIDATES, weights, strict=True))


def candidate_variants(answerer: Answerer, seed: int) -> dict[str, Variant]:
    """Return words, what is told, the leaning, each candidate alone and the rivals, by name.

    The network is also asked without each part of what it learned.
    """
    perceive = lru_cache(maxsize=1)(answerer.encode)

    @lru_cache(maxsize=1)
    def seen(encoded: Encoded) -> Measured:
        return measured_of(encoded.clip, encoded.perception)

    def words(encoded: Encoded, among: tuple[Motion, ...]) -> Motion | None:
        ways = map(encoded.belief.way, encoded.belief.by_size())
        return next((way for way in ways if way in among), None)

    def alone(name: str) -> Read:
        def read(encoded: Encoded, among: tuple[Motion, ...]) -> Motion | None:
            path = paths_of(seen(encoded)).get(name)
            ways = ways_of(*path).values() if path else ()
            return next((way for way in ways if way in among), None)

        return read

    def without(network: MotionNetwork) -> Read:
        @torch.inference_mode()
        def read(encoded: Encoded, among: tuple[Motion, ...]) -> Motion:
            return leaning_of(belief_of_one(network(seen(encoded))), among)

        return read

    reads = {GENERATED: words_of(answerer, question_for), TOLD: words}
    reads |= {LEANING: lambda encoded, among: leaning_of(encoded.belief, among)}
    reads |= {name: alone(name) for name in CANDIDATES}
    network = answerer.bundle.motion
    for part in network.PARTS:
        reads[f"belief without {part}"] = without(network.without(part))
    own = {name: after_perceiving(perceive, read) for name, read in reads.items()}
    leaning = own[LEANING]

    def weighed(clip: Clip, among: tuple[Motion, ...]) -> Reply:
        weights = weights_of(answerer, seen(perceive(clip)))
        return replace(leaning(clip, among), weights=weights)

    return own | {LEANING: weighed} | rivals()


def candidate_shares(run: Run) -> dict[str, Share]:
    """Return what yields the rows of each source of clips, and of simulated mixtures."""
    sources = clip_shares(run, HALVES, {}, TASK_NAMES, candidate_variants)
    shares: dict[str, Share] = {name: partial(_with_best, share) for name, share in sources.items()}
    return shares | {"simulated mixtures": partial(_with_best, partial(mixed_rows, run))}


def _with_best(share: Share) -> Iterator[Row]:
    """Yield rows; those of the leaning tell the best candidate of their case."""
    rows = list(share())
    alone: dict[str, list[Row]] = {}
    for row in rows:
        if row.variant in CANDIDATES:
            alone.setdefault(row.case, []).append(row)
    for row in rows:
        if row.variant == LEANING and row.case in alone:
            best = max(alone[row.case], key=lambda other: other.right)
            nearest = {"name": best.variant, "difference": best.error - row.error}
            row = replace(row, detail={**row.detail, "best": nearest})
        yield row


def mixed_rows(run: Run) -> Iterator[Row]:
    """Yield the sign of each component of simulated mixed motions, by the size of its path."""
    count = run.size(MIXED_CLIPS, 6)
    variants = candidate_variants(run.answerer, run.seed)
    graded, wrong = [], {}
    for done, made in enumerate(simulated_mixtures(count, run.seed), start=1):
        for component, size, truth in _seen_of(made.label):
            case = f"simulated mixtures, {component}, {size}"
            for name, variant in variants.items():
                motion = variant(made.clip, MOVING[component]).motion
                graded.append((case, name, motion is truth, made.object_name))
                own = wrong.setdefault((case, name), [])
                own.append(motion is not truth and motion in MOVING[component])
        run.progress("simulated mixtures", done, count)
    for row in share_rows(graded, run.seed):
        share = sum(wrong[row.case, row.variant]) / row.count
        yield replace(row, detail={**row.detail, "wrong_way": share})


def _seen_of(label: MotionLabel) -> Iterator[tuple[Component, str, Motion]]:
    """Yield each component whose picture tells it, the size of its path and its true way."""
    twist, (least, small) = twist_of(label), SIZES_PX
    for component, grey in zip(COMPONENTS, label.visible_grey, strict=True):
        path = twist.path(component, label.radius_px)
        # What is small changes a picture little: it is told by what a pixel of it would change.
        if component in MOVING and path >= least and grey >= READABLE_GREY * min(path, 1.0):
            size = f"{least:g} to {small:g} px" if path < small else f"{small:g} px or more"
            yield component, size, twist.way(component)


def _against(name: str) -> dict[str, Cell]:
    return {
        name: lambda row: row.detail.get(name, {}).get("name", "-"),
        f"leaning less {name}": lambda row: (
            f"{row.detail[name]['difference']:+.3f}" if name in row.detail else "-"
        ),
    }


_RIVALRY = {
    "clips": "case",
    "n": "count",
    "leaning": "right:.3f",
    **_against("best"),
    **_against("rival"),
    "below the rival": lambda row: "below" * row.detail.get("rival", {}).get("is_below", False),
    "weights": lambda row: " ".join(f"{x:.2f}" for x in row.detail.get("weights", {}).values()),
}

_TOLD = {
    "clips": "case",
    "n": "count",
    "method": "variant",
    "the right way": "right:.3f",
    "the wrong way": "wrong_way:.3f",
}


def _is_told(row: Row) -> bool:
    return row.variant in (TOLD, GENERATED)


CANDIDATE_SECTION = Section(
    name="candidates",
    title="What is measured, each alone",
    about=f"""\
The sign of the asked component, as a forced choice: what the belief leans to beside each
measurement that it is given, alone, and two rivals; what is told, and told the wrong way, apart.
A leaning is *below* the better rival by more than one clip and 0.005. *Weights* are those of
{", ".join(CANDIDATES)}, on the mean, where the network tells any. *Without* is
what the belief leans to where one learned part of the network is left out. Of simulated mixtures
each component that shows is asked about, by the size of its true path.""",
    views=by_half(Pivot("right:.3f", shows=lambda row: not _is_told(row)), "As a forced choice")
    | by_half(Listing(_RIVALRY, lambda row: row.variant == LEANING), "The leaning")
    | by_half(Listing(_TOLD, _is_told), "Told"),
    shares=candidate_shares,
)
