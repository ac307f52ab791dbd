"""Running a bench section by section; what a stopped run had finished is not done again."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from geotlm_lm.benchmarks.rows import QUICK, WHOLE, Bench, Row, Run, Section
from geotlm_lm.core.atomic import write_text_atomically
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.record import RunRecord, commit, machine


def run_bench(
    bench: Bench,
    run: Run,
    *,
    only: Sequence[str] = (),
    command: str = "",
    before: RunRecord | None = None,
) -> RunRecord:
    """Run the sections of a bench on one thread and return the record of them all.

    Args:
        bench: What is measured.
        run: How much, and on what.
        only: Names of sections; the others are taken from `before`. All by default.
        command: The command line, for the record.
        before: An earlier record of this bench, whose other sections are kept.

    Raises:
        UsageError: If a section is unknown.
    """
    names = [section.name for section in bench.sections]
    if unknown := [name for name in only if name not in names]:
        raise UsageError(
            f"--only '{unknown[0][:40]}' is unknown, expected one of {', '.join(names)}."
        )
    started = time.perf_counter()
    sections = dict(before.numbers["sections"]) if before is not None and only else {}
    with threads(1):
        for section in bench.sections:
            if section.name in (only or names) and (run.real or not section.needs_real):
                done = _finished_or_run(bench, section, run)
                sections[section.name] = done | {"command": command}
    return RunRecord(
        name=bench.name,
        command=command,
        seed=run.seed,
        seconds=time.perf_counter() - started,
        numbers={"sections": {name: sections[name] for name in names if name in sections}},
        config={
            "size": QUICK if run.is_quick else WHOLE,
            "real": sorted(one.name for one in run.real.iterdir() if one.is_dir())
            if run.real
            else [],
            "data": [path.name for path in run.data],
            "encoder": None if run.encoder is None else run.encoder.weights.name,
            "model": "embedded" if run.model is None else run.model.name,
            "threads": 1,
        },
    )


def rows_of(record: RunRecord, section: str) -> list[Row]:
    """Return the rows of a recorded section; none where it was not run."""
    found = record.numbers["sections"].get(section, {"rows": []})
    return [Row.from_dict(row) for row in found["rows"]]


def _finished_or_run(bench: Bench, section: Section, run: Run) -> dict[str, Any]:
    """Return a section of this very commit that a stopped run had finished, or run it."""
    kept = _place(bench, section, run)
    if kept is not None and kept.exists():
        return json.loads(kept.read_text())
    run.progress(f"{bench.name}: {section.title}", 0, 1)
    started = time.perf_counter()
    rows = [row.to_dict() for row in section.run(run)]
    done = {
        "rows": rows,
        "seconds": round(time.perf_counter() - started, 1),
        "commit": commit(),
        "processor": machine()["processor"],
    }
    if kept is not None:
        kept.parent.mkdir(parents=True, exist_ok=True)
        write_text_atomically(kept, json.dumps(done))
    return done


def _place(bench: Bench, section: Section, run: Run) -> Path | None:
    """Return where a finished section is kept; None where the code is not that of a commit."""
    at = commit()
    plain = Run(seed=run.seed, real=run.real, folder=run.folder, progress=run.progress)
    if not at or at.endswith("+") or run != plain:
        return None
    asked = f"{at}-{run.seed}-{'real' if run.real else 'simulated'}"
    return run.folder / f"{bench.name}-{asked}" / f"{section.name}.json"


@contextmanager
def threads(count: int) -> Iterator[None]:
    """Let torch and OpenCV use `count` threads each while inside."""
    import cv2
    import torch

    torch_before, cv2_before = torch.get_num_threads(), cv2.getNumThreads()
    torch.set_num_threads(count)
    cv2.setNumThreads(count)
    try:
        yield
    finally:
        torch.set_num_threads(torch_before)
        cv2.setNumThreads(cv2_before)
