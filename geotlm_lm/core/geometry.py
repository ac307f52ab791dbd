"""Sizes of the data flow, each under its own name (several happen to be equal to 14 or 2)."""

IMAGE_SIDE = 224
"""Pixels per side of the square image a backbone reads (paper, Sec. Method)."""

CAMERA_PX = (240, 320)
"""Rows and columns of a GelSight Mini's picture, which clips of our square are squashed from."""

SHAPE_TOLERANCE = 0.05
"""Share by which a picture may be wider or narrower than a camera's and still fill our square: in
training, pixels differ as much from square ones."""

PATCH_SIDE = 16
"""Pixels per side of one patch (ViT-B/16)."""

GRID_SIDE = IMAGE_SIDE // PATCH_SIDE
"""Patches per side."""

FRAME_COUNT = 4
"""Frames in one clip."""

TUBE_FRAMES = 2
"""Frames that share one temporal tube."""

TIME_BIN_COUNT = FRAME_COUNT // TUBE_FRAMES
"""Time-bins after the temporal tube."""

SENSOR_TOKEN_COUNT = 5
"""Sensor tokens, as in AnyTouch 2's layout of 1 global, 5 sensor and 392 patch tokens."""

SHEAR_CHANNEL_COUNT = 2
"""In-plane components of the shear signal, (x, y)."""

FLOW_SCALE_PX = 4.0
"""Pixels of accumulated flow, of a 224-pixel image, that are 1 in inputs and learned shear."""

REGIONS = ("upper", "lower", "upper_minus_lower", "left", "right", "left_minus_right", "global")
"""The seven pooling regions in the paper's order (Eq. 6)."""

REGION_COUNT = len(REGIONS)

DESCRIPTOR_DIM = REGION_COUNT * SHEAR_CHANNEL_COUNT
"""Length of the descriptor r: the seven regions of x, then the seven regions of y (Eq. 8)."""


def camera_size(rows: int, columns: int) -> tuple[int, int]:
    """Return the rows and columns of a picture before it was squashed to our square.

    A camera's pixels are square. Pictures that come as our square were squashed from a camera of
    four to three, as the simulator's are; others are as the camera took them.
    """
    return CAMERA_PX if (rows, columns) == (IMAGE_SIDE, IMAGE_SIDE) else (rows, columns)


def filled_size(rows: int, columns: int) -> tuple[int, int]:
    """Return the rows and columns of our square that a picture fills; idle gel fills the rest.

    The square stands for a camera of four to three. A turn looks like another motion in pixels of
    another shape: of 271 real turns cut to 240 x 240 and recorded a quarter turned the words named
    231 stretched over the square, 253 in their own shape.
    """
    camera_rows, camera_columns = camera_size(rows, columns)
    wider = camera_columns / camera_rows / (CAMERA_PX[1] / CAMERA_PX[0])
    if abs(wider - 1) <= SHAPE_TOLERANCE:
        return IMAGE_SIDE, IMAGE_SIDE
    # The same margin on both sides.
    short = IMAGE_SIDE - 2 * round(IMAGE_SIDE * (1 - min(wider, 1 / wider)) / 2)
    short = max(short, 2)
    return (IMAGE_SIDE, short) if wider < 1 else (short, IMAGE_SIDE)


def pixel_aspect(rows: int, columns: int) -> float:
    """Return the width of a pixel of our square over its height, on the gel."""
    filled_rows, filled_columns = filled_size(rows, columns)
    rows, columns = camera_size(rows, columns)
    return columns / filled_columns / (rows / filled_rows)


def travel_scale(
    rows: int, columns: int, mm_per_px: float | None = None
) -> tuple[str, tuple[float, float]]:
    """Return "px" or "mm", and the lengths in it of a pixel of our square across and down.

    `mm_per_px` is the width on the gel of a pixel of the picture as it came, of `rows` and
    `columns`; None measures in its pixels.
    """
    filled_rows, filled_columns = filled_size(rows, columns)
    across, down = columns / filled_columns, rows / filled_rows
    if mm_per_px is None:
        return "px", (across, down)
    # A camera's own pixels are square; those of our square image are wider than high.
    camera_rows, camera_columns = camera_size(rows, columns)
    height = camera_rows / rows * columns / camera_columns
    return "mm", (mm_per_px * across, mm_per_px * height * down)
