"""Running a bench in parts: sections, or shares of one; what a stopped run had done it keeps."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any

from geotlm_lm.benchmarks.one_thread import threads
from geotlm_lm.benchmarks.rows import QUICK, WHOLE, Bench, Run, Section, Share
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.files import write_text_atomically
from geotlm_lm.core.process import silent
from geotlm_lm.core.record import RunRecord, commit, machine
from geotlm_lm.workers import ALONE


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
        for name, done in _measured(bench, run, only or names).items():
            sections[name] = done | {"command": command}
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
        }
        | ({} if run.workers == ALONE else {"workers": run.workers.count}),
    )


@dataclass(frozen=True)
class _Part:
    """What one worker runs at a time: a share of a section."""

    section: str
    share: str

    @property
    def file(self) -> str:
        """Name of the file that keeps what it gave."""
        return f"{self.section} {self.share}".strip().replace("/", "-") + ".json"


def _measured(bench: Bench, run: Run, names: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return sections by name, what this very commit's stopped run had of them and the rest."""
    asked = [
        one for one in bench.sections if one.name in names and (run.real or not one.needs_real)
    ]
    parts = [_Part(one.name, share) for one in asked for share in _shares(one, run)]
    folder, done = _folder(bench, run), {}
    if folder is not None:
        files = {part: folder / part.file for part in parts}
        done = {part: json.loads(path.read_text()) for part, path in files.items() if path.exists()}
    missing, is_alone = [part for part in parts if part not in done], run.workers == ALONE
    # Others are sent the name: tables hold functions that no process can be sent.
    given = (bench, run) if is_alone else (bench.name, replace(run, progress=silent, workers=ALONE))
    for part, told in run.workers.each_done(partial(_run_part, *given), missing, seen=_read(run)):
        done[part] = told
        if folder is not None:
            files[part].parent.mkdir(parents=True, exist_ok=True)
            write_text_atomically(files[part], json.dumps(told))
        if not is_alone:
            run.progress(bench.name, len(done), len(parts))
    return {
        one.name: _joined([done[part] for part in parts if part.section == one.name])
        for one in asked
    }


def _shares(section: Section, run: Run) -> Mapping[str, Share]:
    return {"": partial(section.run, run)} if section.shares is None else section.shares(run)


def _run_part(bench: Bench | str, run: Run, part: _Part) -> tuple[_Part, dict[str, Any]]:
    """Return a part and what it gave; a bench that was sent is found by its name."""
    if isinstance(bench, str):
        from geotlm_lm.benchmarks.benches import BENCHES

        bench = BENCHES[bench]
    section = bench.section(part.section)
    run.progress(f"{bench.name}: {section.title}", 0, 1)
    started = time.perf_counter()
    rows = [row.to_dict() for row in _shares(section, run)[part.share]()]
    return part, {
        "rows": rows,
        "seconds": round(time.perf_counter() - started, 1),
        "commit": commit(),
        "date": f"{datetime.now(UTC):%Y-%m-%d}",
        "processor": machine()["processor"],
    }


def _joined(told: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return a section of its shares, in order."""
    return told[0] | {
        "rows": [row for one in told for row in one["rows"]],
        "seconds": round(sum(one["seconds"] for one in told), 1),
    }


def _read(run: Run) -> list[Path]:
    return [one for one in (run.real, run.model, *run.data) if one is not None]


def _folder(bench: Bench, run: Run) -> Path | None:
    """Return where finished parts are kept; None where the code is not that of a commit."""
    at = commit()
    told = {"seed": run.seed, "real": run.real, "folder": run.folder}
    plain = Run(**told, progress=run.progress, workers=run.workers)
    if not at or at.endswith("+") or run != plain:
        return None
    asked = f"{at}-{run.seed}-{'real' if run.real else 'simulated'}"
    return run.folder / f"{bench.name}-{asked}"
