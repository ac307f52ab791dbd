"""What is wrong with a recording: every frame is looked at once, then those that were kept."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.clip import Clip, Frames
from geotlm_lm.recordings.idle import FAINT_IMPRINT, find_idle, imprint_strength
from geotlm_lm.recordings.images import TURN_NOTES, TURNS
from geotlm_lm.recordings.legible import DARK_GREY, DIM_GREY, GREEN, WHITE_GREY, noise_grey
from geotlm_lm.recordings.pixels import SQUASHED
from geotlm_lm.recordings.policy import EVEN_STEP, FEWEST_EVEN, ROUNDED_S, FrameClock
from geotlm_lm.recordings.scene_checks import SceneChecker, SceneReport, without_blank
from geotlm_lm.recordings.touch import COLUMNS
from geotlm_lm.recordings.video import VIDEO_SUFFIXES, declared_end
from geotlm_lm.track.exposure import exposure_step, small_colours

Floats = NDArray[np.float32]

Verdict = Literal["fine", "limit", "fault", "unknown"]
"""Nothing to do; nothing to do, but answers are less good; to repair; cannot be known."""

MOST_FRAMES = 6000
"""Frames of a recording that are looked at one by one: four minutes at 25 a second."""

MISSED_STEP = 1.5
"""Steps in usual ones from which on frames are missing between two."""

MOST_MISSED = 0.01
"""Share of frames that may be missing: single ones are dropped by any camera."""

MOST_REPEATED = 0.01
"""Share of frames that may equal the one before in every pixel. On 65 real recordings that
thresholds are chosen by none does, MPEG-4 ones among them: noise alone tells two frames apart."""

MOST_DRIFT_GREY = 6.0
"""Lasting change of the whole picture's level: 65 real recordings that thresholds are chosen by
stay below 1.8, contact and all. From 12 on a clip is refused."""

MOST_BALANCE_GREY = 5.0
"""Lasting change of a colour against the others: the same recordings stay below 2.1, one more that
was looked at has 3.0."""

MOST_CLIPPED = 0.02
"""Share of pixels at an end of the scale; below 0.001 on real recordings, at most 0.01 on
simulated ones."""

MOST_NOISE_GREY = 4.0
"""Noise from which on it costs answers: real recordings have 1.2 at most, simulated ones 2.5."""

SAMPLED = 9
"""Frames that are looked at pixel by pixel."""

RED_OVER_BLUE = (0.95, 1.1)
"""Mean red over mean blue of an idle gel: below it colours are in order, above it they are swapped.
65 real recordings of GelSight Minis that thresholds are chosen by have 0.5 to 0.7, the calibration
pictures of two more 0.75, simulated gels 0.58 to 0.88."""

GREY_LEVELS = 1.0
"""Mean difference of colours below which a recording is grey."""

MARKED_WIDTH = 320
"""Columns of the picture that markers are looked for in."""

MARKER_PX, MARKER_DARKNESS, FEWEST_MARKERS = (4.0, 20.0), 0.2, 20
"""Least and greatest width of a dot there, share of the light that it swallows, dots of a grid."""

MOST_UNEVEN = 0.35
"""Spread of the distances of dots to their neighbours, relative to the usual one: a grid's."""

WIDEST = 2.0
"""Width over height, or the other way, beyond which no camera's picture has square pixels."""


@dataclass(frozen=True)
class Finding:
    """What is known about one side of a recording, such as its frame rate, in words."""

    subject: str
    verdict: Verdict
    measured: str
    means: str = ""  # for the answers; "" where all is fine
    advice: str = ""  # which option or fact to set, or what to change; "" likewise

    def to_dict(self) -> dict[str, Any]:
        """Return it for JSON."""
        return asdict(self)

    def lines(self) -> list[str]:
        """Return it as one line, and one each for what it means and what to do."""
        head = f"{self.verdict:<8}{self.subject}: {self.measured}"
        return [head, *(f"{'':<8}{text}" for text in (self.means, self.advice) if text)]


def judged(subject: str, measured: str, means: str, advice: str, *, is_fault: bool) -> Finding:
    """Return a finding that is a fault, with what it means, or fine, without."""
    if is_fault:
        return Finding(subject, "fault", measured, means, advice)
    return Finding(subject, "fine", measured)


def examine(clip: Clip, frames: Iterable[tuple[int, Frames]] | None = None) -> list[Finding]:
    """Return every finding, in the order in which they are shown.

    Frames are those of the recording, as `each_frame` yields them; None for those of the clip.
    """
    smalls, repeats, numbers, before = [], [], [], None
    scene = SceneChecker()
    every = frames or zip(clip.frame_numbers, clip.frames, strict=True)
    for number, frame in every:
        if len(numbers) == MOST_FRAMES:
            break
        numbers.append(number)
        smalls.append(small_colours(frame))
        scene.steadied(frame, number)
        if before is not None:
            repeats.append(np.array_equal(frame, before))
        before = frame
    is_every = numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    idle_finding, idle = idle_gel(clip)
    chosen = np.unique(np.linspace(0, len(clip) - 1, SAMPLED).round().astype(int))
    few = clip.frames[chosen]
    gel = np.median(few, axis=0).astype(np.uint8) if idle is None else idle
    return [
        frame_rate(clip),
        missing_frames(clip),
        *file_end(clip),
        repeated_frames(np.array(repeats, bool), is_every=is_every),
        size(clip),
        pixel_shape(clip),
        mount(clip),
        colours(gel),
        *drifts(smalls),
        *pixels(few),
        *picture(scene.report),
        idle_finding,
        contrast(clip, idle),
        markers(gel),
    ]


def frame_rate(clip: Clip) -> Finding:
    """Judge how evenly frames come."""
    if not clip.times_s and clip.fps is not None:
        even = f"even to {1e3 * ROUNDED_S:g} ms as far as the file tells"
        return Finding("frame rate", "fine", f"{clip.fps:.4g} frames per second, {even}.")
    if not clip.times_s:
        return Finding(
            "frame rate",
            "unknown",
            "neither times nor a rate are told.",
            "Events are told by frame numbers, and no speed is.",
            "Give the camera's rate by --fps.",
        )
    steps, usual = _steps(clip)
    even = np.abs(steps - usual) <= EVEN_STEP * usual
    low, high = np.quantile(steps, (0.05, 0.95))
    is_uneven = even.mean() < FEWEST_EVEN
    return judged(
        "frame rate",
        f"{1 / usual:.1f} frames per second; nine in ten steps are {1e3 * low:.1f} to "
        f"{1e3 * high:.1f} ms (jitter {500 * (high - low):.1f} ms).",
        "Times and speeds are told by the frames' own times, and no rate holds for all: what "
        "happens within a long step is not seen.",
        "Lock the camera's exposure, which sets its rate, and record without writing to a slow "
        "disk; do not give --fps, which would take the frames for even.",
        is_fault=bool(is_uneven),
    )


def missing_frames(clip: Clip) -> Finding:
    """Judge whether frames were dropped, by the gaps between times, or between their numbers."""
    subject, notes = "dropped frames", []
    if clip.times_s:
        steps, usual = _steps(clip)
        clock = FrameClock()
        for number, time_s in enumerate(clip.times_s):
            clock.time_of(time_s, number)
        notes = clock.notes()
    else:
        steps = np.diff(clip.frame_numbers)
        usual = float(steps.min())
        if usual == steps.max() and clip.fps is None:
            return Finding(subject, "unknown", "cannot be told without the frames' times.")
        if usual == steps.max():
            return Finding(subject, "fine", "none, by the frames' times.")
    missed = int((np.rint(steps / usual) - 1)[steps > MISSED_STEP * usual].sum())
    count = len(steps) + 1 + missed
    share = missed / count
    return judged(
        subject,
        " ".join([f"{missed} of {count} ({share:.1%}).", *notes]),
        "An object goes farther between two frames than it seems: a turn of more than 45 degrees "
        "in one step is not followed, and slips in a gap are not seen.",
        "Record at a lower rate or size, to a faster disk, or with a larger queue of the recorder.",
        is_fault=share > MOST_MISSED,
    )


def file_end(clip: Clip) -> list[Finding]:
    """Judge whether a video's file is there to its end; nothing of other recordings."""
    path = Path(clip.name)
    end = declared_end(path) if path.suffix.lower() in VIDEO_SUFFIXES and path.is_file() else None
    if end is None:
        return []
    note = end.note()
    measured = note or f"all {end.present_bytes} bytes that the file declares are there."
    means = "Whatever moves later is not part of any answer, nor of the totals of a track."
    advice = "Wait until it is written, copy it again, or take the totals for a part's."
    return [judged("end of the file", measured, means, advice, is_fault=note is not None)]


def repeated_frames(is_repeat: NDArray[np.bool_], *, is_every: bool) -> Finding:
    """Judge whether frames equal the one before; unknown unless these are neighbours."""
    subject = "repeated frames"
    if not is_every or not len(is_repeat):
        measured = "cannot be told: the recording was read at a stride."
        return Finding(subject, "unknown", measured, advice="Give a shorter part of it.")
    share = float(is_repeat.mean())
    return judged(
        subject,
        f"{int(is_repeat.sum())} of {len(is_repeat) + 1} equal the one before ({share:.1%}).",
        "A repeated frame seems held still and the next one twice as fast: rests and slips are "
        "told that were none.",
        "Record at the camera's own rate, which is below the recorder's, or leave repeats out.",
        is_fault=share > MOST_REPEATED,
    )


def _steps(clip: Clip) -> tuple[NDArray[np.float64], float]:
    steps = np.diff(np.asarray(clip.times_s))
    return steps, float(np.median(steps))


def size(clip: Clip) -> Finding:
    """Judge how many pixels there are."""
    rows, columns = clip.frames.shape[1:3]
    return judged(
        "size",
        f"{columns} x {rows} pixels.",
        f"Contact is measured at {COLUMNS} columns: fine imprints are lost in fewer.",
        "Export the recording at the camera's own size.",
        is_fault=max(rows, columns) < COLUMNS,
    )


def pixel_shape(clip: Clip) -> Finding:
    """Judge whether pixels are as wide as high, which a picture's size tells in part only."""
    rows, columns = clip.frames.shape[1:3]
    subject, measured = "pixel shape", f"{columns} x {rows}, {columns / rows:.2f} wide for 1 high"
    if SQUASHED in clip.notes:
        return Finding(
            subject,
            "unknown",
            f"{measured}: taken for a 4:3 picture squashed to a square.",
            "Where that is wrong, lengths across are told a third too long, and turns are skewed.",
            "Give --square-pixels if the camera's picture is square, else --no-square-pixels.",
        )
    return judged(
        subject,
        f"{measured}.",
        "The picture seems stretched, as of one field of two or of a squashed export: turns are "
        "skewed, and lengths differ across and down.",
        "Export it at the camera's own shape, mostly 4:3.",
        is_fault=max(rows, columns) > WIDEST * min(rows, columns),
    )


def mount(clip: Clip) -> Finding:
    """Judge how the picture is turned: as its file states, else by its shape, a quarter only."""
    rows, columns = clip.frames.shape[1:3]
    stated = next((turn for turn, note in TURN_NOTES.items() if note in clip.notes), None)
    if stated is not None:
        return Finding(
            "mount",
            "limit",
            f"the file states pictures {TURNS[stated]}, and so they were.",
            "Directions are told as the turned picture shows them.",
            "Slide something to the right and ask; if the answer is another, record without it.",
        )
    if rows > columns:
        return Finding(
            "mount",
            "fault",
            f"the picture is {columns} wide and {rows} high; cameras take them wide.",
            "It was turned by a quarter, which way cannot be told: left and right are told as up "
            "and down of an upright one.",
            'State it in a conversation: "the image is rotated by 90 degrees clockwise", or '
            "counterclockwise.",
        )
    return Finding(
        "mount",
        "unknown",
        "a mirror or a half turn cannot be told from frames.",
        "Directions are told as the image shows them.",
        "Slide something to the right and ask; if the answer is another, state it in a "
        'conversation: "the image is mirrored", or "the camera is mounted upside down".',
    )


def drifts(smalls: Sequence[Floats]) -> list[Finding]:
    """Judge exposure and white balance by every frame, as `small_colours` returns it."""
    first = np.median(smalls[:3], axis=0)
    level = np.maximum(np.median(first.reshape(-1, 3), axis=0), 1.0)
    shifts = np.stack([np.median((small - first).reshape(-1, 3), axis=0) for small in smalls])
    # What one frame in fifty is beyond: a large object passes by, a drift stays.
    drift = float(np.quantile(np.abs(shifts.mean(axis=1)), 0.98))
    # One gain for all colours or one offset is exposure; what neither explains is balance.
    gain = shifts @ level / (level @ level)
    by_gain = np.ptp(shifts - gain[:, None] * level, axis=1)
    balance = float(np.quantile(np.minimum(by_gain, np.ptp(shifts, axis=1)), 0.98))
    jumps = sum(exposure_step(*pair) is not None for pair in pairwise(smalls))
    steps = f", {jumps} times from one frame to the next" if jumps else ""
    return [
        judged(
            "exposure",
            f"the whole picture's level changes by {drift:.1f} grey levels at most{steps}.",
            "Every change of the light looks like a change of the gel: contact is told where none "
            "is, and beyond 12 grey levels within a clip it is refused.",
            "Switch the camera's automatic exposure off and lock its gain.",
            is_fault=drift > MOST_DRIFT_GREY,
        ),
        judged(
            "white balance",
            f"a colour changes against the others by {balance:.1f} grey levels at most.",
            "The gel's colours tell its slopes: imprints seem to change where only colours did.",
            "Switch the camera's automatic white balance off.",
            is_fault=balance > MOST_BALANCE_GREY,
        ),
    ]


def pixels(frames: Frames) -> list[Finding]:
    """Judge brightness, clipping and noise."""
    brightest = frames[:, ::2, ::2].max(axis=-1)
    white = float((brightest == WHITE_GREY).mean())
    black = float((brightest <= DARK_GREY).mean())
    middle = float(np.median(brightest))
    noise = noise_grey(frames[:, ::4, :, GREEN])
    return [
        judged(
            "brightness",
            f"the middle level is {middle:.0f} of 255.",
            "An imprint changes a dim picture by few grey levels, and noise hides it.",
            "Lengthen the camera's exposure, or turn the sensor's lights up.",
            is_fault=middle < 2 * DIM_GREY,
        ),
        judged(
            "clipping",
            f"{white:.1%} of the pixels are at the upper end of the scale, {black:.1%} black.",
            "Where a pixel is at its end nothing that touches changes it.",
            "Shorten the camera's exposure, or crop black borders away.",
            is_fault=max(white, black) > MOST_CLIPPED,
        ),
        judged(
            "noise",
            f"{noise:.1f} grey levels.",
            "Fine imprints drown in it; beyond 9 grey levels a clip is refused.",
            "Lower the camera's gain, or average several frames into each.",
            is_fault=noise > MOST_NOISE_GREY,
        ),
    ]


def picture(scene: SceneReport) -> list[Finding]:
    """Judge whether the pictures are a gel's, and whether the camera keeps its place before it."""
    return [
        judged(
            "gel",
            scene.suspicion or "the pictures look like a gel's.",
            "No question about a motion is answered, and no event is more probable than 0.5.",
            "Choose the sensor's own camera, and one view of it; cut other views away.",
            is_fault=bool(scene.suspicion),
        ),
        judged(
            "camera",
            "the lights and the rim keep their place."
            if scene.suspicion or not scene.jumps
            else " ".join(scene.notes),
            "Such a jump is taken out of every motion; smaller ones are told as the object's.",
            "Fasten the camera to the gel, and the cable to the sensor.",
            is_fault=bool(scene.jumps) and not scene.suspicion,
        ),
    ]


def idle_gel(clip: Clip) -> tuple[Finding, Frames | None]:
    """Judge whether the untouched gel is known; return it, None where it is not."""
    subject = "idle gel"
    if clip.background is not None:
        return Finding(subject, "fine", "given beside the frames."), clip.background
    idle = find_idle(without_blank(clip))
    if idle is not None:
        return Finding(subject, "fine", "the recording starts, ends or rests untouched."), idle
    return (
        Finding(
            subject,
            "fault",
            "no untouched part was found in the recording.",
            "The gel is guessed from its shading: contact is not judged where nothing moves, and "
            "fine imprints are told less surely.",
            "Give a picture of it by --background, or start half a second before the touch.",
        ),
        None,
    )


def contrast(clip: Clip, idle: Frames | None) -> Finding:
    """Judge how strongly the gel is imprinted at most."""
    if idle is None:
        return Finding("contrast", "unknown", "cannot be told without the idle gel.")
    strongest = float(imprint_strength(replace(clip, background=idle)).max())
    return judged(
        "contrast",
        f"the strongest imprint changes the picture by {strongest:.2f} grey levels (rms).",
        f"An imprint below {FAINT_IMPRINT} cannot be told from an untouched gel.",
        "Press harder, or look whether the recording shows the touch at all.",
        is_fault=strongest < FAINT_IMPRINT,
    )


def colours(idle: Frames) -> Finding:
    """Judge the order of colours by the tint of the gel, or of the median of the frames."""
    red, green, blue = idle.reshape(-1, 3).mean(axis=0)
    subject, measured = "colour order", f"mean red {red:.0f}, green {green:.0f}, blue {blue:.0f}"
    ratio = red / max(blue, 1.0)
    if np.ptp(idle.astype(np.int16), axis=-1).mean() < GREY_LEVELS:
        means = "A grey picture tells less of the gel's slopes than a coloured one."
        return Finding(subject, "unknown", f"{measured}: the recording is grey.", means)
    if ratio > RED_OVER_BLUE[1]:
        return Finding(
            subject,
            "fault",
            f"{measured}: a GelSight Mini's gel has more blue than red.",
            "Blue seems to be first, as OpenCV has it: slopes are read from the wrong lights.",
            "Of an array say --layout BGR; convert anything else by cv2.cvtColor.",
        )
    if ratio < RED_OVER_BLUE[0]:
        return Finding(subject, "fine", f"{measured}, as on a GelSight Mini.")
    means = "Red and blue are too alike to tell their order by the gel's tint."
    return Finding(subject, "unknown", f"{measured}.", means)


def markers(idle: Frames) -> Finding:
    """Judge whether dots are printed on the gel, or on the median of the frames."""
    dots = marker_dots(idle)
    if not len(dots):
        return Finding("markers", "fine", "none seen.")
    spacing = np.median(_nearest(dots)) * idle.shape[1] / MARKED_WIDTH
    return Finding(
        "markers",
        "limit",
        f"{len(dots)} dots, {spacing:.0f} pixels apart.",
        "Turns are named as on a plain gel, slides less often, and amounts are told up to twice as "
        "far as the markers went.",
        "Nothing to set; look at the spread that is told beside an amount.",
    )


def marker_dots(idle: Frames) -> NDArray[np.float64]:
    """Return where dots lie, (n, 2) as (x, y) in a picture `MARKED_WIDTH` wide; (0, 2) of none."""
    rows = max(round(MARKED_WIDTH * 0.75), 1)  # a camera's picture, also where it was squashed
    grey = cv2.cvtColor(cv2.resize(idle, (MARKED_WIDTH, rows)), cv2.COLOR_RGB2GRAY)
    around = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (25, 25))
    bright = cv2.morphologyEx(grey, cv2.MORPH_CLOSE, around).astype(np.float32)
    dark = ((bright - grey) > MARKER_DARKNESS * np.maximum(bright, 1)).astype(np.uint8)
    _, _, about, centres = cv2.connectedComponentsWithStats(dark)
    width, height = about[:, cv2.CC_STAT_WIDTH], about[:, cv2.CC_STAT_HEIGHT]
    low, high = MARKER_PX
    is_dot = (np.minimum(width, height) >= low) & (np.maximum(width, height) <= high)
    is_dot &= np.maximum(width, height) < 2 * np.minimum(width, height)
    is_dot[0] = False  # what is around them
    dots = centres[is_dot]
    if len(dots) < FEWEST_MARKERS:
        return np.empty((0, 2))
    apart = _nearest(dots)
    return dots if apart.std() <= MOST_UNEVEN * np.median(apart) else np.empty((0, 2))


def _nearest(dots: NDArray[np.float64]) -> NDArray[np.float64]:
    apart = np.hypot(*(dots[:, None] - dots[None]).transpose(2, 0, 1))
    np.fill_diagonal(apart, np.inf)
    return apart.min(axis=1)
