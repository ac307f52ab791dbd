"""Clips to talk about, perceived once, each with its truth and what other readers make of it.

Knows where clips come from and how to turn them round; asks nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import torch

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import REGIONS, TIME_BIN_COUNT
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.dgr.regions import pool_regions
from geotlm_lm.experiments.cases import RealCases, SimulatedCases
from geotlm_lm.probe.rigid_flow import RigidFlow
from geotlm_lm.training.examples import truth_in

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer, Encoded
    from geotlm_lm.conversation.reasons import Regions
    from geotlm_lm.simulation.simulate import SimulatedClip

ALL_MOTIONS = tuple(Motion)


@dataclass(frozen=True, eq=False)
class Touched:
    """A perceived clip, what is true of it, and what else reads its motion.

    Args:
        encoded: The model's view of it.
        label: The truth; amounts are 0 where they are not known.
        has_amounts: Whether the label says how far it goes.
        object_id: What is touched.
        family: Objects that are not independent of each other: the unit of resampling.
        field: The true displacement's change in the seven regions; None where it is not known.
        readings: What the linear probe and optical flow read, among all ten motions.
    """

    encoded: Encoded
    label: MotionLabel
    has_amounts: bool
    object_id: str
    family: str
    field: Regions | None
    readings: Mapping[str, Motion]

    @property
    def motion(self) -> Motion:
        """The true motion, in the camera image."""
        return self.label.motion


PROBE, FLOW = "probe", "flow"


def simulated_touches(
    answerer: Answerer, count: int, seed: int, progress: Callable[[int, int], None]
) -> Iterator[Touched]:
    """Yield readable simulated clips of objects that no weight was trained on."""
    for done, made in enumerate(SimulatedCases("all", count, seed).made(), start=1):
        encoded = answerer.encode(made.clip)
        name = made.object_name
        yield Touched(
            encoded=encoded,
            label=made.label,
            has_amounts=True,
            object_id=name,
            family=name,
            field=true_regions(encoded, made),
            readings=_readings(answerer, encoded),
        )
        progress(done, count)


def real_touches(
    answerer: Answerer, cases: RealCases, count: int, progress: Callable[[int, int], None]
) -> Iterator[Touched]:
    """Yield four-frame windows of labelled recordings, each forwards and backwards.

    Args:
        answerer: The model.
        cases: The recordings.
        count: How many windows at most, spread evenly over the table.
        progress: Told how many clips are done of how many.
    """
    rows = cases.recordings.rows
    at = np.unique(np.linspace(0, len(rows) - 1, min(count, len(rows))).round().astype(int))
    chosen = replace(cases.recordings, rows=tuple(rows[i] for i in at))
    for done, window in enumerate(chosen.windows(frames=("four",), backwards=True), start=1):
        encoded = answerer.encode(window.clip)
        yield Touched(
            encoded=encoded,
            label=MotionLabel(window.motion),
            has_amounts=False,
            object_id=window.row.object_id,
            family=window.row.object_family,
            field=None,
            readings=_readings(answerer, encoded),
        )
        progress(done, 2 * len(at))


def mirrored(clip: Clip) -> Clip:
    """Return what a camera behind a mirror would have recorded."""
    background = None if clip.background is None else clip.background[:, ::-1].copy()
    return replace(clip, frames=clip.frames[:, :, ::-1].copy(), background=background)


def blind(touches: list[Touched]) -> Encoded:
    """Return the mean clip: what a model sees that is told nothing of the clip asked about.

    Fused token, geometry, inputs and evened motions are the means over `touches`; its frames are
    those of the first clip that is touched.
    """
    touched = next((one for one in touches if one.motion is not Motion.NONE), touches[0])
    seen = [one.encoded.perception for one in touches]
    geometry = touched.encoded.perception.geometry
    means = {
        name: torch.stack([getattr(one.geometry, name) for one in seen]).mean(dim=0)
        for name in ("shear", "shear_change", "mask", "region_mass", "descriptor", "feature")
    }
    inputs = [one.inputs for one in seen]
    perception = replace(
        touched.encoded.perception,
        global_token=torch.stack([one.global_token for one in seen]).mean(dim=0),
        fused_token=torch.stack([one.fused_token for one in seen]).mean(dim=0),
        geometry=replace(geometry, **means),
        inputs=None if any(one is None for one in inputs) else torch.stack(inputs).mean(dim=0),
    )
    evened = torch.stack([one.encoded.evened for one in touches]).mean(dim=0)
    return replace(touched.encoded, perception=perception, given_evened=evened)


def true_regions(encoded: Encoded, made: SimulatedClip) -> Regions | None:
    """Return the change of the true displacement in the seven regions of the model's view.

    Displacements count from the first frame, in pixels of the square view; patches weigh by their
    contact. None where the view is no square.
    """
    if encoded.view is None:
        return None
    moved, contact, _ = truth_in(encoded.view, made)
    order = list(encoded.clip.frame_numbers)
    early, late = moved[order].reshape(TIME_BIN_COUNT, -1, *moved.shape[1:]).mean(axis=1)
    mask = torch.from_numpy(contact[order].mean(axis=0))[None].double()
    change = torch.from_numpy(late - early)[None].double()
    x, y = (pool_regions(change[..., axis], mask)[0].tolist() for axis in range(2))
    return {
        name: {"shear_change_x": x[column], "shear_change_y": y[column]}
        for column, name in enumerate(REGIONS)
    }


def _readings(answerer: Answerer, encoded: Encoded) -> dict[str, Motion]:
    probe = answerer.bundle.model.probe
    return {
        PROBE: probe.predict(encoded.perception.fused_token, ALL_MOTIONS)[0],
        FLOW: RigidFlow().predict(encoded.clip, ALL_MOTIONS),
    }
