"""Ask a camera-based touch sensor, in plain language, how the touched object moves.

Public names load on first use, so that importing the package costs neither torch nor transformers.
"""

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_HOME_OF = {
    "Answer": "geotlm_lm.answering",
    "Answerer": "geotlm_lm.answering",
    "CLIP_SUFFIXES": "geotlm_lm.recordings.read",
    "COMPONENTS": "geotlm_lm.core.twist",
    "Clip": "geotlm_lm.core.clip",
    "DEFAULT_FPS": "geotlm_lm.recordings.streams",
    "Drawing": "geotlm_lm.track.drawing",
    "Exported": "geotlm_lm.track.export",
    "FRAME_COUNT": "geotlm_lm.core.geometry",
    "FrameSpec": "geotlm_lm.core.frame_spec",
    "GeoTLMError": "geotlm_lm.core.errors",
    "IMAGE_SUFFIXES": "geotlm_lm.recordings.images",
    "LEAST_SURE": "geotlm_lm.answering",
    "Monitor": "geotlm_lm.answering.monitor",
    "Motion": "geotlm_lm.core.labels",
    "RELATIVE_TOLERANCE": "geotlm_lm.core.tolerance",
    "SPAN_DEVIATIONS": "geotlm_lm.motion.belief",
    "Seen": "geotlm_lm.views",
    "Session": "geotlm_lm.answering",
    "TOLERANCES": "geotlm_lm.core.tolerance",
    "TRUE_DISPLACEMENT": "geotlm_lm.views",
    "StuckPicture": "geotlm_lm.recordings.streams",
    "Touch": "geotlm_lm.simulation.touch",
    "Tracker": "geotlm_lm.track.tracker",
    "Twist": "geotlm_lm.core.twist",
    "Units": "geotlm_lm.track.export",
    "Verdict": "geotlm_lm.answering.monitor",
    "answer_schema": "geotlm_lm.answering.answer",
    "arrow_ends": "geotlm_lm.views",
    "ask_simulated": "geotlm_lm.answering.simulated",
    "camera_size": "geotlm_lm.core.geometry",
    "change_map": "geotlm_lm.recordings.touch",
    "declared_bytes": "geotlm_lm.recordings.read",
    "declared_length": "geotlm_lm.recordings.read",
    "draw_caption": "geotlm_lm.views",
    "draw_depth": "geotlm_lm.views",
    "draw_motion": "geotlm_lm.views",
    "drawing_of": "geotlm_lm.track.drawing",
    "figure_of": "geotlm_lm.core.figures",
    "flow_phrase": "geotlm_lm.reference_readings",
    "is_streamed": "geotlm_lm.recordings.streams",
    "open_source": "geotlm_lm.recordings.streams",
    "picture": "geotlm_lm.views",
    "plot_png": "geotlm_lm.track.plot",
    "read_clip": "geotlm_lm.recordings.read",
    "regions_of": "geotlm_lm.answering.encoded",
    "second_opinions": "geotlm_lm.reference_readings",
    "simulate_touch": "geotlm_lm.simulation.touch",
    "views_of": "geotlm_lm.views",
    "way_phrase": "geotlm_lm.query.phrases",
    "write_plot": "geotlm_lm.track.plot",
}

__all__ = ["__version__", *sorted(_HOME_OF)]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'geotlm_lm' has no attribute '{name}'")
    return getattr(import_module(_HOME_OF[name]), name)


def __dir__() -> list[str]:
    return __all__
