"""The classical reference: dense optical flow of the imprint and the rigid motion that fits it.

No learning and no knowledge of the simulator; every constant is stated and none is trained.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import camera_size
from geotlm_lm.core.labels import DIRECTED, ROTATIONS, SLIDES, Motion, signed_amount
from geotlm_lm.core.numbers import quantile_by_rank

Field = NDArray[np.float32]


@dataclass(frozen=True)
class RigidMotion:
    """What one rigid motion explains of a clip, from its first to its last frame.

    Lengths are in px of the clip's own frames; of a camera's 320 x 240 where they were squashed to
    a square (`core.geometry.camera_size`): only there is a turn rigid.
    """

    rotation_deg: float  # turn of the imprint, positive clockwise as drawn in the image
    slide_x_px: float  # travel of the imprint's centre to the right
    slide_y_px: float  # travel of the imprint's centre down the image, same unit
    radius_px: float  # radius of gyration of the imprint's contrast, same unit
    side_px: int  # longer side of the clip's frames
    # Mean contrast of the imprint in the first and in the last frame, grey levels.
    contrast: tuple[float, float]

    @property
    def turn_px(self) -> float:
        """Signed path of a point at the radius of gyration, to be compared with the slide."""
        return float(np.radians(self.rotation_deg) * self.radius_px)

    @property
    def slide_px(self) -> float:
        """Length of the slide."""
        return float(np.hypot(self.slide_x_px, self.slide_y_px))

    @property
    def path_share(self) -> float:
        """The longer of turn and slide, as a share of the frame's longer side."""
        return max(abs(self.turn_px), self.slide_px) / self.side_px


@dataclass(frozen=True)
class RigidFlow:
    """Dense inverse search flow between neighbouring frames, and a weighted rigid fit to it."""

    # OpenCV's preset of the flow: 0 ultrafast, 1 fast, 2 medium.
    preset: int = cv2.DISOPTICAL_FLOW_PRESET_FAST

    def fit(self, clip: Clip) -> RigidMotion:
        """Measure the rigid motion of the imprint, summed over neighbouring frames.

        Frames larger than `LONGEST_SIDE` are shrunk to it. Without a background the mean frame
        stands for the idle gel.
        """
        fields, contrast, shrink = self.displacements(clip)
        total = np.zeros(3)
        for field, weight in zip(fields, contrast[:-1], strict=True):
            turn_rad, slide_x, slide_y = fit_rigid(field, weight, REWEIGHTINGS, FIT_STRIDE)
            total += (turn_rad, slide_x, slide_y)
        radius = radius_of_gyration(np.mean(contrast, axis=0)) * FIT_STRIDE
        return RigidMotion(
            rotation_deg=float(np.degrees(total[0])),
            slide_x_px=float(total[1] / shrink),
            slide_y_px=float(total[2] / shrink),
            radius_px=float(radius / shrink),
            side_px=max(camera_size(*clip.frames.shape[1:3])),
            contrast=(float(contrast[0].mean()), float(contrast[-1].mean())),
        )

    def displacements(self, clip: Clip) -> tuple[list[Field], list[Field], float]:
        """Measure the flow between neighbouring frames.

        Returns:
            On every `FIT_STRIDE`-th pixel: displacements (rows, columns, 2) in px of the frames
            compared, one fewer than frames; contrast (rows, columns) of every frame, grey levels;
            and the factor by which the clip's frames were shrunk.
        """
        rows, columns = camera_size(*clip.frames.shape[1:3])
        shrink = min(1.0, LONGEST_SIDE / max(rows, columns))
        residuals, size = residuals_of(clip), (round(columns * shrink), round(rows * shrink))
        if size != residuals[0].shape[::-1]:
            how = cv2.INTER_AREA if shrink < 1 else cv2.INTER_LINEAR
            residuals = [cv2.resize(residual, size, interpolation=how) for residual in residuals]
        levels = (np.clip(NEUTRAL + GAIN * residual, 0, 255) for residual in residuals)
        imprints = [level.astype(np.uint8) for level in levels]
        contrast = [imprint_contrast(residual) for residual in residuals]
        flow = cv2.DISOpticalFlow_create(self.preset)
        flow.setPatchSize(PATCH_PX)
        fields = [
            flow.calc(early, late, None)[::FIT_STRIDE, ::FIT_STRIDE]
            for early, late in zip(imprints[:-1], imprints[1:], strict=True)
        ]
        return fields, contrast, shrink

    def predict(self, clip: Clip, among: Iterable[Motion] = DIRECTED) -> Motion:
        """Return the motion, among those asked about, that the rigid fit speaks for."""
        return classify_motion(self.fit(clip), among)


def classify_motion(motion: RigidMotion, among: Iterable[Motion]) -> Motion:
    """Return the one of `among` that a rigid motion speaks for.

    Untouched gel first, then stillness, then an imprint that grows or fades and hardly travels,
    then the larger of turn and slide, compared by the path each causes in px.

    Raises:
        ValueError: If `among` is empty.
    """
    asked = [Motion(name) for name in among]
    if not asked:
        raise ValueError("name at least one motion to decide among")
    directed = [way for way in asked if way in DIRECTED]
    first, last = motion.contrast
    if Motion.NONE in asked and max(first, last) < TOUCH_CONTRAST:
        return Motion.NONE
    growth = (last - first) / max(first, last, 1e-6)
    pressing = Motion.PRESS if growth > 0 else Motion.RELEASE
    grows = abs(growth) > GROWTH
    if pressing in asked and grows and (motion.path_share < PRESS_PATH_SHARE or not directed):
        return pressing
    if Motion.STILL in asked and (motion.path_share < STILL_PATH_SHARE or not directed):
        return Motion.STILL
    if not directed:
        return pressing if pressing in asked else asked[0]
    return _dominant_direction(motion, directed)


def imprint_contrast(residual: Field) -> Field:
    """Return how far each point is from the idle gel: the weight of the fit, grey levels.

    Smoothed, so that sensor noise weighs next to nothing, and free of a change of exposure.
    """
    smooth = cv2.GaussianBlur(residual, (0, 0), NOISE_SIGMA_PX)[::FIT_STRIDE, ::FIT_STRIDE]
    return np.abs(smooth - quantile_by_rank(smooth[::2, ::2]))


def _dominant_direction(motion: RigidMotion, directed: list[Motion]) -> Motion:
    path = {
        way: signed_amount(
            way, turn=motion.turn_px, right=motion.slide_x_px, down=motion.slide_y_px
        )
        for way in DIRECTED
    }
    turns = [way for way in directed if way in ROTATIONS]
    slides = [way for way in directed if way in SLIDES]
    if turns and slides:
        directed = turns if abs(motion.turn_px) > TURN_SHARE * motion.slide_px else slides
    return max(directed, key=path.__getitem__)


def residuals_of(clip: Clip) -> list[Field]:
    """Return each frame's green channel less the idle gel, or less the mean frame, grey levels."""
    frames = [frame[..., GREEN].astype(np.float32) for frame in clip.frames]
    idle = np.mean(frames, axis=0)
    if clip.background is not None:
        idle = clip.background[..., GREEN].astype(np.float32)
    return [frame - idle for frame in frames]


def fit_rigid(
    field: Field,
    weight: Field,
    reweightings: int = 0,
    grid_px: float | tuple[float, float] = 1.0,
) -> tuple[float, float, float]:
    """Fit a turn and a slide to a displacement field, by weighted least squares.

    The slide is the weighted mean displacement; the turn about the weighted centre has a closed
    form (the two-dimensional orthogonal Procrustes problem). Each reweighting divides the weight
    by 1 + (misfit / rms misfit)^2, so that what does not turn with the imprint drops out.

    The field holds displacements (x, y) in px, (rows, columns, 2); the weight is (rows, columns),
    not negative; `grid_px` is the distance of neighbouring points, of x and y where they differ.

    Returns:
        Turn in rad, positive clockwise as drawn; slide along x and y in px. Zeros when there is
        no weight.
    """
    rows, columns = weight.shape
    grid_x, grid_y = np.broadcast_to(np.float32(grid_px), 2)
    x = np.arange(columns, dtype=np.float32)[None, :] * grid_x
    y = np.arange(rows, dtype=np.float32)[:, None] * grid_y
    step_x, step_y = field[..., 0], field[..., 1]
    active = weight
    turn = slide_x = slide_y = 0.0
    for round_number in range(reweightings + 1):
        total = float(active.sum())
        if total <= 0:
            return 0.0, 0.0, 0.0
        slide_x, slide_y = (float((active * step).sum()) / total for step in (step_x, step_y))
        arm_x = x - float((active * x).sum()) / total
        arm_y = y - float((active * y).sum()) / total
        moved_x, moved_y = arm_x + (step_x - slide_x), arm_y + (step_y - slide_y)
        across = float((active * (arm_x * moved_y - arm_y * moved_x)).sum())
        along = float((active * (arm_x * moved_x + arm_y * moved_y)).sum())
        turn = float(np.arctan2(across, along))
        if round_number < reweightings:
            cosine, sine = np.float32(np.cos(turn)), np.float32(np.sin(turn))
            misfit = (moved_x - cosine * arm_x + sine * arm_y) ** 2
            misfit += (moved_y - sine * arm_x - cosine * arm_y) ** 2
            scale = float((weight * misfit).sum() / weight.sum())
            active = weight / (1 + misfit / max(scale, MISFIT_FLOOR))
    return turn, slide_x, slide_y


def radius_of_gyration(weight: Field) -> float:
    """Return the weighted rms distance from the weighted centre, in grid steps."""
    total = float(weight.sum())
    if total <= 0:
        return 0.0
    rows, columns = weight.shape
    x, y = np.arange(columns), np.arange(rows)
    by_column, by_row = weight.sum(axis=0) / total, weight.sum(axis=1) / total
    variance_x = float(by_column @ x**2 - (by_column @ x) ** 2)
    variance_y = float(by_row @ y**2 - (by_row @ y) ** 2)
    return float(np.sqrt(max(variance_x + variance_y, 0.0)))


GREEN = 1
"""The colour channel the flow reads. Lights of opposite sides cancel in a grey mean, and red and
blue lose detail in video: on 271 real turns forwards and backwards, pairs two frames apart, green
0.974 against red 0.972, blue 0.965, grey 0.963."""

GAIN = 2.0
"""Stretch of the residual before the flow; 1 and 4 measured within a clip or two of it."""

NEUTRAL = 128
"""Grey of an untouched pixel, mid-range so that brighter and darker imprints both fit."""

PATCH_PX, REWEIGHTINGS = 8, 2
"""Side of the patches that the flow matches, and rounds in which pixels off the rigid motion lose
their weight."""

MISFIT_FLOOR = 1e-6
"""Squared px; keeps a perfect fit from dividing by zero."""

LONGEST_SIDE = 320
"""Width of the GelSight Mini streams all constants were measured on, px."""

FIT_STRIDE = 2
"""The fit reads every second pixel of the flow, which is smooth over its 8 px patches."""

NOISE_SIGMA_PX = 2.0
"""Smoothing of the contrast; finer structure is mostly noise of the camera."""

TURN_SHARE = 0.5
"""Share of the slide a turn's path must exceed to count as the motion. A turn about an axis beside
the imprint also carries the imprint along; on simulated training objects 95 % of slides stay below
a share of 0.6 and 70 % of turns exceed 0.5."""

TOUCH_CONTRAST = 0.5
"""Grey levels over the whole image; on simulated training objects 95 % of untouched clips are below
0.49 and 95 % of touched ones above 0.6."""

GROWTH = 0.3
"""Share by which contrast must grow or fade to be a press or a release; 95 % of simulated still
clips stay below 0.06, three quarters of the presses and releases exceed 0.37."""

PRESS_PATH_SHARE = 8 / 320
"""Longest path of a press; the flow of a growing imprint feigns 6 px in a quarter of simulated
presses, and the median slide is 11 px."""

STILL_PATH_SHARE = 0.5 / 320
"""Longest path of a still object; three quarters of simulated still clips stay below 0.4 px, while
hand-held nominally still contacts reach 0.57 in the median."""
