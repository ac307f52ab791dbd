"""Damaged files of every format: each must end in a clip or in one sentence.

Read in a process of its own, so that a native decoder may die or hang without ending the run.
"""

from __future__ import annotations

import multiprocessing
import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from multiprocessing.connection import Connection
from pathlib import Path

import cv2
import numpy as np

from geotlm_lm.benchmarks.cases.damaged import write_video
from geotlm_lm.benchmarks.rows import Row, Run
from geotlm_lm.core.clip import Frames
from geotlm_lm.core.errors import GeoTLMError
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.recordings.read import read_background, read_clip

READ, REFUSED, HUNG, CRASHED = "read", "refused", "hung", "crashed"
ENDS = (READ, REFUSED, HUNG, CRASHED)
"""What may become of a file, the gravest last; the last two must not."""

FORMATS: dict[str, Callable[[Path, Frames], object]] = {
    ".npy": np.save,
    ".npz": lambda path, frames: np.savez_compressed(path, frames=frames, fps=25),
    ".tif": lambda path, frames: cv2.imwritemulti(str(path), [*frames]),
    ".avi": lambda path, frames: write_video(path, "MJPG", frames),
    ".mp4": lambda path, frames: write_video(path, "mp4v", frames),
    ".png": lambda path, frames: cv2.imwrite(str(path), frames[0]),
}
"""Ending -> who writes RGB frames (t, rows, columns, 3) soundly; of an image, the first."""


def file_rows(run: Run) -> Iterator[Row]:
    """Yield how the files of each format ended after each damage; the error is the bad share."""
    from geotlm_lm.benchmarks.stability_rows import simulated_cases  # too slow for each reader

    frames = simulated_cases(run, 1, 1)[0].clip.frames
    with tempfile.TemporaryDirectory() as folder:
        files = damaged_files(Path(folder), frames, run.size(20, 2), run.seed)
        files[".npz", "unpacks to 805 MB"] = [bomb := Path(folder) / "bomb.npz"]
        np.savez_compressed(bomb, frames=np.broadcast_to(np.uint8(0), (2**20, 16, 16, 3)))
        ended = read_all([path for paths in files.values() for path in paths])
        for done, ((ending, damage), paths) in enumerate(files.items()):
            run.progress("damaged files", done, len(files))
            ends = [next(ended) for _ in paths]
            counts = {end: sum(one[0] == end for one in ends) for end in ENDS}
            says = max(ends, key=lambda one: ENDS.index(one[0]))[1].replace(f"{folder}/", "")
            wrong = sum(counts[end] for end in ENDS[1 if damage == "sound" else 2 :]) / len(ends)
            yield Row(ending, damage, len(ends), wrong, outcome=says[:200], detail=counts)


def damaged_files(
    folder: Path, frames: Frames, count: int, seed: int
) -> dict[tuple[str, str], list[Path]]:
    """Write every format after every damage into an empty folder, the drawn ones `count` times."""
    sound, files = {}, {}
    for ending, write in FORMATS.items():
        write(folder / f"sound{ending}", frames)
        sound[ending] = (folder / f"sound{ending}").read_bytes()
    for ending, data in sound.items():
        rng = generator_for(seed, "files", ending)
        others = [other for name, other in sound.items() if name != ending]
        made = {"sound": [data], "empty": [b""], "wrong suffix": others}
        made["cut short"] = [data[: rng.integers(len(data))] for _ in range(count)]
        made["bytes flipped"] = [_flipped(data, rng) for _ in range(count)]
        places = rng.integers(256, size=count).tolist()
        made["header grown"] = [data[:at] + b"9999" + data[at:] for at in places]
        for damage, contents in made.items():
            for number, content in enumerate(contents):
                path = folder / f"{damage} {number}{ending}"
                path.write_bytes(content)
                files.setdefault((ending, damage), []).append(path)
    return files


def _flipped(data: bytes, rng: np.random.Generator) -> bytes:
    changed = np.frombuffer(data, np.uint8).copy()
    changed[rng.integers(len(data), size=8)] ^= np.uint8(1 << rng.integers(8))
    return changed.tobytes()


def read_all(paths: Sequence[Path], hang_s: float = 60.0) -> Iterator[tuple[str, str]]:
    """Yield what became of each file and in whose words; starting the process takes 10 s."""
    context, left = multiprocessing.get_context("spawn"), list(paths)  # a fork's torch hangs
    while left:
        heard, sent = context.Pipe(duplex=False)
        process = context.Process(target=_read_each, args=(left, sent), daemon=True)
        process.start()
        sent.close()
        death = HUNG, f"no end of it within {hang_s:g} s"
        try:
            while left and heard.poll(hang_s):
                ended = heard.recv()
                left.pop(0)
                yield ended
        except EOFError:
            death = CRASHED, "its process died"
        process.kill()
        process.join()
        if left:
            left.pop(0)
            yield death


def _read_each(paths: Sequence[Path], sent: Connection) -> None:
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # native decoders complain there
    for path in paths:
        try:
            (read_background if path.suffix == ".png" else read_clip)(path)
            sent.send((READ, ""))
        except Exception as error:
            is_sentence = isinstance(error, GeoTLMError) and len(str(error).splitlines()) == 1
            sent.send((REFUSED if is_sentence else CRASHED, f"{type(error).__name__}: {error}"))
