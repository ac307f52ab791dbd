"""Draws a simulated recording's track for the documents: `python .ci/track_picture.py docs`."""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from geotlm_lm.benchmarks.tracks import streams

SEED, PLACE = 3, 3
"""A stream that slides, rests, turns, rests and turns back."""


def draw(folder: Path) -> None:
    """Write track.png."""
    *_, stream = streams(PLACE + 1, SEED)
    with tempfile.TemporaryDirectory() as made:
        path = Path(made) / "recording.npz"
        np.savez(path, frames=stream.clip.frames, fps=stream.clip.fps)
        command = [sys.executable, "-m", "geotlm_lm", "track", str(path), "--force"]
        subprocess.run([*command, "--plot", str(folder / "track.png")], check=True)
    print(stream.planned)


if __name__ == "__main__":
    draw(Path(sys.argv[1]))
