"""A second classical reference: the curl of the imprint's flow, and logistic regression on it.

The counterpart of the paper's Curl + LR. A closed-form operator sees turns alone: a slide has no
curl, so it tells apart what it is fitted on and nothing else.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import torch
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import GRID_SIDE
from geotlm_lm.core.labels import Motion
from geotlm_lm.probe.linear import LinearProbe
from geotlm_lm.probe.rigid_flow import FIT_STRIDE, RigidFlow
from geotlm_lm.probe.standardise import Standardiser

WEIGHT_FLOOR_GREY = 0.05
"""Contrast of a cell below which its flow is noise; keeps empty cells from dividing by zero."""

PENALTY = 1e-3
"""Ridge on the weights: turns that the features tell apart perfectly would have no finite fit."""


def curl_features(clip: Clip, flow: RigidFlow | None = None) -> NDArray[np.float32]:
    """Return statistics of the curl of the clip's flow, weighted by the imprint's contrast.

    The flow between neighbouring frames is summed, averaged over the cells of a patch grid, and
    differenced: curl = d(down)/dx - d(right)/dy, twice the angle of a rigid turn, in radians and
    positive clockwise as drawn.

    Args:
        clip: Frames in time order, with a background or without.
        flow: What measures the displacement; the reference's own by default.

    Returns:
        float32 (6,): mean, root mean square, mean of the positive and of the negative part, least
        and largest value over the cells.
    """
    fields, contrast, _ = (flow or RigidFlow()).displacements(clip)
    weight = np.mean(contrast, axis=0).astype(np.float32)
    right, down = (_cells(sum(field[..., axis] for field in fields), weight) for axis in range(2))
    rows, columns = weight.shape
    across, below = (FIT_STRIDE * length / GRID_SIDE for length in (columns, rows))
    curl = np.gradient(down, across, axis=1) - np.gradient(right, below, axis=0)
    share = _area_means(weight)
    share = share / max(float(share.sum()), 1e-6)
    present = curl * (share > 0)
    return np.array(
        [
            (share * curl).sum(),
            np.sqrt((share * curl**2).sum()),
            (share * curl.clip(min=0)).sum(),
            (share * curl.clip(max=0)).sum(),
            present.min(),
            present.max(),
        ],
        np.float32,
    )


@dataclass(frozen=True, eq=False)
class CurlRegression:
    """Logistic regression on the curl's statistics.

    Args:
        statistics: Of the training clips' features.
        probe: The fitted layer.
    """

    statistics: Standardiser
    probe: LinearProbe

    @classmethod
    def fit(cls, clips: Iterable[Clip], motions: Sequence[Motion]) -> CurlRegression:
        """Fit on labelled clips of two motions or more.

        Raises:
            ValueError: If there are fewer than two motions, or another number of clips.
        """
        features = torch.from_numpy(np.stack([curl_features(clip) for clip in clips]))
        labels = sorted(set(motions), key=list(Motion).index)
        if len(features) != len(motions):
            raise ValueError(f"{len(features)} clips have {len(motions)} motions")
        statistics = Standardiser.fit(features)
        probe = LinearProbe(features.shape[1], labels)
        _regress(probe, statistics.apply(features), torch.tensor([*map(labels.index, motions)]))
        return cls(statistics, probe)

    def predict(self, clip: Clip) -> Motion:
        """Return the most probable of the motions it was fitted on."""
        features = torch.from_numpy(curl_features(clip))[None]
        return self.probe.predict(self.statistics.apply(features))[0]


def _regress(probe: LinearProbe, features: torch.Tensor, labels: torch.Tensor) -> None:
    """Minimise the cross-entropy with a small ridge, from zero: convex, so one minimum."""
    torch.nn.init.zeros_(probe.head.weight)
    torch.nn.init.zeros_(probe.head.bias)
    solver = torch.optim.LBFGS(probe.parameters(), max_iter=200, line_search_fn="strong_wolfe")

    def closure() -> torch.Tensor:
        solver.zero_grad()
        loss = torch.nn.functional.cross_entropy(probe(features), labels)
        loss = loss + PENALTY * probe.head.weight.square().sum()
        loss.backward()
        return loss

    with torch.enable_grad():
        solver.step(closure)
    probe.requires_grad_(False)


def _cells(values: NDArray[np.floating], weight: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the weighted mean of every cell of the patch grid."""
    floored = weight + np.float32(WEIGHT_FLOOR_GREY)
    return _area_means((values * floored).astype(np.float32)) / _area_means(floored)


def _area_means(values: NDArray[np.float32]) -> NDArray[np.float32]:
    return cv2.resize(values, (GRID_SIDE, GRID_SIDE), interpolation=cv2.INTER_AREA)
