"""TactileTracking: trials of a tracked GelSight Mini, and the pairs of frames that get a label.

Joe Huang's data set (huggingface.co/datasets/joehjhuang/TactileTracking, MIT): 12 objects, 7 trials
each, folders named avocado0, avocado1, ... with

    gelsight.avi              n frames, markerless, 320 x 240; gelsight.mp4 in older releases
    true_start_T_currs.npy    (n, 4, 4) poses of the sensor by motion capture
    contact_masks.npy         (n, rows, columns) contact, found in the images by its authors
    gradient_maps.npy         (n, rows, columns, 2), not needed; its length is checked where it is

A pose T_i is start_T_curr: it takes coordinates in the sensor's frame at frame i to its frame at
the start, in metres; the sensor's frame has its origin at the image's middle on the gel, x right,
y down, z into the object. The labels of a pair name the motion of the OBJECT in the image, which is
the sensor's own motion the other way round.

No frame shows the untouched gel, but contact masks say where it is untouched: each pixel's median
over such frames, of all trials, is the idle gel.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion, signed_amount
from geotlm_lm.recordings.arrays import map_array
from geotlm_lm.recordings.idle import estimate_background
from geotlm_lm.recordings.read import read_clip

Poses = NDArray[np.float64]

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

MARGIN_SHARE = 0.04
"""Margin around a contact that does not count as untouched, relative to the image's width: the gel
bends beside what touches it, and NormalFlow's masks are eroded."""

ROWS_AT_ONCE = 16
"""Rows of the image that are worked on together: bounds memory with thousands of frames."""


@dataclass(frozen=True, eq=False)
class Trial:
    """One trial; everything but its frames is in memory."""

    folder: Path
    object_id: str  # the folder's name without its number
    video: Path
    poses: Poses  # shape (n, 4, 4), metres
    contact_px: NDArray[np.int64]  # pixels in contact, shape (n,)
    centres_px: NDArray[np.float64]  # column and row of the largest contact's middle, (n, 2)
    size_px: tuple[int, int]  # rows and columns of a frame
    background: Frames | None = None  # the estimated idle gel, uint8, shape (rows, columns, 3)

    @property
    def mm_per_px(self) -> float:
        """Size of a pixel."""
        return VIEW_WIDTH_MM / self.size_px[1]

    def recording(self) -> Clip:
        """Return all frames, beside the estimated idle gel."""
        return replace(read_clip(self.video), background=self.background)


@dataclass(frozen=True, eq=False)
class TactileTracking:
    """The usable trials of one folder by name, and why others are not."""

    folder: Path
    trials: tuple[Trial, ...]
    left_out: dict[str, str] = field(default_factory=dict)  # folder name -> why


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
    trials, samples = [], []
    left_out: dict[str, str] = {}
    for path in _trial_folders(folder):
        try:
            trial, sampled = _read_trial(path)
            if trials and trial.size_px != trials[0].size_px:
                raise UnreadableClip(
                    f"{path}: frames are {_size(trial.size_px)} pixels, those of "
                    f"{trials[0].folder.name} {_size(trials[0].size_px)}; export all at one size."
                )
        except (UnreadableClip, OSError) as error:
            left_out[path.name] = str(error)
        else:
            trials.append(trial)
            samples.append(sampled)
    if not trials:
        why = next(iter(left_out.values()), "no folder in it holds poses")
        raise UnreadableClip(
            f"{folder}: found no trial that can be used, expected folders with {VIDEOS[0]}, "
            f"{POSES} and {MASKS}; the first reason: {why}"
        )
    with_idle = zip(trials, idle_gels(samples), strict=True)
    usable = tuple(replace(trial, background=idle) for trial, idle in with_idle)
    return TactileTracking(folder, usable, left_out)


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


def _read_trial(folder: Path) -> tuple[Trial, UntouchedFrames]:
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
    object_id = re.sub(r"\d+$", "", folder.name) or folder.name
    trial = Trial(folder, object_id, video, poses, contact, centres, size)
    chosen = np.unique(np.linspace(0, len(poses) - 1, SAMPLED_FRAMES).round().astype(int))
    return trial, (recording.frames[chosen], _untouched(np.asarray(masks[chosen]) > 0))


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
        counts = ", ".join(f"{count} of {name}" for name, count in lengths.items())
        raise UnreadableClip(f"{folder}: found {counts}, expected equally many; copy it again.")
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


def _size(size_px: tuple[int, int]) -> str:
    return f"{size_px[1]} x {size_px[0]}"


@dataclass(frozen=True)
class PairRule:
    """Which pairs of frames get a label; the thresholds are ours, the paper names none."""

    gap_frames: int = 10  # from the first of a pair to the second
    least_turn_deg: float = 5.0  # turn from which a pair is a rotation
    most_aside_px: float = 10.0  # travel of the contact that a rotation may have beside it
    least_slide_px: float = 10.0  # travel of the contact from which a pair is a slide
    most_aside_deg: float = 5.0  # turn that a slide may have beside it
    least_purity: float = 0.92  # share of a slide's travel along its axis; this is 23 degrees off
    most_tilt_deg: float = 5.0  # turn out of the image plane above which a pair is left out
    most_lift_mm: float = 0.5  # travel along the gel's normal above which it is
    least_contact_px: int = 500  # contact below which it is; NormalFlow's own least


GAPS_FRAMES = (5, 10, 15, 20, 25)
LEAST_TURNS_DEG = (2.0, 3.0, 5.0, 8.0, 12.0)
LEAST_SLIDES_PX = (4.0, 6.0, 10.0, 15.0, 20.0)
"""Thresholds swept: up to a second at 25 frames a second, from what a dense flow just resolves to a
third of a large contact."""

PAPER_TRIALS = 84
PAPER_PAIRS = {"rotation": 4088, "sliding": 6400}
"""Pairs the paper drew from the whole data set, all that it says of how it chose them."""


@dataclass(frozen=True)
class ImageMotion:
    """How the object moves in the image from one frame of each pair to the other, (pairs,) each."""

    turn_deg: NDArray[np.float64]  # in the image plane, positive clockwise as drawn
    slide_px: NDArray[np.float64]  # travel of the contact's centre, (pairs, 2), right and down
    tilt_deg: NDArray[np.float64]  # turn out of the image plane
    lift_mm: NDArray[np.float64]  # travel of the contact's centre along z


@dataclass(frozen=True)
class LabelledPair:
    """Numbers of two frames of a trial, and what the object does between them.

    The label rests on the turn, positive clockwise, and the travel, right and down.
    """

    first: int
    last: int
    motion: Motion
    turn_deg: float
    slide_px: tuple[float, float]


def image_motion(
    trial: Trial, first: NDArray[np.integer], last: NDArray[np.integer]
) -> ImageMotion:
    """Return how the object moves in the image from frames `first` to frames `last`.

    The travel is that of the contact's centre: it is free of the lever arm by which a turn about
    another axis carries the image's middle.
    """
    before, after = trial.poses[first], trial.poses[last]
    seen = np.linalg.inv(after) @ before  # b_T_a: where a point of the object goes in the image
    middle = (np.array(trial.size_px[::-1]) - 1) / 2
    metres = trial.mm_per_px / 1e3
    point = np.zeros((len(first), 4))
    point[:, :2] = (trial.centres_px[first] - middle) * metres
    point[:, 3] = 1
    travel = np.einsum("nij,nj->ni", seen, point)[:, :3] - point[:, :3]
    turn, tilt = in_plane_turn(seen[:, :3, :3])
    return ImageMotion(turn, travel[:, :2] / metres, tilt, 1e3 * travel[:, 2])


def in_plane_turn(
    rotations: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the first of the extrinsic zxy angles, and the larger of the other two, in degrees.

    R = R_y(c) R_x(b) R_z(a), as NormalFlow reads a pose: its second row is
    (cos b sin a, cos b cos a, -sin b), and its last column's ends are sin c cos b and cos c cos b.

    Returns:
        a and max(|b|, |c|) of rotations (pairs, 3, 3), shape (pairs,) each; a > 0 takes x towards
        y, clockwise as drawn.
    """
    a = np.arctan2(rotations[:, 1, 0], rotations[:, 1, 1])
    b = np.arcsin(np.clip(-rotations[:, 1, 2], -1, 1))
    c = np.arctan2(rotations[:, 0, 2], rotations[:, 2, 2])
    return np.degrees(a), np.degrees(np.maximum(np.abs(b), np.abs(c)))


def labelled_pairs(trial: Trial, rule: PairRule, task: str) -> list[LabelledPair]:
    """Return every pair of a trial that `rule` takes for "rotation" or "sliding", by time."""
    first = np.arange(len(trial.poses) - rule.gap_frames)
    if len(first) == 0:
        return []
    last = first + rule.gap_frames
    moved = image_motion(trial, first, last)
    is_sound = (
        (np.minimum(trial.contact_px[first], trial.contact_px[last]) >= rule.least_contact_px)
        & (moved.tilt_deg <= rule.most_tilt_deg)
        & (np.abs(moved.lift_mm) <= rule.most_lift_mm)
    )
    turn, travel = np.abs(moved.turn_deg), np.hypot(*moved.slide_px.T)
    if task == "rotation":
        among = ROTATIONS
        is_task = (turn >= rule.least_turn_deg) & (travel <= rule.most_aside_px)
    else:
        among = SLIDES
        is_pure = np.abs(moved.slide_px).max(axis=1) >= rule.least_purity * travel
        is_task = (travel >= rule.least_slide_px) & (turn <= rule.most_aside_deg) & is_pure
    pairs = []
    for k in np.flatnonzero(is_sound & is_task):
        turn_deg, (right, down) = float(moved.turn_deg[k]), moved.slide_px[k].tolist()
        amounts = {
            motion: signed_amount(motion, turn=turn_deg, right=right, down=down) for motion in among
        }
        motion = max(among, key=amounts.__getitem__)
        pairs.append(LabelledPair(int(first[k]), int(last[k]), motion, turn_deg, (right, down)))
    return pairs


def sweep_pair_counts(trials: Sequence[Trial], rule: PairRule, task: str) -> list[dict[str, Any]]:
    """Count the pairs of every gap and threshold, the other thresholds as `rule` has them.

    Returns:
        One row per combination: gap_frames, the least turn or travel, pairs, and pairs per label.
    """
    rows = []
    for swept, threshold in _swept(rule, task):
        motions = [pair.motion for trial in trials for pair in labelled_pairs(trial, swept, task)]
        labels = {str(motion): motions.count(motion) for motion in Motion if motion in motions}
        row = {"gap_frames": swept.gap_frames, "least": threshold}
        rows.append(row | {"pairs": len(motions), "of": labels})
    return rows


def nearest_rule(
    rows: Sequence[dict[str, Any]], rule: PairRule, task: str, target: float
) -> PairRule:
    """Return the swept rule whose number of pairs comes nearest to `target`; the first of equals.

    Numbers of pairs alone decide; no method has seen a pair yet. A rule without any pair is taken
    only where no other has one.
    """
    rules = [swept for swept, _ in _swept(rule, task)]
    counts = [row["pairs"] for row in rows]
    best = min(range(len(rules)), key=lambda k: (counts[k] == 0, abs(counts[k] - target)))
    return rules[best]


def _swept(rule: PairRule, task: str) -> Iterator[tuple[PairRule, float]]:
    name, leasts = "least_slide_px", LEAST_SLIDES_PX
    if task == "rotation":
        name, leasts = "least_turn_deg", LEAST_TURNS_DEG
    for gap in GAPS_FRAMES:
        for least in leasts:
            yield replace(rule, gap_frames=gap, **{name: least}), least


def evenly_spaced(pairs: Sequence[LabelledPair], most: int) -> list[LabelledPair]:
    """Return at most `most` of `pairs`, evenly through the recording."""
    if len(pairs) <= most:
        return list(pairs)
    chosen = np.linspace(0, len(pairs) - 1, most).round().astype(int)
    return [pairs[int(index)] for index in chosen]


UntouchedFrames = tuple[Frames, NDArray[np.bool_]]
"""Some frames of one recording, uint8, shape (t, rows, columns, 3), and where each is untouched."""


def _untouched(touched: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return where the gel is surely untouched, shape (t, rows, columns), as the masks."""
    side = 2 * max(round(MARGIN_SHARE * touched.shape[2]), 1) + 1
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
    return np.stack([cv2.dilate(mask.astype(np.uint8), kernel) == 0 for mask in touched])


def idle_gels(recordings: Sequence[UntouchedFrames]) -> list[Frames]:
    """Return the idle gel that all recordings share in the light of each.

    Where every frame is touched, the gel is fitted to the shading.
    """
    gains = np.ones((len(recordings), 3), np.float32)
    for _ in range(2):  # the second median is free of differences of light
        image, count = _masked_median(recordings, gains)
        for index, (frames, free) in enumerate(recordings):
            gains[index] = _gain(frames, image, free & (count > 0))
    covered = count == 0
    if covered.any():
        everything = np.concatenate([frames for frames, _ in recordings])
        image[covered] = estimate_background(everything)[covered]
    return [np.clip(np.rint(image * gain), 0, 255).astype(np.uint8) for gain in gains]


def _masked_median(
    recordings: Sequence[UntouchedFrames], gains: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """Return each pixel's median where untouched, and in how many frames that is."""
    rows, columns = recordings[0][0].shape[1:3]
    image = np.zeros((rows, columns, 3), np.float32)
    count = np.sum([free.sum(axis=0) for _, free in recordings], axis=0)
    for top in range(0, rows, ROWS_AT_ONCE):
        band = slice(top, top + ROWS_AT_ONCE)
        values = np.concatenate(
            [
                np.where(free[:, band, :, None], frames[:, band] / gain, np.inf)
                for (frames, free), gain in zip(recordings, gains, strict=True)
            ]
        )
        values.sort(axis=0)  # what is touched sorts behind everything
        middle = np.maximum(count[band] - 1, 0) // 2
        median = np.take_along_axis(values, middle[None, :, :, None], axis=0)[0]
        image[band] = np.where(count[band][..., None] > 0, median, 0)
    return image, count


def _gain(
    frames: Frames, image: NDArray[np.float32], free: NDArray[np.bool_]
) -> NDArray[np.float32]:
    """Return each channel's light relative to `image` where the gel is untouched, shape (3,)."""
    own = np.array([frames[..., channel][free].sum(dtype=np.float64) for channel in range(3)])
    usual = np.array([(image[..., channel] * free).sum(dtype=np.float64) for channel in range(3)])
    known = (own > 0) & (usual > 0)
    return np.where(known, own / np.where(known, usual, 1), 1).astype(np.float32)
