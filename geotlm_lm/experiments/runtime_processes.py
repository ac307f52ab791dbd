"""Fresh processes: the peak memory of each way to answer, and the cold start of every command.

The import times that make up a cold start come from the interpreter's own account
(`python -X importtime`), summed over each outermost package.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import GeoTLMError
from geotlm_lm.core.threads import THREAD_VARIABLES
from geotlm_lm.experiments.judging import QUESTION
from geotlm_lm.experiments.runtime_memory import WAYS
from geotlm_lm.experiments.runtime_stages import long_recording
from geotlm_lm.simulation.touch import Touch, simulate_touch

Progress = Callable[[str, int, int], None]

ONE_THREAD = dict.fromkeys(THREAD_VARIABLES, "1")

NAMED_PACKAGES = (
    "torch",
    "numpy",
    "cv2",
    "transformers",
    "tokenizers",
    "safetensors",
    "jinja2",
    "scipy",
    "sklearn",
    "matplotlib",
    "gradio",
    "typer",
    "rich",
    "geotlm_lm",
)
"""Outermost packages that a cold start is told by; Python's own and all else are "other"."""


class CommandFailed(GeoTLMError):
    """A command exited with an error in its fresh process."""


@dataclass(frozen=True)
class Started:
    """One command as it is typed after `geotlm-lm`.

    Args:
        name: What the table calls it.
        arguments: Its words.
        typed: What is typed into it.
    """

    name: str
    arguments: tuple[str, ...]
    typed: str = ""


def memory_rows(model: Path | None, progress: Progress) -> list[dict[str, Any]]:
    """Return the peak memory of each way to answer, in MiB, of a fresh process on one thread."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        clip = _save_clip(Path(folder))
        for done, way in enumerate(WAYS, start=1):
            program = (
                "from pathlib import Path; "
                "from geotlm_lm.experiments.runtime_memory import peak_megabytes; "
                f"model = {None if model is None else str(model)!r}; "
                f"print(peak_megabytes({way!r}, Path({str(clip)!r}), model and Path(model)))"
            )
            said, _ = _run([sys.executable, "-c", program])
            rows.append({"way": way, "megabytes": float(said.stdout)})
            progress("memory", done, len(WAYS))
    return rows


def command_rows(
    runs: int,
    model: Path | None,
    progress: Progress,
    asked: Sequence[str] | None = None,
) -> list[dict[str, Any]]:
    """Return the cold start of every command and what its imports take.

    The commands are started in turn, run by run, after one start each that warms the file cache.

    Args:
        runs: Starts that count.
        model: A bundle's folder; None for the one that ships.
        progress: Told how far the run is.
        asked: Names of the commands to start; all by default.

    Raises:
        CommandFailed: If one exits with an error.
    """
    with tempfile.TemporaryDirectory() as folder:
        commands = [
            one for one in _commands(Path(folder), model) if asked is None or one.name in asked
        ]
        seconds: dict[str, list[float]] = {one.name: [] for one in commands}
        for run in range(runs + 1):
            for one in commands:
                _, took = _run(_line(one), one.typed)
                if run:
                    seconds[one.name].append(took)
            progress("cold starts", run, runs)
        return [
            {"command": one.name, "seconds": sorted(seconds[one.name]), **_imports(one)}
            for one in commands
        ]


def import_seconds(account: str) -> dict[str, float]:
    """Return the seconds each outermost package's modules took to import, without what they import.

    Args:
        account: What `python -X importtime` wrote.
    """
    found: Counter[str] = Counter()
    for microseconds, name in re.findall(
        r"^import time:\s+(\d+) \|\s+\d+ \|\s+(\S+)$", account, re.M
    ):
        package = name.partition(".")[0]
        found[package if package in NAMED_PACKAGES else "other"] += int(microseconds)
    return {name: micro / 1e6 for name, micro in found.most_common()}


def _commands(folder: Path, model: Path | None) -> list[Started]:
    clip, film = str(_save_clip(folder)), str(_save_film(folder))
    bundle = () if model is None else ("--model", str(model))
    ask = ("--clip", clip, "--q", QUESTION, *bundle)
    return [
        Started("--version", ("--version",)),
        Started("--help", ("--help",)),
        Started("info", ("info", "--clip", clip)),
        Started("answer", ("answer", *ask)),
        Started("answer --why", ("answer", *ask, "--why")),
        Started("chat, one question", ("chat", "--clip", clip, *bundle), f"{QUESTION}\n"),
        Started("watch, 5 s recorded", ("watch", "--source", film, *bundle)),
        Started("simulate, one clip", ("simulate", "--force", "--clip", str(folder / "made.npz"))),
        Started("evaluate, one clip per task", ("evaluate", "--clips", "1", *bundle)),
        Started("train --help", ("train", "--help")),
        Started("app --help", ("app", "--help")),
        Started("report --help", ("report", "--help")),
    ]


def _line(one: Started, *options: str) -> list[str]:
    return [sys.executable, *options, "-m", "geotlm_lm", *one.arguments]


def _imports(one: Started) -> dict[str, Any]:
    done, _ = _run(_line(one, "-X", "importtime"), one.typed)
    packages = import_seconds(done.stderr)
    return {"import_s": sum(packages.values()), "packages_s": packages}


def _run(line: list[str], typed: str = "") -> tuple[subprocess.CompletedProcess[str], float]:
    started = time.perf_counter()
    done = subprocess.run(
        line, input=typed, capture_output=True, text=True, env={**os.environ, **ONE_THREAD}
    )
    took = time.perf_counter() - started
    if done.returncode:
        last = done.stderr.strip().splitlines()[-1:] or ["nothing was said"]
        raise CommandFailed(
            f"{' '.join(line[1:])[:200]}: exited with {done.returncode} ({last[0]}); run it alone "
            f"to see why."
        )
    return done, took


def _touch() -> Clip:
    return simulate_touch(Touch(twist_deg=12.0)).clip


def _save_clip(folder: Path) -> Path:
    clip, path = _touch(), folder / "clip.npz"
    np.savez_compressed(path, frames=clip.frames, background=clip.background)
    return path


def _save_film(folder: Path) -> Path:
    clip, path = long_recording(_touch()), folder / "film.avi"
    rows, columns = clip.frames.shape[1:3]
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 25.0, (columns, rows))
    for frame in clip.frames:
        writer.write(cv2.cvtColor(frame, cv2.COLOR_RGB2BGR))
    writer.release()
    return path
