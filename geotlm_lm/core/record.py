"""A run record: what was measured, by which command, on which machine; JSON in and out."""

from __future__ import annotations

import json
import os
import platform
import subprocess
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from geotlm_lm.core.errors import GeoTLMError, first_line
from geotlm_lm.core.files import write_text_atomically

RECORD_FORMAT = 1


class UnreadableRecord(GeoTLMError):
    """A file of recorded numbers is missing, damaged, or something else."""


@dataclass(frozen=True)
class RunRecord:
    """Numbers, plain JSON values, and everything needed to get them again."""

    name: str
    command: str
    seed: int
    seconds: float
    numbers: dict[str, Any]
    config: dict[str, Any] = field(default_factory=dict)
    commit: str = field(default_factory=lambda: commit())
    machine: dict[str, Any] = field(default_factory=lambda: machine())
    made_utc: str = field(default_factory=lambda: datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ"))
    format: int = RECORD_FORMAT

    def save(self, path: Path) -> None:
        """Write the record as JSON, atomically."""
        write_text_atomically(path, json.dumps(asdict(self), indent=1, sort_keys=True) + "\n")

    @classmethod
    def load(cls, path: Path) -> RunRecord:
        """Read a record written by `save`."""
        try:
            return cls(**json.loads(path.read_text(encoding="utf-8")))
        except (OSError, ValueError, TypeError, RecursionError) as error:
            raise UnreadableRecord(
                f"{path}: is no record of a run ({first_line(error)}); make it again by the "
                f"command that wrote it."
            ) from error


def machine() -> dict[str, Any]:
    """Return the processor, its core count, and the versions that decide speed and numbers."""
    packages = ("numpy", "torch", "transformers", "opencv-contrib-python-headless")
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "versions": {package: _version(package) for package in packages},
    }


def _version(package: str) -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(package)
    except PackageNotFoundError:
        return "absent"


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def commit() -> str:
    """Return the checkout's commit, '+' appended when files differ from it; '' outside git."""
    root = Path(__file__).resolve().parents[2]
    if not (root / ".git").exists():
        return ""
    git = ["git", "-C", str(root)]
    try:
        head = subprocess.run([*git, "rev-parse", "HEAD"], capture_output=True, text=True)
        changed = subprocess.run(
            [*git, "status", "--porcelain", "-uno"], capture_output=True, text=True
        )
    except OSError:
        return ""
    return head.stdout.strip()[:12] + ("+" if changed.stdout.strip() else "")
