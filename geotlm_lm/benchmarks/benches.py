"""The five tables (accuracy, cost, stability, omissions, loop), and how they are run."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from typing import Any

from geotlm_lm.benchmarks.amounts import AMOUNTS, MIXTURES
from geotlm_lm.benchmarks.candidates import CANDIDATE_SECTION
from geotlm_lm.benchmarks.clips import CLIPS_SECTION, clip_rows
from geotlm_lm.benchmarks.detection import CONTACT, DETECTION
from geotlm_lm.benchmarks.harness import QUICK, WHOLE, Bench, Run, whole
from geotlm_lm.benchmarks.loop import LOOP, WATCHING
from geotlm_lm.benchmarks.omissions import SAVED
from geotlm_lm.benchmarks.pareto import COMMANDS, METHODS, SIMULATOR, STAGES
from geotlm_lm.benchmarks.protocols import PROTOCOLS
from geotlm_lm.benchmarks.reading import OWN_ANSWERS, READING
from geotlm_lm.benchmarks.stability import DAMAGE, EXTREME, NUMERICS, SCENES
from geotlm_lm.benchmarks.tracks import TRACKS
from geotlm_lm.core.errors import UsageError, choice_of
from geotlm_lm.core.process import silent
from geotlm_lm.core.record import RunRecord, commit, machine
from geotlm_lm.runs.processes import one_thread
from geotlm_lm.runs.run import (
    ALONE,
    do_parts,
    holds_json,
    load_json,
    run_folder,
    save_json,
)

Part = tuple[str, str]
"""Names of a section and of a share of it: what one worker runs at a time."""

ACCURACY = Bench(
    name="accuracy",
    title="Accuracy",
    about="What is right, how often, and beside what: simulated, real and published numbers apart.",
    sections=(
        CLIPS_SECTION,
        CANDIDATE_SECTION,
        DETECTION,
        CONTACT,
        TRACKS,
        MIXTURES,
        AMOUNTS,
        READING,
        OWN_ANSWERS,
        PROTOCOLS,
    ),
)

EVALUATION = Bench(
    name="evaluate",
    title="Answers against truth",
    about="The model's words beside linear probes and optical flow, on clips none has seen.",
    sections=(replace(CLIPS_SECTION, shares=whole(clip_rows)),),
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

CLOSED_LOOP = Bench(
    name="loop",
    title="Conditions on a running camera",
    about="A gripper stopped by what its sensor sees, and conditions waited for in recordings.",
    sections=(LOOP, WATCHING),
)

BENCHES = {bench.name: bench for bench in (ACCURACY, PARETO, STABILITY, OMISSIONS, CLOSED_LOOP)}


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
        raise UsageError(f"--only '{unknown[0][:40]}' is unknown; {choice_of(unknown[0], names)}")
    started = time.perf_counter()
    sections = dict(before.numbers["sections"]) if before is not None and only else {}
    with one_thread():
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


def _measured(bench: Bench, run: Run, names: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return sections by name; parts that a stopped run of this very commit had are kept."""
    asked = [section for section in bench.sections if section.name in names]
    parts = [(section.name, share) for section in asked for share in section.shares(run)]
    # Others are sent the name: tables hold functions that no process can be sent.
    is_alone, seen = run.workers == ALONE, [run.real, run.model, *run.data]
    sent = (bench, run) if is_alone else (bench.name, replace(run, progress=silent, workers=ALONE))
    work, seen = partial(_run_part, *sent), [path for path in seen if path is not None]
    progress = silent if is_alone else run.progress
    settings = _settings(run)
    if settings is None:
        results = {}
        for part, result in run.workers.map(work, parts, seen=seen):
            results[part] = result
            progress(bench.name, len(results), len(parts))
    else:
        folder = run.folder / bench.name
        files = [folder / f"{' '.join(part).strip().replace('/', '-')}.json" for part in parts]
        jobs = list(zip(parts, files, strict=True))
        with run_folder(folder, settings, "settings", is_replaced=True) as stamp:
            do_parts(
                bench.name,
                work,
                jobs,
                save_json,
                is_kept=holds_json,
                workers=run.workers,
                seen=[stamp, *seen],
                progress=progress,
            )
            results = {part: load_json(path) for part, path in jobs}
    sections = {}
    for section in asked:
        shares = [results[part] for part in parts if part[0] == section.name]
        sections[section.name] = shares[0] | {
            "rows": [row for share in shares for row in share["rows"]],
            "seconds": round(sum(share["seconds"] for share in shares), 1),
        }
    return sections


def _run_part(bench: Bench | str, run: Run, part: Part) -> dict[str, Any]:
    """Return the result of a part; a bench that was sent is looked up by its name."""
    bench = BENCHES[bench] if isinstance(bench, str) else bench
    section = bench.section(part[0])
    run.progress(f"{bench.name}: {section.title}", 0, 1)
    started = time.perf_counter()
    rows = [row.to_dict() for row in section.shares(run)[part[1]]()]
    return {
        "rows": rows,
        "seconds": round(time.perf_counter() - started, 1),
        "commit": commit(),
        "date": f"{datetime.now(UTC):%Y-%m-%d}",
        "processor": machine()["processor"],
    }


def _settings(run: Run) -> dict[str, Any] | None:
    """Return what decides a whole run; None where the code is not that of a commit."""
    revision = commit()
    kept = {"seed": run.seed, "real": run.real, "folder": run.folder}
    plain = Run(**kept, progress=run.progress, workers=run.workers)
    if not revision or revision.endswith("+") or run != plain:
        return None
    real = None if run.real is None else str(run.real)
    return {"commit": revision, "seed": run.seed, "real": real}
