"""What one simulated clip shows: object, gel, path of the object, camera and light; no randomness.

Lengths are millimetres in the gel frame: origin at the middle of the view, x right, y down, z into
the object. Rotation is positive clockwise as drawn in the image (x towards y). A number that is not
finite or outside its range is a ValueError.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

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
    """The elastic pad, bonded to its backing.

    Args:
        thickness_mm: Thickness at the centre; 4.0 for GelSight Mini (FEATS, arXiv 2411.03315).
        poisson_ratio: Dimensionless, from 0 to 0.5.
        dome: Height of the pad's crown relative to GelSight Mini's; 0 is a flat pad.
        friction: Coulomb's coefficient between object and gel; 1.0 in FEATS and Taccel. It drags
            the gel's surface along; the imprint hardly changes.
        membrane_mm: Smoothing of the surface beside the object by the coat, standard deviation of a
            Gaussian; .3 to .45 fit the flank of one measured ball press.
        lag: Share of an indentation that is still there one frame after the object has left it; one
            parameter for the gel's creep, which lasts one to three frames.
    """

    thickness_mm: float = 4.0
    poisson_ratio: float = 0.48
    dome: float = 1.0
    friction: float = 1.0
    membrane_mm: float = 0.0
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
    """The rigid object that touches the gel.

    Args:
        name: A name in `indenters.INDENTERS`.
        variant: Seed of the shape's own random features (cells, weave phase, engraving).
        size: Scale of the shape; 1 is its nominal size.
        tilt_x: Slope of the object about the image's y axis, mm per mm.
        tilt_y: Slope of the object about the image's x axis, mm per mm.
        texture_um: Standard deviation of the surface texture in micrometres.
        texture_scale_mm: Correlation length of that texture.
        indenter: The shape itself, where it is none of `indenters.INDENTERS`.
    """

    name: str
    variant: int = 0
    size: float = 1.0
    tilt_x: float = 0.0
    tilt_y: float = 0.0
    texture_um: float = 0.0
    texture_scale_mm: float = 0.5
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
    """Pose of the object in every frame; all four tuples have one entry per frame.

    Args:
        depth_mm: Approach of the object beyond first touch on the pad's crown; <= 0 is no contact.
        x_mm: Position of the object's centre to the right of the view's middle.
        y_mm: Position of the object's centre below the view's middle.
        rotation_rad: Turn of the object, positive clockwise in the image.
        pre_slide_mm: Travel (right, down) in touch that ended at the first frame: the gel is
            sheared already. It shows in the gel's drift alone, and only friction carries it.
        pre_turn_rad: The same of a turn, positive clockwise.
    """

    depth_mm: tuple[float, ...]
    x_mm: tuple[float, ...]
    y_mm: tuple[float, ...]
    rotation_rad: tuple[float, ...]
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
    def stands_still(self) -> bool:
        """Whether every frame has the same pose."""
        return all(min(getattr(self, name)) == max(getattr(self, name)) for name in _POSE)

    @property
    def start(self) -> Path:
        """The path of the first frame alone."""
        return replace(self, **{name: getattr(self, name)[:1] for name in _POSE})


@dataclass(frozen=True)
class Mounting:
    """How the pad lies under the camera: what its crown, lights and markers share.

    Paths, labels and truth are in the camera's frame already; turning the camera turns both.

    Args:
        turn_rad: Turn of the pad in the image, positive clockwise: the camera's, the other way.
        x_mm: The pad's middle to the right of the view's middle.
        y_mm: The same downwards.
    """

    turn_rad: float = 0.0
    x_mm: float = 0.0
    y_mm: float = 0.0

    def __post_init__(self) -> None:
        _require("mounting's turn", self.turn_rad, -7.0, 7.0, "rad")
        _require("mounting's x", self.x_mm, -100.0, 100.0, "mm")
        _require("mounting's y", self.y_mm, -100.0, 100.0, "mm")


CENTRED = Mounting()


@dataclass(frozen=True)
class Markers:
    """Dark dots printed on the gel's surface in a square grid; they go where the gel goes.

    Args:
        spacing_mm: Distance of neighbours; 1.9 to 2.0, and 2.8 on one of them, measured on five
            recordings of GelSight Minis with markers.
        diameter_mm: Width of a dot at half its darkness; 0.6 to 0.8 in the same recordings.
        darkness: Share of the light that the middle of a dot swallows; 0.56 to 0.62 there.
        x_mm: Offset of the grid to the right from the pad's middle.
        y_mm: The same downwards.
    """

    spacing_mm: float = 1.95
    diameter_mm: float = 0.65
    darkness: float = 0.6
    x_mm: float = 0.0
    y_mm: float = 0.0

    def __post_init__(self) -> None:
        _require("markers' spacing", self.spacing_mm, 0.3, 100.0, "mm")
        _require("markers' diameter", self.diameter_mm, 0.01, 10.0, "mm")
        _require("markers' darkness", self.darkness, 0.0, 1.0)


@dataclass(frozen=True)
class VideoCodec:
    """Noise of a lossy video (MPEG-4): it stands still until the next frame stored whole.

    Measured on 25 recordings of 320 x 240: the noise of predicted frames is a third of that
    between two stored whole, and both are blotches that the channels share.

    Args:
        whole_grey: Standard deviation of the noise of a frame stored whole, R, G, B.
        predicted_grey: The same of what each predicted frame adds.
        frames_apart: Frames of the video between two of the clip; every twelfth is stored whole.
    """

    whole_grey: tuple[float, float, float] = (0.75, 0.64, 0.8)
    predicted_grey: tuple[float, float, float] = (0.27, 0.25, 0.27)
    frames_apart: int = 1


@dataclass(frozen=True)
class Optics:
    """Camera, coloured lights and noise; three-tuples are R, G, B.

    Args:
        mm_per_px_x: Width of one pixel of the 224-pixel image; 20.3 mm / 224 for GelSight Mini.
        mm_per_px_y: Height of one pixel; 15.2 mm / 224.
        light_turn_rad: Turn of each light's direction from the measured one, clockwise.
        light_gain: Strength of the shading of each light relative to the measured one.
        light_slope_x: Relative growth of each light's shading from the middle to the right border.
        light_slope_y: The same towards the lower border.
        common_light: Relative change of all channels per unit slope towards (right, down): stray
            white light.
        steep_darkening: Relative darkening of all channels on steep flanks, at slope 1.
        saturation: Softness beta of steep slopes in A g / sqrt(1 + beta^2 |g|^2).
        depth_gain: Relative brightening per mm of indentation.
        shadow: Relative darkening behind steep flanks, per unit slope.
        psf_mm: Gaussian blur of the camera and membrane.
        noise_grey: Standard deviation of one frame's noise in grey levels.
        drift_grey: Standard deviation of the brightness change between frames.
        light_change: Relative change of the light between idle frame and clip.
        jpeg_quality: Quality of frames stored as JPEG; None where they are not.
        video: What a lossy video leaves of the noise, in place of `noise_grey`; None for none.
        idle: Seed of the idle frame's field, specks and fixed pattern.
        mounting: How the pad lies under the camera.
        markers: Dots on the gel; None for a markerless one.
    """

    mm_per_px_x: float = 20.3 / 224
    mm_per_px_y: float = 15.2 / 224
    light_turn_rad: tuple[float, float, float] = (0.0, 0.0, 0.0)
    light_gain: tuple[float, float, float] = (1.0, 1.0, 1.0)
    light_slope_x: tuple[float, float, float] = (0.0, 0.0, 0.0)
    light_slope_y: tuple[float, float, float] = (0.0, 0.0, 0.0)
    common_light: tuple[float, float] = (0.0, 0.0)
    steep_darkening: float = 0.0
    saturation: float = 1.0
    depth_gain: tuple[float, float, float] = (0.066, 0.037, 0.083)
    shadow: float = 0.0
    psf_mm: float = 0.05
    noise_grey: tuple[float, float, float] = (1.7, 1.24, 2.0)
    drift_grey: float = 0.5
    light_change: tuple[float, float, float] = (0.0, 0.0, 0.0)
    jpeg_quality: int | None = None
    video: VideoCodec | None = None
    idle: int = 0
    mounting: Mounting = CENTRED
    markers: Markers | None = None

    @property
    def mm_per_px(self) -> tuple[float, float]:
        """Pixel size (x, y)."""
        return self.mm_per_px_x, self.mm_per_px_y


@dataclass(frozen=True)
class Scene:
    """One clip to simulate.

    Args:
        body: What touches.
        path: How it moves.
        motion: The one of ten names that the path was drawn for, or that fits it best.
        gel: The pad.
        optics: Camera and lights.
        dominance: How many times longer than the other's the path of the named turn or slide must
            be at the contact for the name to be true of the clip.
    """

    body: Body
    path: Path
    motion: Motion
    gel: Gel = Gel()
    optics: Optics = Optics()
    dominance: float = 1.0
