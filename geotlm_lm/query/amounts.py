"""Amounts in any unit: from what is believed to what is told, and from what is said back."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from statistics import NormalDist

from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.geometry import travel_scale
from geotlm_lm.core.tolerance import RELATIVE_TOLERANCE, TOLERANCES
from geotlm_lm.motion.belief import SPAN_DEVIATIONS, Belief
from geotlm_lm.query.types import WAY_ATOMS

OF_ATOM: dict[str, tuple[str, int]] = {
    "cw": ("turn", 1),
    "ccw": ("turn", -1),
    "right": ("x", 1),
    "left": ("x", -1),
    "down": ("y", 1),
    "up": ("y", -1),
    "in": ("inward", 1),
    "out": ("inward", -1),
    "turn": ("turn", 0),
    "slide": ("slide", 0),
    "press": ("inward", 0),
    "x": ("x", 0),
    "y": ("y", 0),
}
"""What an atom's amount is measured by, and the sign that counts as its way; 0 of either."""

BASES = {"turn": "deg", "x": "px", "y": "px", "slide": "px", "inward": "mm"}


LEAST_TIMED = 3
"""Different frames that a speed needs."""


@dataclass(frozen=True)
class Recording:
    """Facts about the file that the clip is of.

    Args:
        columns: Width of the recording's frames, pixels.
        rows: Their height.
        is_turned: Whether they are looked at turned by a quarter.
        rate_hz: Frames per second, as stated or as the file tells; None where neither does.
        frames: How many the file has, however many of them were read.
        duration_s: How long it is; None where they are taken evenly at that rate, or nothing tells.
        is_uneven: Whether its frames were taken at uneven times, which each tells.
        used: Numbers of the frames that the clip is of.
        step_s: Time from frame to frame, or 1 for numbers of frames in its place.
    """

    columns: int = 224
    rows: int = 224
    rate_hz: float | None = None
    frames: int = 4
    used: tuple[int, ...] = (0, 1, 2, 3)
    is_turned: bool = False
    step_s: float | None = None
    duration_s: float | None = None
    is_uneven: bool = False

    def at_rate(self, rate_hz: float | None, *, overrides: bool = True) -> Recording:
        """Return this at a stated rate; uneven times, and those of a track, stay what they are.

        Args:
            rate_hz: Stated; None for what the file tells.
            overrides: Whether it stands before what the file tells.
        """
        is_kept = self.is_uneven or not overrides
        if rate_hz is None or self.step_s is not None or (is_kept and self.rate_hz is not None):
            return self
        return replace(self, rate_hz=rate_hz, duration_s=None)

    @property
    def steps(self) -> int:
        """Frames from the first used to the last."""
        return self.used[-1] - self.used[0]

    @property
    def seconds(self) -> float | None:
        """How long what moves does so: from the first used frame to the last.

        Two frames alone give no time: they may be any two of a longer motion.
        """
        is_timed = bool(self.rate_hz) and len(set(self.used)) >= LEAST_TIMED
        return self.steps / self.rate_hz if is_timed else None


@dataclass(frozen=True)
class Measure:
    """An amount as it is told.

    Args:
        atom: What it is of, an atom of the query.
        mean: Its value, in `unit`.
        deviation: Of it.
        unit: One of `UNITS`, "deg/s" and so on of a mean speed.
        tolerance: Least error that still counts as right.
    """

    atom: str
    mean: float
    deviation: float
    unit: str
    tolerance: float
    decimals: int | None = None
    is_padded: bool = False  # all decimals are written
    is_signed: bool = False  # a difference, which may be below zero

    @property
    def value(self) -> float:
        """What is told: no finer than the tolerance, to a digit at least."""
        if self.decimals is not None:
            return round(self.mean, self.decimals)
        step = 10.0 ** math.floor(math.log10(max(self.tolerance, 1e-9)))
        value = round(self.mean / step) * step
        return float(f"{value if value else self.mean:.{2 if value else 1}g}")

    @property
    def span(self) -> tuple[float, float]:
        """The ends between which it lies nine times in ten, rounded outwards; holds the value."""
        far = SPAN_DEVIATIONS * self.deviation
        is_signed = self.is_signed or self.atom in WAY_ATOMS
        low = self.mean - far if is_signed else max(self.mean - far, 0.0)
        low, high = 0.0 - _two_digits_up(-low), _two_digits_up(self.mean + far)
        return min(low, self.value), max(high, self.value)

    @property
    def limit(self) -> float:
        """Its value as a detection limit: two digits, rounded up."""
        return _two_digits_up(self.mean)

    def is_near(self, other: Measure) -> bool:
        """Tell whether both tell the same, within the tolerance."""
        far = max(self.tolerance, other.tolerance)
        return self.unit == other.unit and abs(self.value - other.value) <= far

    def to_dict(self) -> dict[str, float | str]:
        """Return plain JSON values."""
        low, high = self.span
        return {"value": self.value, "unit": self.unit, "low": low, "high": high}

    @property
    def word(self) -> str:
        """The amount as a program reads it: "15 deg"."""
        return f"{self.figure} {self.unit}"

    @property
    def figure(self) -> str:
        """Its value without a power of ten."""
        return f"{self.value:.{self.decimals}f}" if self.is_padded else f"{self.value:.10g}"

    @property
    def probability(self) -> float:
        """That the value is right within the tolerance, or a fifth of the true amount."""
        size = abs(self.value)
        low = min(size - self.tolerance, size / (1 + RELATIVE_TOLERANCE))
        high = max(size + self.tolerance, size / (1 - RELATIVE_TOLERANCE))
        bell = NormalDist(math.copysign(1, self.value) * self.mean, max(self.deviation, 1e-9))
        return bell.cdf(high) - bell.cdf(low)


def _two_digits_up(value: float) -> float:
    """Return the least number of two digits that is not less."""
    if value == 0:
        return 0.0
    step = 10.0 ** (math.floor(math.log10(abs(value))) - 1)
    return float(f"{math.ceil(value / step - 1e-9) * step:.2g}")


def bell(belief: Belief, name: str) -> tuple[float, float]:
    """Return mean and deviation of what `OF_ATOM` names; lengths in px of the 224-pixel image."""
    mean = belief.mean
    if name == "slide":
        from_x, from_y = mean.right_px, mean.down_px
        length = mean.slide_px
        axis = (from_x / length, from_y / length) if length > 0 else (1.0, 0.0)
        spread = sum(
            axis[i] * axis[j] * float(belief.covariance[1 + i, 1 + j])
            for i in range(2)
            for j in range(2)
        )
        return length, math.sqrt(max(spread, 0.0))
    values = (mean.turn_deg, mean.right_px, mean.down_px, mean.inward_mm)
    place = ("turn", "x", "y", "inward").index(name)
    return values[place], math.sqrt(float(belief.covariance[place, place]))


def measure(
    atom: str,
    belief: Belief,
    frame: FrameSpec,
    recording: Recording,
    unit: str | None = None,
) -> Measure:
    """Return how far an atom goes.

    Args:
        atom: A key of `OF_ATOM`.
        belief: What is believed.
        frame: Tells the size of a pixel, if anybody does.
        recording: The file.
        unit: "deg", "px" or "mm"; None for the usual one.
    """
    name, sign = OF_ATOM[atom]
    mean, deviation = bell(belief, name)
    base = BASES[name]
    is_scaled = base == "px" and frame.mm_per_px is not None
    unit = unit or ("mm" if is_scaled else base)
    scale = _pixels(name, belief, frame, recording, unit) if base == "px" else 1.0
    mean = mean * sign if sign else abs(mean)
    return Measure(atom, mean * scale, deviation * scale, unit, TOLERANCES[base] * scale)


def _pixels(name: str, belief: Belief, frame: FrameSpec, recording: Recording, unit: str) -> float:
    """Return how many pixels of the recording, or mm, are a pixel of our square."""
    size = None if unit == "px" else frame.mm_per_px
    scale = travel_scale(recording.rows, recording.columns, size)[1]
    across, along = scale[::-1] if recording.is_turned else scale
    if name != "slide":
        return along if name == "y" else across
    length = belief.mean.slide_px
    if length == 0:
        return across
    return math.hypot(across * belief.mean.right_px, along * belief.mean.down_px) / length
