"""What one simulated clip shows: object, gel, path of the object, camera and light; no randomness.

Lengths are millimetres in the gel frame: origin at the middle of the view, x right, y down, z into
the object. Rotation is positive clockwise as drawn in the image (x towards y). A number that is not
finite or outside its range is a ValueError.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.labels import Motion
from geotlm_lm.simulation.shapes import Indenter


def _require(name: str, value: float, low: float, high: float, unit: str = "") -> None:
    # A NaN fails every comparison, so that this refuses it too.
    if not low <= value <= high:
        raise ValueError(
            f"the {name} is {value:g}, expected {low:g} to {high:g}{unit and ' ' + unit}; a scene "
            f"with it cannot be simulated."
        )


@dataclass(frozen=True)
class Gel:
    """The elastic pad, bonded to its backing."""

    thickness_mm: float = 4.0  # at the centre of a GelSight Mini's (FEATS, arXiv 2411.03315)
    poisson_ratio: float = 0.48
    dome: float = 1.0  # height of the crown relative to GelSight Mini's; 0 is a flat pad
    # Coulomb's, between object and gel; 1.0 in FEATS and Taccel. The imprint hardly changes.
    friction: float = 1.0
    # Smoothing beside the object by the coat, standard deviation of a Gaussian; .3 to .45 fit the
    # flank of one measured ball press.
    membrane_mm: float = 0.0
    # Share of an indentation that is still there one frame after the object has left it: the gel's
    # creep, which lasts one to three frames.
    lag: float = 0.0

    def __post_init__(self) -> None:
        _require("gel thickness", self.thickness_mm, 0.01, 1e3, "mm")
        _require("Poisson ratio", self.poisson_ratio, 0.0, 0.5)
        _require("dome", self.dome, 0.0, 10.0)
        _require("friction coefficient", self.friction, 0.0, 1e9)
        _require("membrane's smoothing", self.membrane_mm, 0.0, 5.0, "mm")
        _require("lag", self.lag, 0.0, 0.99)


@dataclass(frozen=True)
class Body:
    """The rigid object that touches the gel."""

    name: str  # in `indenters.INDENTERS`, unless there is an `indenter`
    variant: int = 0  # seed of the shape's own features (cells, weave phase, engraving)
    size: float = 1.0  # relative to the nominal one
    tilt_x: float = 0.0  # slope along x, mm per mm
    tilt_y: float = 0.0
    texture_um: float = 0.0  # standard deviation
    texture_scale_mm: float = 0.5  # correlation length
    indenter: Indenter | None = None

    def __post_init__(self) -> None:
        _require("body's size", self.size, 1e-3, 1e3)
        for name in ("tilt_x", "tilt_y"):
            _require(f"body's {name}", getattr(self, name), -10.0, 10.0)
        _require("texture", self.texture_um, 0.0, 1e4, "um")
        _require("texture's scale", self.texture_scale_mm, 1e-3, 1e3, "mm")


_POSE = ("depth_mm", "x_mm", "y_mm", "rotation_rad")
"""Fields of a path that have one entry per frame."""


@dataclass(frozen=True)
class Path:
    """Pose of the object in every frame; all four tuples have one entry per frame."""

    depth_mm: tuple[float, ...]  # beyond first touch on the pad's crown; <= 0 is no contact
    x_mm: tuple[float, ...]  # the object's centre from the view's middle
    y_mm: tuple[float, ...]
    rotation_rad: tuple[float, ...]
    # Travel (right, down) and turn in touch that ended at the first frame: the gel is sheared
    # already. It shows in the gel's drift alone, and only friction carries it.
    pre_slide_mm: tuple[float, float] = (0.0, 0.0)
    pre_turn_rad: float = 0.0

    def __post_init__(self) -> None:
        lengths = {len(getattr(self, name)) for name in _POSE}
        if len(lengths) != 1 or 0 in lengths:
            raise ValueError(f"a path needs equally many poses of each kind, found {lengths}")
        for name in _POSE:
            for value in getattr(self, name):
                _require(f"path's {name}", value, -1e3, 1e3)
        for value in (*self.pre_slide_mm, self.pre_turn_rad):
            _require("path's history", value, -1e3, 1e3)

    def __len__(self) -> int:
        return len(self.depth_mm)

    @property
    def poses(self) -> list[tuple[float, float, float, float]]:
        """Depth in mm, x and y in mm, and rotation in radians of every frame."""
        return list(zip(*(getattr(self, name) for name in _POSE), strict=True))

    def change(self, last: int = -1) -> tuple[float, float, float, float]:
        """Return how far the object comes until frame `last`: inward, right, down, turn in rad."""
        poses = self.poses
        return tuple(now - before for before, now in zip(poses[0], poses[last], strict=True))

    def shortened(self, share: float) -> Path:
        """Return the path with all of its motion shortened to a share, about its middle."""
        poses = {}
        for name in _POSE:
            values = getattr(self, name)
            middle = (values[0] + values[-1]) / 2
            poses[name] = tuple(middle + share * (value - middle) for value in values)
        return replace(self, **poses)

    @property
    def start(self) -> Path:
        """The path of the first frame alone."""
        return replace(self, **{name: getattr(self, name)[:1] for name in _POSE})


@dataclass(frozen=True)
class Mounting:
    """How the pad lies under the camera: what its crown, lights and markers share.

    Paths, labels and truth are in the camera's frame already; turning the camera turns both.
    """

    turn_rad: float = 0.0  # of the pad in the image: the camera's, the other way
    x_mm: float = 0.0  # the pad's middle from the view's
    y_mm: float = 0.0

    def __post_init__(self) -> None:
        _require("mounting's turn", self.turn_rad, -7.0, 7.0, "rad")
        _require("mounting's x", self.x_mm, -100.0, 100.0, "mm")
        _require("mounting's y", self.y_mm, -100.0, 100.0, "mm")


CENTRED = Mounting()


Three = tuple[float, float, float]
"""R, G, B."""

_MEASURED_IDLE = (
    ((29, 41, 44, 32, 24), (48, 77, 86, 69, 39), (71, 123, 147, 111, 62))
    + ((67, 111, 135, 101, 59), (49, 77, 89, 72, 44)),
    ((85, 97, 103, 95, 75), (92, 105, 112, 104, 83), (92, 101, 112, 104, 85))
    + ((86, 96, 103, 98, 80), (76, 85, 90, 84, 69)),
    ((90, 113, 120, 106, 83), (104, 133, 141, 124, 95), (110, 143, 149, 131, 101))
    + ((77, 97, 109, 96, 75), (62, 80, 94, 79, 61)),
)


@dataclass(frozen=True)
class Lamps:
    """How a kind of sensor lights its gel; what is not given is measured on one GelSight Mini."""

    # Relative change of R, G, B per unit slope towards (right, down).
    rows: tuple[tuple[float, float], ...] = ((-0.12, -1.08), (0.49, 0.07), (-0.03, 0.56))
    # Grey levels of the untouched gel on 5x5 even points, by channel.
    idle: tuple[tuple[tuple[float, ...], ...], ...] = _MEASURED_IDLE
    depth_gain: Three = (0.066, 0.037, 0.083)  # relative brightening per mm of indentation
    # Usual direction of each light relative to the rows: three real Minis are lit from -97, 7 and
    # 81 degrees, the measured one from -96, 8 and 93.
    usual_turn_deg: Three = (0.0, -4.0, -7.0)
    # Spread of what all channels change by per unit slope, relative to their shading: it takes the
    # channels' correlation on contacts from below -0.9 to the real -0.8.
    common_light: float = 0.14
    # Darkening at slope 1, relative to the shading: real imprints are as bright as the idle gel on
    # the whole (0.3, -0.9 and -0.4 %).
    steep_darkening: tuple[float, float] = (0.0, 0.22)
    is_white: bool = False  # all channels are the same light

    @cached_property
    def levels(self) -> NDArray[np.float32]:
        """The untouched gel's grey levels, (3, 5, 5)."""
        return np.array(self.idle, np.float32)

    @cached_property
    def mean_grey(self) -> NDArray[np.float32]:
        """R, G, B of the untouched gel at the inner nine points: few contacts lie at the border."""
        return self.levels[:, 1:-1, 1:-1].mean(axis=(1, 2))

    def turned(self, quarters: int) -> Lamps:
        """Return the lamps turned clockwise by quarters, as a camera mounted otherwise sees them.

        The view is taken to be square.
        """
        rows = self.rows
        for _ in range(quarters % 4):
            rows = tuple((-down, right) for right, down in rows)
        idle = np.rot90(self.levels, -quarters, axes=(1, 2)).tolist()
        return replace(self, rows=rows, idle=tuple(tuple(map(tuple, plane)) for plane in idle))


GELSIGHT_MINI = Lamps()


@dataclass(frozen=True)
class Markers:
    """Dark dots in a square grid; those printed on the gel's surface go where the gel goes.

    Measured on five recordings of GelSight Minis with markers: 1.9 to 2.0 mm apart, and 2.8 on one
    of them; 0.6 to 0.8 mm wide; 0.56 to 0.62 dark.
    """

    spacing_mm: float = 1.95
    diameter_mm: float = 0.65  # where a dot is half as dark
    darkness: float = 0.6  # share of the light that the middle of a dot swallows
    x_mm: float = 0.0  # the grid from the pad's middle
    y_mm: float = 0.0
    jitter: float = 0.0  # farthest a dot lies off its place along each axis, share of the spacing
    missing: float = 0.0  # share of the dots that have come off
    unevenness: float = 0.0  # share of its ink that the palest dot lacks; the others lack less
    seed: int = 0  # of these three
    is_carried: bool = True  # False: printed on the lens or a cover, they stand still

    def __post_init__(self) -> None:
        _require("markers' jitter", self.jitter, 0.0, 0.5)
        _require("share of missing markers", self.missing, 0.0, 1.0)
        _require("markers' unevenness", self.unevenness, 0.0, 1.0)
        _require("markers' spacing", self.spacing_mm, 0.3, 100.0, "mm")
        _require("markers' diameter", self.diameter_mm, 0.01, 10.0, "mm")
        _require("markers' darkness", self.darkness, 0.0, 1.0)


@dataclass(frozen=True)
class Pattern:
    """Lines or blotches printed all over the gel's surface; they go where the gel goes."""

    form: Literal["mesh", "blotches"]
    pitch_mm: float  # from line to line; of blotches the correlation length
    share: float  # of a line's width in the pitch; of blotches, of the surface that is dark
    darkness: float = 0.5  # share of the light that the print swallows
    x_mm: float = 0.0  # the pattern from the pad's middle
    y_mm: float = 0.0
    seed: int = 0  # of the blotches
    is_carried: bool = True

    def __post_init__(self) -> None:
        _require("pattern's pitch", self.pitch_mm, 0.05, 100.0, "mm")
        _require("pattern's share", self.share, 0.0, 1.0)
        _require("pattern's darkness", self.darkness, 0.0, 1.0)


@dataclass(frozen=True)
class VideoCodec:
    """Noise of a lossy video (MPEG-4): it stands still until the next frame stored whole.

    Measured on 25 recordings of 320 x 240: the noise of predicted frames is a third of that
    between two stored whole, and both are blotches that the channels share.
    """

    # Standard deviations of R, G, B: of a frame stored whole, and what each predicted one adds.
    whole_grey: Three = (0.75, 0.64, 0.8)
    predicted_grey: Three = (0.27, 0.25, 0.27)
    frames_apart: int = 1  # frames of the video between two of the clip


@dataclass(frozen=True)
class Optics:
    """Camera, coloured lights and noise; three-tuples are R, G, B."""

    mm_per_px_x: float = 20.3 / 224  # a GelSight Mini's view
    mm_per_px_y: float = 15.2 / 224
    # Turn (clockwise) and strength of each light's shading relative to the measured ones, and its
    # relative growth from the middle to the right and to the lower border.
    light_turn_rad: Three = (0.0, 0.0, 0.0)
    light_gain: Three = (1.0, 1.0, 1.0)
    light_slope_x: Three = (0.0, 0.0, 0.0)
    light_slope_y: Three = (0.0, 0.0, 0.0)
    # Relative change of all channels per unit slope towards (right, down): stray white light.
    common_light: tuple[float, float] = (0.0, 0.0)
    steep_darkening: float = 0.0  # of all channels, relative, at slope 1
    saturation: float = 1.0  # beta in A g / sqrt(1 + beta^2 |g|^2), g the slope
    depth_gain: Three = GELSIGHT_MINI.depth_gain  # relative, per mm
    shadow: float = 0.0  # relative darkening behind steep flanks, per unit slope
    psf_mm: float = 0.05  # Gaussian blur of camera and membrane
    noise_grey: Three = (1.7, 1.24, 2.0)  # one frame's standard deviation
    drift_grey: float = 0.5  # standard deviation of the brightness from frame to frame
    light_change: Three = (0.0, 0.0, 0.0)  # from idle frame to clip, relative
    jpeg_quality: int | None = None
    video: VideoCodec | None = None  # noise in place of `noise_grey`
    idle: int = 0  # seed of the idle frame's field, specks and fixed pattern
    mounting: Mounting = CENTRED
    markers: Markers | Pattern | None = None
    lamps: Lamps = GELSIGHT_MINI

    @property
    def mm_per_px(self) -> tuple[float, float]:
        """Pixel size (x, y)."""
        return self.mm_per_px_x, self.mm_per_px_y


@dataclass(frozen=True)
class Scene:
    """One clip to simulate; the motion is what the path was drawn for, or what fits it best."""

    body: Body
    path: Path
    motion: Motion
    gel: Gel = Gel()
    optics: Optics = Optics()
    # How many times longer than the other's the path of the named turn or slide must be at the
    # contact for the name to be true of the clip.
    dominance: float = 1.0
    gel_name: str = "mini"  # of the kind in `gels.GELS`
