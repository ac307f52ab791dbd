"""The part of the fuzzer that may be killed: it runs one target on damaged inputs and counts.

What reaches a new line after another is kept and damaged further.
"""

from __future__ import annotations

import os
import random
import resource
import sys
import time
import traceback
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path
from types import FrameType
from typing import Any

import geotlm_lm
from geotlm_lm.core.errors import LONGEST_MESSAGE, GeoTLMError
from geotlm_lm.fuzzing.mutate import damaged
from geotlm_lm.fuzzing.target import Prepare

WATCHED = (str(Path(geotlm_lm.__file__).parent), "/numpy/lib/", "/zipfile", "/csv.py")
"""Parts of the paths of files whose lines count as reached; native decoders are not seen into."""

REPORT_EVERY_S = 0.5

HEAVY_BYTES = 2**30
"""Memory one input of at most 128 KiB may take; the readers hold half of it by promise."""

SLOW_S = 5.0
"""Processor time one input may take under the tracing, which makes it some ten times slower."""

ADDRESS_BYTES = 8 * 2**30
"""Address space on top of what is in use at the start; more is refused by the system."""

CURRENT = "current.bin"
"""The input that is being run, for the parent to find after a crash."""


class Reached:
    """Pairs of lines that ran one after the other."""

    def __init__(self) -> None:
        self.pairs: set[tuple[int, ...]] = set()
        self._last = (0, 0)
        self._is_watched: dict[str, bool] = {}

    def during(self, call: Callable[[], Any]) -> None:
        """Run `call` and note where it went."""
        self._last = (0, 0)
        sys.settrace(self._called)
        try:
            call()
        finally:
            sys.settrace(None)

    def _called(self, frame: FrameType, event: str, argument: Any) -> Any:
        name = frame.f_code.co_filename
        if name not in self._is_watched:
            self._is_watched[name] = any(part in name for part in WATCHED)
        return self._ran if self._is_watched[name] else None

    def _ran(self, frame: FrameType, event: str, argument: Any) -> Any:
        if event == "line":
            here = (id(frame.f_code), frame.f_lineno)
            self.pairs.add(self._last + here)
            self._last = here
        return self._ran


def explore(prepare: Prepare, folder: str, seconds: float, seed: int, sent: Connection) -> None:
    """Run a target for some seconds and send counts and findings.

    Args:
        prepare: Makes the target.
        folder: An empty one, for the target's files and the current input.
        seconds: To run.
        seed: Of the damage.
        sent: Where (counts, findings since the last) go.
    """
    home = Path(folder)
    target = prepare(home)
    for seed_input in target.seeds:
        target.run(seed_input)  # lawful; and what it imports is neither traced nor timed below
    _limit_memory()
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stderr.fileno())  # native decoders complain there
    rng, reached = random.Random(seed), Reached()
    kept, waiting = list(target.seeds), list(target.seeds)
    counts = {"runs": 0, "read": 0, "refused": 0, "kept": 0, "pairs": 0}
    counts |= {"slowest_ms": 0.0, "memory_mib": 0.0}
    findings: list[dict[str, Any]] = []
    began = reported = time.monotonic()
    while (now := time.monotonic()) - began < seconds:
        data = waiting.pop() if waiting else damaged(rng.choice(kept), kept, target.words, rng)
        (home / CURRENT).write_bytes(data)
        known = len(reached.pairs)
        findings += _run_once(target.run, data, reached, counts)
        if len(reached.pairs) > known:
            kept.append(data)
        counts |= {"kept": len(kept), "pairs": len(reached.pairs)}
        if now - reported > REPORT_EVERY_S:
            sent.send((dict(counts), findings))
            reported, findings = now, []
    sent.send((dict(counts), findings))


def _run_once(
    run: Callable[[bytes], None], data: bytes, reached: Reached, counts: dict[str, Any]
) -> list[dict[str, Any]]:
    """Run one input, count what came of it, and return what must not have."""
    before, began, found = _peak_bytes(), time.process_time(), []
    try:
        reached.during(lambda: run(data))
        counts["read"] += 1
    except GeoTLMError as error:
        counts["refused"] += 1
        if not _is_one_sentence(str(error)):
            found.append(_finding("untidy", data, repr(str(error))[:300]))
    except Exception as error:
        where = traceback.extract_tb(error.__traceback__)[-1]
        said = f"{type(error).__name__}: {error} ({Path(where.filename).name}:{where.lineno})"
        found.append(_finding("defect", data, said[:300]))
    counts["runs"] += 1
    worked_s = time.process_time() - began
    counts["slowest_ms"] = max(counts["slowest_ms"], 1e3 * worked_s)
    if worked_s > SLOW_S:
        found.append(_finding("slow", data, f"took {worked_s:.1f} s of work"))
    taken = _peak_bytes() - before
    counts["memory_mib"] = max(counts["memory_mib"], taken / 2**20)
    if taken > HEAVY_BYTES:
        found.append(_finding("heavy", data, f"took {taken / 2**20:.0f} MiB"))
    return found


def _is_one_sentence(text: str) -> bool:
    return bool(text.strip()) and "\n" not in text and len(text) <= LONGEST_MESSAGE


def _finding(kind: str, data: bytes, said: str) -> dict[str, Any]:
    return {"kind": kind, "input": data, "said": said}


def _peak_bytes() -> int:
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def _limit_memory() -> None:
    """Have the system refuse this process more than a few GiB: a blow-up then is an exception."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limit = pages * resource.getpagesize() + ADDRESS_BYTES
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
