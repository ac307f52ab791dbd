"""The installation: versions, extras, cameras, and whether the shipped model answers."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path

from geotlm_lm import __version__
from geotlm_lm.core.errors import GeoTLMError
from geotlm_lm.core.files import resource_dir
from geotlm_lm.doctor.examine import Finding

PACKAGES = ("numpy", "torch", "transformers", "tokenizers", "opencv-contrib-python-headless")

EXTRAS = {
    "app": ("gradio", "the page is not served"),
    "mcp": ("mcp", "agents are not served"),
    "eval": ("scipy", "benches and their pictures are not made"),
    "track": ("pyarrow", "no .parquet tables and plots are written"),
    "lerobot": ("av", "data sets of LeRobot and AV1 videos are not read"),
    "ros": ("rosbags", "bags of ROS are not read"),
}
"""Extra -> a package that only it brings, and what is missed without."""

EXAMPLE, QUESTION, EXPECTED = "hex_nut_counterclockwise", "Which way is it turning?", "counterclock"


def examine_installation(model: Path | None = None) -> list[Finding]:
    """Return every finding; of the shipped bundle, or of one in a folder."""
    return [_versions(), *map(_extra, EXTRAS), _cameras(), _answers(model)]


def _versions() -> Finding:
    versions = [f"geotlm-lm {__version__}", f"Python {platform.python_version()}"]
    lacking = []
    for name in PACKAGES:
        try:
            versions.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            lacking.append(name)
    if not lacking:
        return Finding("versions", "fine", f"{', '.join(versions)}.")
    return Finding(
        "versions",
        "fault",
        f"{', '.join(versions)}; not installed: {', '.join(lacking)}.",
        "Commands that need them fail.",
        "Run `pip install geotlm-lm` anew.",
    )


def _extra(name: str) -> Finding:
    package, missed = EXTRAS[name]
    if find_spec(package) is not None:
        return Finding(f"extra {name}", "fine", "installed.")
    advice = f"If you need it, run `pip install 'geotlm-lm[{name}]'`."
    return Finding(f"extra {name}", "limit", "not installed.", f"Without it {missed}.", advice)


def _cameras() -> Finding:
    devices = sorted(str(path) for path in Path("/dev").glob("video*"))
    if devices:
        return Finding("cameras", "fine", f"{', '.join(devices)}.")
    return Finding(
        "cameras",
        "limit",
        "no /dev/video* was found.",
        "Recordings are answered about; `watch 0` has nothing to watch.",
        "Plug the sensor in, if you mean to watch one.",
    )


def _answers(model: Path | None) -> Finding:
    """Judge the model by one question about an example whose answer is known."""
    subject = "model"
    try:
        from geotlm_lm.answering import Answerer
        from geotlm_lm.recordings.read import read_clip

        answerer = Answerer.load(model)
        clip = read_clip(resource_dir("app") / "examples" / f"{EXAMPLE}.npz")
        answer = answerer.ask(answerer.encode(clip), QUESTION)
    except (GeoTLMError, FileNotFoundError, ImportError) as error:
        return Finding(
            subject, "fault", str(error), "Nothing is answered.", "Install the package anew."
        )
    measured = f'"{QUESTION}" of {EXAMPLE}: "{answer.text}" in {answer.timing_ms["total"]:.0f} ms.'
    if EXPECTED in answer.text.lower():
        return Finding(subject, "fine", measured)
    return Finding(
        subject,
        "fault",
        measured,
        "The example turns counterclockwise: answers of this model cannot be relied on.",
        "Give the shipped bundle, or install the package anew.",
    )
