"""Ways timed in turn, and the commands as fresh processes: their cold starts and peak memory."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from geotlm_lm.benchmarks.cases.damaged import write_video
from geotlm_lm.benchmarks.rows import Row, Run
from geotlm_lm.benchmarks.statistics import milliseconds
from geotlm_lm.benchmarks.variants import QUESTION
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.process import THREAD_VARIABLES
from geotlm_lm.simulation.touch import Touch, simulate_touch

COMMAND = (
    "import atexit, runpy; held = lambda: [x for x in open('/proc/self/status') if 'VmHWM' in x]; "
    "atexit.register(lambda: print(*held())); runpy.run_module('geotlm_lm', run_name='__main__')"
)
"""A command that last prints the most memory it ever held, where there is Linux to tell it."""

Way = Callable[[], Any]

Timed = tuple[Any, float]
"""What one run of a way gave, and the milliseconds it took."""


def in_turn(ways: Mapping[str, Way], repeats: int) -> dict[str, list[Timed]]:
    """Return every repeat of every way; another begins each round, and the first is not counted."""
    runs: dict[str, list[Timed]] = {name: [] for name in ways}
    names = list(ways)
    for turn in range(repeats + 1):
        first = turn % len(names)
        for name in (*names[first:], *names[:first]):
            started = time.perf_counter()
            result = ways[name]()
            if turn:
                runs[name].append((result, 1e3 * (time.perf_counter() - started)))
    return runs


def timed_rows(case: str, ways: Mapping[str, Way], repeats: int) -> Iterator[Row]:
    """Yield a row per way with its milliseconds."""
    for name, runs in in_turn(ways, repeats).items():
        yield Row(case, name, repeats, **milliseconds([ms for _, ms in runs]))


def command_rows(run: Run) -> Iterator[Row]:
    """Yield the cold start and the peak memory of each command a user waits for."""
    bundle = () if run.model is None else ("--model", str(run.model))
    with tempfile.TemporaryDirectory() as folder:
        touch = simulate_touch(Touch(twist_deg=12.0)).clip
        clip, film = f"{folder}/clip.npz", f"{folder}/film.avi"
        np.savez_compressed(clip, frames=touch.frames, background=touch.background)
        write_video(Path(film), "MJPG", long_recording(touch).frames)
        commands = {
            "--help": ("--help",),
            "answer": ("answer", "--clip", clip, "--q", QUESTION, *bundle),
            "chat, one question": ("chat", "--clip", clip, *bundle),
            "watch, 5 s recorded": ("watch", "--source", film, *bundle),
        }
        ways = {name: partial(run_fresh, COMMAND, *words) for name, words in commands.items()}
        for name, runs in in_turn(ways, run.size(5, 1)).items():
            held = [int(line.split()[1]) for line in runs[0][0] if line.startswith("VmHWM")]
            peak, times = held[0] / 2**10 if held else None, milliseconds([ms for _, ms in runs])
            yield Row("one fresh process", name, len(runs), memory_mib=peak, **times)


def run_fresh(code: str, *words: str) -> list[str]:
    """Run Python code on one thread, `QUESTION` typed in; return the lines it printed.

    Raises:
        subprocess.CalledProcessError: If it exits with an error; what it said is on stderr.
    """
    own = {**os.environ, **dict.fromkeys(THREAD_VARIABLES, "1")}
    line, typed = [sys.executable, "-c", code, *words], f"{QUESTION}\n"
    done = subprocess.run(line, input=typed, stdout=subprocess.PIPE, text=True, env=own, check=True)
    return done.stdout.splitlines()


def long_recording(clip: Clip) -> Clip:
    """Return 5 s at 25 fps, the idle gel and then the clip: what is tracked."""
    return Clip(np.repeat(np.concatenate([clip.background[None], clip.frames]), 25, axis=0))
