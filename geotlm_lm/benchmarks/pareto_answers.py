"""What an answer costs: every way to name a motion, and its stages.

Times run from the clip in memory to the motion. The model's read-outs of one precision share a
perception, as several questions about one clip do; each counts its time in full.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

import cv2
import torch

from geotlm_lm.answering import Answerer
from geotlm_lm.backbone.imprint import imprint_of
from geotlm_lm.backbone.motions import motions_of
from geotlm_lm.backbone.stem import measure_clip
from geotlm_lm.benchmarks.cases.recordings import (
    by_task,
    real_recordings,
    task_of,
    window_cases,
)
from geotlm_lm.benchmarks.cases.simulated import TASKS, SimulatedCases
from geotlm_lm.benchmarks.halves import rows_of_half
from geotlm_lm.benchmarks.judging import Case, Variant, ask_all, rows_of_replies, timed
from geotlm_lm.benchmarks.pareto_processes import QUESTION, in_turn, long_recording, timed_rows
from geotlm_lm.benchmarks.rows import Row, Run
from geotlm_lm.benchmarks.statistics import milliseconds
from geotlm_lm.benchmarks.variants import (
    Read,
    after_perceiving,
    perceived_once,
    question_for,
)
from geotlm_lm.checkpoint import reading_of
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.numbers import seed_for
from geotlm_lm.motion.measured import measured
from geotlm_lm.precision import if_runnable
from geotlm_lm.probe.rigid_alignment import RigidAlignment
from geotlm_lm.probe.rigid_flow import RigidFlow

PRECISIONS = ("float32", "bfloat16", "int8")

RIVALS = {
    "optical flow, ultrafast": RigidFlow(preset=cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST),
    "optical flow, fast": RigidFlow(),
    "optical flow, medium": RigidFlow(preset=cv2.DISOPTICAL_FLOW_PRESET_MEDIUM),
    "direct alignment": RigidAlignment(),
}
WORDS = "words"

FOUR, PAIRS = "four frames", "pairs"

CaseSet = tuple[str, tuple[Motion, ...], list[Case]]
"""Title of cases of one source and number of frames, the motions in question, the cases."""


def method_rows(run: Run) -> Iterator[Row]:
    """Yield one row per set of clips and method."""
    asked = {name: timed(rival.predict) for name, rival in RIVALS.items()}
    for precision in run.size(PRECISIONS, (PRECISIONS[0], PRECISIONS[2])):
        bundle = if_runnable(run.answerer.bundle, precision)
        if bundle is not None:  # this machine can run it
            suffix = "" if precision == PRECISIONS[0] else f", {precision}"
            asked |= model_variants(type(run.answerer)(bundle), suffix)
    for shown in case_sets(run):
        run.progress(f"methods: {shown[0]}", 0, 1)
        yield from rows_in_turn(asked, shown, run.size(3, 1), run.seed)


def rows_in_turn(
    asked: Mapping[str, Variant], shown: CaseSet, repeats: int, seed: int
) -> list[Row]:
    """Put every case to every method in turn, `repeats` rounds."""
    title, among, cases = shown
    runs = in_turn({title: partial(ask_all, asked, cases, among)}, repeats)[title]
    rows = []
    for row in rows_of_replies(title, runs[0][0], seed=seed):
        ms = [one.milliseconds for said, _ in runs for one in said.replies[row.variant]]
        rows.append(replace(row, detail={}, **milliseconds(ms)))
    return with_front(rows)


def with_front(rows: Sequence[Row]) -> list[Row]:
    """Return rows of one case that tell whether none beats them in both error and median time."""

    def is_on_front(own: Row) -> bool:
        better = [row for row in rows if row.error <= own.error and row.ms_p50 <= own.ms_p50]
        return all((one.error, one.ms_p50) == (own.error, own.ms_p50) for one in better)

    return [replace(row, detail={**row.detail, "is_on_front": is_on_front(row)}) for row in rows]


def model_variants(answerer: Answerer, suffix: str) -> dict[str, Variant]:
    """Return the model's read-outs, all of one perception; `suffix` ends their names."""
    perceive, probe = perceived_once(answerer), answerer.bundle.model.probe
    reads: dict[str, Read] = {
        "linear probe": lambda seen, among: probe.predict(seen.perception.fused_token, among)[0],
        WORDS: lambda seen, among: answerer.ask(seen, question_for(among)).direction,
    }
    return {name + suffix: after_perceiving(perceive, read) for name, read in reads.items()}


def case_sets(run: Run) -> Iterator[CaseSet]:
    """Yield simulated and, if there are any, real clips: four frames, and the first and last."""
    for task in ("rotation", "sliding"):
        seed = seed_for(run.seed, "runtime", task)
        cases = list(SimulatedCases(task, run.size(60, 2), seed))
        yield (f"simulated {task}, {FOUR}", TASKS[task], cases)
        yield (f"simulated {task}, {PAIRS}", TASKS[task], _pairs(cases))
    for name, found in real_recordings(run.real).items():
        for part, real in by_task(found).items():
            rows = rows_of_half(real.rows, "report")
            few = rows[:: -(-len(rows) // run.size(40, 1)) or 1]
            title, among = f"real {name}{part}, report", task_of(real.rows)
            cases = list(window_cases(replace(real, rows=few)))
            four, pair = ([x for x in cases if x.tags["frames"] == n] for n in ("four", "pair"))
            yield (f"{title}, {FOUR}", among, four)
            # A recorded pair is shown as a, a, b, b.
            yield (f"{title}, {PAIRS}", among, _pairs(pair))


def _pairs(cases: Sequence[Case]) -> list[Case]:
    return [replace(case, clip=case.clip.select([0, FRAME_COUNT - 1])) for case in cases]


def runtime_clips(run: Run, count: int) -> list[Clip]:
    """Return simulated turns of four frames with a background."""
    seed = seed_for(run.seed, "runtime", "rotation")
    return [one.clip for one in SimulatedCases("rotation", count, seed)]


def stage_rows(run: Run) -> Iterator[Row]:
    """Yield the milliseconds of every stage of an answer, each alone on the same clip."""
    (clip,), bundle = runtime_clips(run, 1), run.answerer.bundle
    model, speaker, recording = bundle.model, bundle.speaker, long_recording(clip)
    imprint, stem = imprint_of(clip), measure_clip(clip)
    inputs, motions = (torch.from_numpy(x)[None] for x in (stem.inputs, stem.motions.numbers()))
    tokens = model.backbone.encode_inputs(inputs)
    perception, said = model.fuse(tokens), bundle.grammar.options_for("direction")[0]
    token, geometry = perception.fused_token, perception.geometry
    reading = reading_of(token, bundle.motion(measured(inputs, motions, geometry, token)))
    ways = {
        "track of 125 frames": lambda: run.answerer.track(recording),
        "stem": lambda: measure_clip(clip),
        "of it: the imprint": lambda: imprint_of(clip),
        "of it: rigid motions": lambda: motions_of(imprint),
        "backbone": lambda: model.backbone.encode_inputs(inputs),
        "DGR and fused token": lambda: model.fuse(tokens),
        "linear probe": lambda: model.probe.predict(token),
        "belief": lambda: bundle.motion(measured(inputs, motions, geometry, token)),
        "question read": lambda: bundle.reader.read(QUESTION),
        "language model: answer, token by token": lambda: speaker.generate(reading, [QUESTION]),
        "language model: one answer checked": lambda: speaker.would_write(
            reading[0], QUESTION, said
        ),
    }
    yield from timed_rows("one clip", ways, run.size(30, 1))
