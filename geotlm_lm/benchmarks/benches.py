"""The four tables (accuracy, cost, stability, omissions), and how they are run."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any

from geotlm_lm.benchmarks.amounts import AMOUNTS, MIXTURES
from geotlm_lm.benchmarks.clips import CLIPS_SECTION, clip_rows
from geotlm_lm.benchmarks.harness import QUICK, WHOLE, Bench, Run, Section, Share, threads
from geotlm_lm.benchmarks.omissions import SAVED
from geotlm_lm.benchmarks.pareto import COMMANDS, METHODS, SIMULATOR, STAGES
from geotlm_lm.benchmarks.protocols import PROTOCOLS
from geotlm_lm.benchmarks.questions import QUESTIONS, READING
from geotlm_lm.benchmarks.stability import DAMAGE, EXTREME, NUMERICS, SCENES
from geotlm_lm.benchmarks.tracks import TRACKS
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.files import write_text_atomically
from geotlm_lm.core.process import silent
from geotlm_lm.core.record import RunRecord, commit, machine
from geotlm_lm.workers import ALONE

Part = tuple[str, str]
"""Names of a section and of a share of it: what one worker runs at a time."""

ACCURACY = Bench(
    name="accuracy",
    title="Accuracy",
    about="What is right, how often, and beside what: simulated, real and published numbers apart.",
    sections=(CLIPS_SECTION, TRACKS, MIXTURES, AMOUNTS, READING, QUESTIONS, PROTOCOLS),
)

EVALUATION = Bench(
    name="evaluate",
    title="Answers against truth",
    about="The model's words beside linear probes and optical flow, on clips none has seen.",
    sections=(replace(CLIPS_SECTION, run=clip_rows, shares=None),),
)
"""The accuracy of a user's own recordings, data sets and model: nothing is split."""

PARETO = Bench(
    name="pareto",
    title="Error against run time and memory",
    about="What a smaller error costs in time and memory. Times compare within a table alone.",
    sections=(METHODS, STAGES, COMMANDS, SIMULATOR),
)

STABILITY = Bench(
    name="stability",
    title="Stability",
    about="What becomes of damaged, extreme and stiff inputs, and how firm the numbers are.",
    sections=(DAMAGE, EXTREME, SCENES, NUMERICS),
)

OMISSIONS = Bench(
    name="omissions",
    title="What is left out",
    about="What a question, a command or a scene does not need does not run.",
    sections=(SAVED,),
)

BENCHES = {bench.name: bench for bench in (ACCURACY, PARETO, STABILITY, OMISSIONS)}


def run_bench(
    bench: Bench,
    run: Run,
    *,
    only: Sequence[str] = (),
    command: str = "",
    before: RunRecord | None = None,
) -> RunRecord:
    """Run the sections of a bench on one thread and return the record of them all.

    `only` names sections (all by default); the others are kept as an earlier record `before` has
    them. `command` is the command line, for the record.

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
    folders = run.real.iterdir() if run.real else ()
    return RunRecord(
        name=bench.name,
        command=command,
        seed=run.seed,
        seconds=time.perf_counter() - started,
        numbers={"sections": {name: sections[name] for name in names if name in sections}},
        config={
            "size": QUICK if run.is_quick else WHOLE,
            "real": sorted(folder.name for folder in folders if folder.is_dir()),
            "data": [path.name for path in run.data],
            "encoder": None if run.encoder is None else run.encoder.weights.name,
            "model": "embedded" if run.model is None else run.model.name,
            "threads": 1,
        }
        | ({} if run.workers == ALONE else {"workers": run.workers.count}),
    )


def _measured(bench: Bench, run: Run, asked: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return sections by name; parts that a stopped run of this very commit had are kept."""
    sections = [section for section in bench.sections if section.name in asked]
    parts = [(section.name, share) for section in sections for share in _shares(section, run)]
    folder, is_alone = _folder(bench, run), run.workers == ALONE
    files: dict[Part, Path] = {}
    if folder is not None:
        names = {part: " ".join(part).strip().replace("/", "-") for part in parts}
        files = {part: folder / f"{name}.json" for part, name in names.items()}
    done = {part: json.loads(path.read_text()) for part, path in files.items() if path.exists()}
    # Others are sent the name: tables hold functions that no process can be sent.
    sent = (bench, run) if is_alone else (bench.name, replace(run, progress=silent, workers=ALONE))
    paths = [path for path in (run.real, run.model, *run.data) if path is not None]
    missing = [part for part in parts if part not in done]
    for part, result in run.workers.each_done(partial(_run_part, *sent), missing, seen=paths):
        done[part] = result
        if part in files:
            files[part].parent.mkdir(parents=True, exist_ok=True)
            write_text_atomically(files[part], json.dumps(result))
        if not is_alone:
            run.progress(bench.name, len(done), len(parts))
    measured = {}
    for section in sections:
        own = [done[part] for part in parts if part[0] == section.name]
        measured[section.name] = own[0] | {
            "rows": [row for result in own for row in result["rows"]],
            "seconds": round(sum(result["seconds"] for result in own), 1),
        }
    return measured


def _shares(section: Section, run: Run) -> Mapping[str, Share]:
    return {"": partial(section.run, run)} if section.shares is None else section.shares(run)


def _run_part(bench: Bench | str, run: Run, part: Part) -> tuple[Part, dict[str, Any]]:
    """Return a part and its result; a bench that was sent is looked up by its name."""
    bench = BENCHES[bench] if isinstance(bench, str) else bench
    section = bench.section(part[0])
    run.progress(f"{bench.name}: {section.title}", 0, 1)
    started = time.perf_counter()
    rows = [row.to_dict() for row in _shares(section, run)[part[1]]()]
    return part, {
        "rows": rows,
        "seconds": round(time.perf_counter() - started, 1),
        "commit": commit(),
        "date": f"{datetime.now(UTC):%Y-%m-%d}",
        "processor": machine()["processor"],
    }


def _folder(bench: Bench, run: Run) -> Path | None:
    """Return where finished parts are kept; None where the code is not that of a commit."""
    revision = commit()
    kept = {"seed": run.seed, "real": run.real, "folder": run.folder}
    plain = Run(**kept, progress=run.progress, workers=run.workers)
    if not revision or revision.endswith("+") or run != plain:
        return None
    source = "real" if run.real else "simulated"
    return run.folder / f"{bench.name}-{revision}-{run.seed}-{source}"
