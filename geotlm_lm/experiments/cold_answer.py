"""One question to the command line, started anew several times: the answer and how long it took."""

from __future__ import annotations

import json
import shlex
import subprocess
import sys
import time
from pathlib import Path

from geotlm_lm.core.errors import GeoTLMError
from geotlm_lm.core.record import RunRecord

RUNS = 5


class AnswerFailed(GeoTLMError):
    """The command line did not answer.

    Args:
        message: The sentence.
        exit_code: The command's own, which tells why.
    """

    def __init__(self, message: str, exit_code: int) -> None:
        super().__init__(message)
        # A negative one is the signal it ended of: not a code to exit with.
        self.exit_code = exit_code if exit_code > 0 else GeoTLMError.exit_code


def cold_answer(clip: Path, question: str, *, command: str, runs: int = RUNS) -> RunRecord:
    """Run `geotlm-lm answer --json` in fresh processes.

    Args:
        clip: The recording.
        question: The question.
        command: The command line of this run, for the record.
        runs: How many times, after one run that warms the file cache.

    Raises:
        AnswerFailed: If the command line exits with an error.
    """
    arguments = ["answer", "--clip", str(clip), "--q", question, "--json"]
    seconds = []
    started = time.perf_counter()
    for _ in range(runs + 1):
        begun = time.perf_counter()
        done = subprocess.run(
            [sys.executable, "-m", "geotlm_lm", *arguments], capture_output=True, text=True
        )
        seconds.append(time.perf_counter() - begun)
        if done.returncode:
            raise AnswerFailed(
                f"the answer exited with {done.returncode}: {done.stderr.strip()}",
                done.returncode,
            )
    shown = shlex.join(["geotlm-lm", *arguments[:-1]])
    return RunRecord(
        name="answer",
        command=command,
        seed=0,
        seconds=time.perf_counter() - started,
        numbers={
            "shown": shown,
            "answer": json.loads(done.stdout.splitlines()[-1]),
            "cold_s": [round(value, 3) for value in sorted(seconds[1:])],
        },
    )
