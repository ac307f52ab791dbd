"""The GeoTLM paper's own figures, for tables that set them beside ours; measured on other data."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Published:
    """One cell group of a table.

    Args:
        mean: Accuracy over folds.
        sd: Its standard deviation over folds.
        recall: Accuracy of each class, in the table's order; empty where the paper gives none.
    """

    mean: float
    sd: float
    recall: tuple[float, ...] = ()


DATA = (
    "ToucHD-Sim, simulated, five-fold",
    "TactileTracking, real, five-fold",
    "TactileTracking, real, leave-one-object-out",
)
"""The paper's data and protocols, in the order of the tuples below."""

Cells = tuple[Published | None, Published | None, Published | None]

CURL, BACKBONE, GEOTLM = "Curl + LR", "AnyTouch 2", "GeoTLM"
"""Rows that have a counterpart of ours: AnyTouch 2 is the paper's backbone without DGR."""

ROTATION: dict[str, Cells] = {
    CURL: (Published(0.890, 0.237, (0.876, 0.904)), Published(0.742, 0.072, (0.719, 0.765)), None),
    "Sparsh V-JEPA": (
        Published(0.710, 0.017, (0.731, 0.690)),
        Published(0.566, 0.033, (0.516, 0.615)),
        Published(0.531, 0.038, (0.510, 0.544)),
    ),
    "InternViT-300M": (
        Published(0.823, 0.023, (0.825, 0.822)),
        Published(0.552, 0.045, (0.473, 0.613)),
        Published(0.536, 0.037, (0.486, 0.581)),
    ),
    "T3": (
        Published(0.769, 0.043, (0.749, 0.789)),
        Published(0.563, 0.018, (0.497, 0.627)),
        Published(0.535, 0.043, (0.533, 0.524)),
    ),
    "AnyTouch (v1)": (
        Published(0.733, 0.027, (0.723, 0.743)),
        Published(0.550, 0.057, (0.614, 0.488)),
        Published(0.513, 0.062, (0.554, 0.483)),
    ),
    "UniT": (
        Published(0.685, 0.035, (0.658, 0.711)),
        Published(0.550, 0.042, (0.516, 0.581)),
        Published(0.515, 0.044, (0.534, 0.506)),
    ),
    BACKBONE: (
        Published(0.876, 0.017, (0.872, 0.879)),
        Published(0.547, 0.024, (0.538, 0.548)),
        Published(0.513, 0.033, (0.440, 0.599)),
    ),
    GEOTLM: (
        Published(0.952, 0.016, (0.953, 0.951)),
        Published(0.864, 0.067, (0.856, 0.873)),
        Published(0.659, 0.083, (0.692, 0.627)),
    ),
}
"""Two ways of turning: clockwise, counterclockwise (Table I)."""

SLIDING: dict[str, Cells] = {
    "Sparsh V-JEPA": (
        Published(0.710, 0.036, (0.715, 0.729, 0.686, 0.709)),
        Published(0.384, 0.046, (0.381, 0.131, 0.534, 0.333)),
        Published(0.365, 0.037, (0.376, 0.202, 0.480, 0.348)),
    ),
    "InternViT-300M": (
        Published(0.907, 0.034, (0.919, 0.875, 0.929, 0.904)),
        Published(0.338, 0.016, (0.495, 0.207, 0.313, 0.335)),
        Published(0.291, 0.058, (0.403, 0.234, 0.281, 0.251)),
    ),
    "T3": (
        Published(0.857, 0.023, (0.844, 0.880, 0.849, 0.857)),
        Published(0.383, 0.033, (0.350, 0.229, 0.520, 0.347)),
        Published(0.325, 0.048, (0.342, 0.226, 0.374, 0.321)),
    ),
    "AnyTouch (v1)": (
        Published(0.809, 0.006, (0.806, 0.816, 0.794, 0.823)),
        Published(0.334, 0.039, (0.303, 0.103, 0.568, 0.219)),
        Published(0.286, 0.036, (0.285, 0.204, 0.367, 0.251)),
    ),
    "UniT": (
        Published(0.691, 0.028, (0.666, 0.672, 0.729, 0.697)),
        Published(0.346, 0.013, (0.380, 0.262, 0.377, 0.331)),
        Published(0.317, 0.026, (0.360, 0.256, 0.347, 0.245)),
    ),
    BACKBONE: (
        Published(0.967, 0.014, (0.957, 0.960, 0.975, 0.974)),
        Published(0.363, 0.048, (0.313, 0.192, 0.614, 0.256)),
        Published(0.328, 0.036, (0.298, 0.197, 0.438, 0.307)),
    ),
    GEOTLM: (
        Published(0.989, 0.008, (0.991, 0.985, 0.988, 0.990)),
        Published(0.525, 0.088, (0.500, 0.316, 0.631, 0.577)),
        Published(0.396, 0.051, (0.347, 0.302, 0.458, 0.431)),
    ),
}
"""Four ways of sliding: left, right, up, down (Table II)."""

ABLATION: dict[str, Cells] = {
    BACKBONE: (*ROTATION[BACKBONE][:2], None),
    "DGR - contact mask": (
        Published(0.946, 0.014, (0.939, 0.952)),
        Published(0.768, 0.064, (0.772, 0.765)),
        None,
    ),
    "DGR - region pool": (
        Published(0.918, 0.010, (0.923, 0.912)),
        Published(0.781, 0.096, (0.783, 0.781)),
        None,
    ),
    GEOTLM: (*ROTATION[GEOTLM][:2], None),
}
"""Rotation with parts of DGR taken out (Table III)."""

FRAMES: dict[str, Cells] = {
    "AnyTouch 2, 2-frame": (Published(0.822, 0.022), None, None),
    "AnyTouch 2, 4-frame": (Published(0.876, 0.017), None, None),
    "GeoTLM, 2-frame": (Published(0.902, 0.025), None, None),
    "GeoTLM, 4-frame": (Published(0.952, 0.016), None, None),
}
"""Rotation by the number of frames (Table IV)."""
