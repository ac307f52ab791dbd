"""TactileTracking: trials of a tracked GelSight Mini, read from the folders its authors release.

Joe Huang's data set (huggingface.co/datasets/joehjhuang/TactileTracking, MIT): 12 objects, 7 trials
each, folders named avocado0, avocado1, ... with

    gelsight.avi              n frames, markerless, 320 x 240; gelsight.mp4 in older releases
    true_start_T_currs.npy    (n, 4, 4) poses of the sensor by motion capture, see `pose_pairs`
    contact_masks.npy         (n, rows, columns) contact, found in the images by its authors
    gradient_maps.npy         (n, rows, columns, 2), not needed; its length is checked where it is

There is no untouched frame and no background. Knows files, not which pairs of frames get a label.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.data.idle_from_masks import IdleGel, MaskedFrames, idle_from_masks
from geotlm_lm.data.pose_pairs import LabelledPair, Poses
from geotlm_lm.recordings.arrays import map_array
from geotlm_lm.recordings.read import read_clip

POSES, MASKS, GRADIENTS = "true_start_T_currs.npy", "contact_masks.npy", "gradient_maps.npy"
OLD_POSES = "true_transforms.npy"
VIDEOS = ("gelsight.avi", "gelsight.mp4")

VIEW_WIDTH_MM = 0.0634 * 320
"""Width of the view: NormalFlow's configs/gsmini.yaml gives 0.0634 mm per pixel of 320."""

SAMPLED_FRAMES = 8
"""Frames of each trial that the idle gel is estimated from."""

MOST_TRAVEL_M = 0.2
"""Farthest a sensor is moved in a trial; more is a pose in another unit than metres."""

RIGID_TOLERANCE = 1e-2
"""Largest error of a rotation matrix times its transpose; stored poses are float32 or better."""


@dataclass(frozen=True, eq=False)
class Trial:
    """One trial; everything but its frames is in memory.

    Args:
        folder: Where it lies.
        object_id: The folder's name without its number.
        video: The recording.
        poses: (n, 4, 4), see `pose_pairs`; metres.
        contact_px: Pixels in contact, (n,).
        centres_px: Middle of the largest contact, (n, 2), column and row.
        size_px: Rows and columns of a frame.
        background: The estimated idle gel, uint8, (rows, columns, 3).
    """

    folder: Path
    object_id: str
    video: Path
    poses: Poses
    contact_px: NDArray[np.int64]
    centres_px: NDArray[np.float64]
    size_px: tuple[int, int]
    background: Frames | None = None

    @property
    def mm_per_px(self) -> float:
        """Size of a pixel."""
        return VIEW_WIDTH_MM / self.size_px[1]

    def recording(self) -> Clip:
        """Return all frames, beside the estimated idle gel."""
        return replace(read_clip(self.video), background=self.background)


@dataclass(frozen=True, eq=False)
class TactileTracking:
    """The trials of one folder.

    Args:
        folder: That folder.
        trials: Usable trials, by name.
        left_out: Folder name -> the sentence that says why it cannot be used.
        gel: The idle gel all trials share.
    """

    folder: Path
    trials: tuple[Trial, ...]
    left_out: dict[str, str] = field(default_factory=dict)
    gel: IdleGel | None = None


def is_tactile_tracking(folder: Path) -> bool:
    """Tell whether `folder`, or a folder in it, holds trials."""
    return folder.is_dir() and bool(_trial_folders(folder))


def read_tactile_tracking(folder: str | Path) -> TactileTracking:
    """Read every trial in `folder`, or in the one folder inside it, and estimate the idle gel.

    A trial that lacks a file, or whose files disagree, is left out and named.

    Raises:
        UnreadableClip: If there is no trial, or none can be used.
    """
    folder = Path(folder)
    found, samples = [], []
    left_out: dict[str, str] = {}
    for path in _trial_folders(folder):
        try:
            trial, sampled = _read_trial(path)
            if found and trial.size_px != found[0].size_px:
                raise UnreadableClip(
                    f"{path}: frames are {_size(trial.size_px)} pixels, those of "
                    f"{found[0].folder.name} {_size(found[0].size_px)}; export all at one size."
                )
        except (UnreadableClip, OSError) as error:
            left_out[path.name] = str(error)
        else:
            found.append(trial)
            samples.append(sampled)
    if not found:
        why = next(iter(left_out.values()), "no folder in it holds poses")
        raise UnreadableClip(
            f"{folder}: found no trial that can be used, expected folders with {VIDEOS[0]}, "
            f"{POSES} and {MASKS}; the first reason: {why}"
        )
    gel = idle_from_masks(samples)
    trials = tuple(replace(trial, background=gel.of(k)) for k, trial in enumerate(found))
    return TactileTracking(folder, trials, left_out, gel)


def pair_clip(recording: Clip, trial: Trial, pair: LabelledPair) -> Clip:
    """Return a pair a, b as the clip a, a, b, b."""
    clip = recording.select([pair.first, pair.first, pair.last, pair.last])
    return replace(clip, name=f"{trial.folder.name}[{pair.first}:{pair.last}]")


def _trial_folders(folder: Path) -> list[Path]:
    if not folder.is_dir():
        return []
    inside = [path for path in sorted(folder.iterdir()) if path.is_dir()]
    own = [path for path in inside if _is_trial(path)]
    if own:
        return own
    return [trial for path in inside for trial in sorted(path.iterdir()) if _is_trial(trial)]


def _is_trial(path: Path) -> bool:
    return path.is_dir() and any((path / name).exists() for name in (POSES, OLD_POSES))


def _read_trial(folder: Path) -> tuple[Trial, MaskedFrames]:
    """Return a trial and the frames its idle gel is estimated from."""
    if not (folder / POSES).exists():
        raise UnreadableClip(
            f"{folder}: found {OLD_POSES}, whose convention is not published, expected {POSES}; "
            f"use the present release."
        )
    video = next((folder / name for name in VIDEOS if (folder / name).exists()), None)
    if video is None or not (folder / MASKS).exists():
        missing = VIDEOS[0] if video is None else MASKS
        raise UnreadableClip(f"{folder}: {missing} is missing; unpack the trial again.")
    poses = _read_poses(folder / POSES)
    masks = _frames_of(folder / MASKS)
    recording = read_clip(video)
    size = recording.frames.shape[1:3]
    _require_agreement(folder, recording, poses, masks)
    contact, centres = _contacts(masks)
    trial = Trial(folder, _object_of(folder.name), video, poses, contact, centres, size)
    chosen = np.unique(np.linspace(0, len(poses) - 1, SAMPLED_FRAMES).round().astype(int))
    sampled = MaskedFrames(recording.frames[chosen], np.asarray(masks[chosen]) > 0)
    return trial, sampled


def _frames_of(path: Path) -> NDArray:
    """Return an array of numbers, one entry per frame, without reading them yet."""
    array = map_array(path)
    if array.ndim == 0 or array.dtype.kind not in "biuf":
        raise UnreadableClip(
            f"{path}: found {array.dtype} of shape {array.shape}, expected numbers, one entry per "
            f"frame; copy it again."
        )
    return array


def _read_poses(path: Path) -> Poses:
    poses = np.asarray(map_array(path))
    if poses.ndim != 3 or poses.shape[1:] != (4, 4) or poses.dtype.kind != "f" or len(poses) < 2:
        raise UnreadableClip(
            f"{path}: found {poses.dtype} of shape {poses.shape}, expected floating-point poses "
            f"(frames, 4, 4) of 2 frames or more; copy it again."
        )
    poses = poses.astype(np.float64)
    if not np.isfinite(poses).all():
        raise UnreadableClip(f"{path}: holds NaN or infinite poses; copy it again.")
    turns = poses[:, :3, :3]
    skew = np.abs(turns @ turns.transpose(0, 2, 1) - np.eye(3)).max()
    last_rows = np.abs(poses[:, 3] - (0, 0, 0, 1)).max()
    if max(skew, last_rows) > RIGID_TOLERANCE or np.linalg.det(turns).min() < 0:
        raise UnreadableClip(
            f"{path}: a pose is off a rigid motion by {max(skew, last_rows):.2g}, expected "
            f"rotation matrices and a last row 0, 0, 0, 1; copy it again."
        )
    farthest = np.abs(poses[:, :3, 3]).max()
    if farthest > MOST_TRAVEL_M:
        raise UnreadableClip(
            f"{path}: the sensor travels {farthest:g} m, expected at most {MOST_TRAVEL_M:g}; "
            f"give translations in metres."
        )
    return poses


def _require_agreement(folder: Path, recording: Clip, poses: Poses, masks: NDArray) -> None:
    """Refuse a trial whose files are not of the same frames."""
    lengths = {"the video": len(recording), "poses": len(poses), "masks": len(masks)}
    if (folder / GRADIENTS).exists():
        lengths["gradient maps"] = len(_frames_of(folder / GRADIENTS))
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{count} of {name}" for name, count in lengths.items())
        raise UnreadableClip(f"{folder}: found {told}, expected equally many; copy it again.")
    size = recording.frames.shape[1:3]
    if masks.shape[1:] != size:
        raise UnreadableClip(
            f"{folder}: masks have the shape {masks.shape[1:]}, the video's frames {size}; "
            f"expected one size; copy it again."
        )


def _contacts(masks: NDArray) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return pixels in contact and the middle of the largest contact, frame by frame."""
    areas, centres = np.zeros(len(masks), np.int64), np.zeros((len(masks), 2))
    for frame, mask in enumerate(masks):
        touched = (np.asarray(mask) > 0).astype(np.uint8)
        areas[frame] = int(touched.sum())
        # As the authors do: the middle of the largest contour, holes in it filled.
        contours, _ = cv2.findContours(touched, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        moments = cv2.moments(max(contours, key=cv2.contourArea)) if contours else {"m00": 0.0}
        if moments["m00"] > 0:
            centres[frame] = moments["m10"] / moments["m00"], moments["m01"] / moments["m00"]
    return areas, centres


def _object_of(name: str) -> str:
    return re.sub(r"\d+$", "", name) or name


def _size(size_px: tuple[int, int]) -> str:
    return f"{size_px[1]} x {size_px[0]}"
