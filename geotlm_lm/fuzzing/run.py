"""Damaged files and nonsense questions, for as long as one likes: what crashes, hangs or swells.

Each target runs in a process of its own, so that a native decoder may die without ending the run.
"""

from __future__ import annotations

import hashlib
import multiprocessing
import os
import tempfile
import time
from collections.abc import Callable, Mapping
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from geotlm_lm.core.record import RunRecord
from geotlm_lm.fuzzing.explore import CURRENT, explore
from geotlm_lm.fuzzing.target import Prepare

HANG_S = 20.0
"""Processor time after which an input that is still read counts as a hang; what takes longest
lawfully takes 0.3 s."""

STUCK_S = 200.0
"""The same in real time, for what waits without working; also the time a target may load."""

Progress = Callable[[str, int, int], None]


def fuzz(
    targets: Mapping[str, Prepare],
    seconds: float,
    found: Path,
    *,
    seed: int,
    command: str,
    progress: Progress,
) -> RunRecord:
    """Run every target for an equal share of the time.

    Args:
        targets: By name.
        seconds: For all of them together.
        found: Folder for the inputs that must not have done what they did; made when needed.
        seed: Of the damage.
        command: The command line of this run, for the record.
        progress: Told the target, its place and how many there are.

    Returns:
        Per target the counts, and `findings`, one per kind and message.
    """
    began = time.perf_counter()
    counts: dict[str, Any] = {}
    findings: dict[tuple[str, str], dict[str, Any]] = {}
    for place, (name, prepare) in enumerate(targets.items()):
        progress(name, place, len(targets))
        counts[name], these = _fuzz_one(prepare, seconds / len(targets), seed)
        for one in these:
            findings.setdefault((name, one["said"]), one | {"target": name})
    kept = [_keep(one, found) for one in findings.values()]
    return RunRecord(
        name="fuzz",
        command=command,
        seed=seed,
        seconds=time.perf_counter() - began,
        numbers={"targets": counts, "findings": kept},
        config={"seconds_per_target": seconds / len(targets), "hang_s": HANG_S, "stuck_s": STUCK_S},
    )


def _fuzz_one(
    prepare: Prepare, seconds: float, seed: int
) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Run one target, anew after each death, until its time is up."""
    total: dict[str, Any] = {"restarts": 0}
    findings: list[dict[str, Any]] = []
    left, run = seconds, 0
    while left > 0.5:
        began = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            counts, these, ended = _watch(prepare, folder, left, seed + 1000 * run)
            findings += these
            if ended is not None:
                path = Path(folder) / CURRENT
                data = path.read_bytes() if path.exists() else b""
                findings.append({"kind": ended[0], "input": data, "said": ended[1]})
        _add(total, counts)
        run += 1
        left -= max(time.monotonic() - began, 1.0)
        if ended is None:
            break
        total["restarts"] += 1
    return total, findings


def _watch(
    prepare: Prepare, folder: str, seconds: float, seed: int
) -> tuple[dict[str, Any], list[dict[str, Any]], tuple[str, str] | None]:
    """Return counts, findings, and how the process ended where it should not have."""
    # Spawned: a forked process inherits torch's threads in an unusable state.
    context = multiprocessing.get_context("spawn")
    heard, sent = context.Pipe(duplex=False)
    process = context.Process(target=explore, args=(prepare, folder, seconds, seed, sent))
    process.start()
    sent.close()
    counts: dict[str, Any] = {}
    findings: list[dict[str, Any]] = []
    while True:
        if not _is_alive(process.pid, heard):
            process.kill()
            process.join()
            return counts, findings, ("hang", f"no sign of life after {HANG_S:g} s of work")
        try:
            counts, new = heard.recv()
        except EOFError:
            break
        findings += new
    process.join()
    if process.exitcode:
        return counts, findings, ("crash", f"the process ended with {process.exitcode}")
    return counts, findings, None


def _is_alive(pid: int, heard: Connection) -> bool:
    """Wait until a process reports or ends; return False where it only works, or only waits."""
    began, worked = time.monotonic(), _processor_seconds(pid)
    while not heard.poll(1.0):
        # By its own time where it can be read: on a busy machine it may not have been its turn.
        has_worked = _processor_seconds(pid) - worked > HANG_S
        if has_worked or time.monotonic() - began > STUCK_S:
            return False
    return True


def _processor_seconds(pid: int) -> float:
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:  # it has ended, or this system keeps no such file
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _add(total: dict[str, Any], counts: dict[str, Any]) -> None:
    """Add what one process did; of the greatest values, and of what was reached, keep the most."""
    for key, value in counts.items():
        is_sum = key in ("runs", "read", "refused")
        total[key] = total.get(key, 0) + value if is_sum else max(total.get(key, 0), value)


def _keep(finding: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Write a finding's input to a file and return the finding with its name."""
    folder.mkdir(parents=True, exist_ok=True)
    data = finding.pop("input")
    name = f"{finding['target'].replace(' ', '_')}-{hashlib.sha256(data).hexdigest()[:12]}.bin"
    (folder / name).write_bytes(data)
    return finding | {"file": name, "bytes": len(data)}
