"""The endless series of random clips of a seed, one clip at a time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation.presets import PresetName
from geotlm_lm.simulation.randomise import (
    MARKER_SHARE,
    MIXED_SHARE,
    UNSTEADY_SHARE,
    random_scenes,
)
from geotlm_lm.simulation.simulate import SimulatedClip, simulate

SERIES_VERSION = 9
"""Raised when the same seed gives other clips than before."""


def simulate_series(
    seed: int,
    count: int,
    *,
    objects: Sequence[str],
    first_index: int = 0,
    motions: Sequence[Motion] | None = None,
    preset: PresetName = "fast",
    with_drift: bool = False,
    marker_share: float = MARKER_SHARE,
    unsteady_share: float = UNSTEADY_SHARE,
    mixed_share: float = MIXED_SHARE,
    with_frames: bool = True,
) -> Iterator[SimulatedClip]:
    """Yield clips `first_index` .. of the series of `seed`.

    Arguments are those of `random_scenes` and `simulate`.

    Each scene is drawn right before it is simulated: the profile of its body, a third of the cost,
    is then still at hand and not built a second time.
    """
    for index in range(first_index, first_index + count):
        scenes = random_scenes(
            seed,
            1,
            objects=objects,
            first_index=index,
            motions=motions,
            marker_share=marker_share,
            unsteady_share=unsteady_share,
            mixed_share=mixed_share,
        )
        yield from simulate(
            scenes,
            seed=seed,
            first_index=index,
            preset=preset,
            with_drift=with_drift,
            with_frames=with_frames,
        )
