"""What an answer costs: every way to name a motion, its stages, batches, language models.

Times run from the clip in memory to the motion. The model's read-outs of one precision share a
perception, as several questions about one clip do; each counts its time in full.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import islice
from pathlib import Path
from statistics import mean

import cv2
import torch

from geotlm_lm.answering import Answerer, four_frames_with_background
from geotlm_lm.backbone.contrast_equalisation import equalised_motions
from geotlm_lm.backbone.stem import measure_clip
from geotlm_lm.benchmarks.cases.recordings import RealCases, by_task, real_cases
from geotlm_lm.benchmarks.cases.simulated import MOST_TRIES, TASKS
from geotlm_lm.benchmarks.judging import Case, Variant, ask_all, rows_of_replies, timed
from geotlm_lm.benchmarks.pareto_processes import QUESTION, in_turn, long_recording, timed_rows
from geotlm_lm.benchmarks.rows import Row, Run
from geotlm_lm.benchmarks.running import threads
from geotlm_lm.benchmarks.statistics import milliseconds
from geotlm_lm.benchmarks.variants import Read, after_perceiving, most_probable, perceived_once
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import FRAME_COUNT
from geotlm_lm.core.grouping import mean_by_group
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.core.seeding import generator_for, seed_for
from geotlm_lm.data.questions import questions_for
from geotlm_lm.language.decoder import LanguageSize
from geotlm_lm.language.generation import Speaker
from geotlm_lm.precision import if_runnable
from geotlm_lm.probe.rigid_flow import RigidFlow
from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS, TRAINING_OBJECTS
from geotlm_lm.simulation.series import simulate_series
from geotlm_lm.training.examples import MOTIONS
from geotlm_lm.training.language import LanguageTraining, train_language

PRECISIONS = ("float32", "bfloat16", "int8")

FLOWS = {
    "optical flow, ultrafast": RigidFlow(preset=cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST),
    "optical flow, fast": RigidFlow(),
    "optical flow, medium": RigidFlow(preset=cv2.DISOPTICAL_FLOW_PRESET_MEDIUM),
}
WORDS = "words"

FOUR, PAIRS = "four frames", "pairs"

SIZES = {
    "64 wide, 2 layers": LanguageSize(width=64, layers=2, heads=2, mlp=172),
    "128 wide, 4 layers (ships)": LanguageSize(),
    "256 wide, 4 layers": LanguageSize(width=256, heads=8, mlp=688),
}

CaseSet = tuple[str, tuple[Motion, ...], list[Case]]
"""Title of cases of one source and number of frames, the motions in question, the cases."""


def method_rows(run: Run) -> Iterator[Row]:
    """Yield one row per set of clips and method."""
    asked = {name: timed(flow.predict) for name, flow in FLOWS.items()}
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
    perceive, score, probe = perceived_once(answerer), answerer.score, answerer.bundle.model.probe
    reads: dict[str, Read] = {
        "linear probe": lambda seen, among: probe.predict(seen.perception.fused_token, among)[0],
        "ten answers scored": lambda seen, among: most_probable(score(seen, QUESTION), among),
        WORDS: lambda seen, among: answerer.ask(seen, QUESTION).direction,
    }
    return {name + suffix: after_perceiving(perceive, read) for name, read in reads.items()}


def simulated(task: str, count: int, seed: int) -> list[Case]:
    """Return `count` readable clips of a task, of objects kept from training."""
    tries, motions = MOST_TRIES * count, TASKS[task]
    series = simulate_series(seed, tries, objects=EVERYDAY_OBJECTS, motions=motions)
    readable = islice((one for one in series if one.label.is_readable), count)
    names = ((one, one.object_name) for one in readable)
    return [Case(one.clip, one.label.motion, name, name, {}) for one, name in names]


def case_sets(run: Run) -> Iterator[CaseSet]:
    """Yield simulated and, if there are any, real clips: four frames, and the first and last."""
    for task in ("rotation", "sliding"):
        cases = simulated(task, run.size(60, 2), seed_for(run.seed, "runtime", task))
        yield (f"simulated {task}, {FOUR}", TASKS[task], cases)
        yield (f"simulated {task}, {PAIRS}", TASKS[task], _pairs(cases))
    for name, found in ({} if run.real is None else real_cases(run.real)).items():
        for part, real in by_task(found).items():
            rows = real.recordings.rows
            few = rows[:: -(-len(rows) // run.size(40, 1))]
            cases = list(RealCases(replace(real.recordings, rows=few)))
            four, pair = ([x for x in cases if x.tags["frames"] == n] for n in ("four", "pair"))
            yield (f"real {name}{part}, {FOUR}", real.among, four)
            # A recorded pair is shown as a, a, b, b.
            yield (f"real {name}{part}, {PAIRS}", real.among, _pairs(pair))


def _pairs(cases: Sequence[Case]) -> list[Case]:
    return [replace(case, clip=case.clip.select([0, FRAME_COUNT - 1])) for case in cases]


def runtime_clips(run: Run, count: int) -> list[Clip]:
    """Return simulated turns of four frames with a background."""
    cases = simulated("rotation", count, seed_for(run.seed, "runtime", "rotation"))
    return [one.clip for one in cases]


def stage_rows(run: Run) -> Iterator[Row]:
    """Yield the milliseconds of every stage of an answer, each alone on the same clip."""
    (clip,), bundle = runtime_clips(run, 1), run.answerer.bundle
    model, speaker, recording = bundle.model, bundle.speaker, long_recording(clip)
    seen, _, images = measure_clip(clip)
    inputs = torch.from_numpy(seen)[None]
    tokens = model.backbone.encode_inputs(inputs)
    token, options = model.fuse(tokens).fused_token, bundle.grammar.options_for("direction")
    ways = {
        "choose 4 of 125 frames": lambda: four_frames_with_background(recording),
        "stem: residual, flow, alignment": lambda: measure_clip(clip),
        "backbone": lambda: model.backbone.encode_inputs(inputs),
        "DGR and fused token": lambda: model.fuse(tokens),
        "linear probe": lambda: model.probe.predict(token),
        "how far: motions of evened images": lambda: equalised_motions(images),
        "language model: answer, token by token": lambda: speaker.generate(token, [QUESTION]),
        "language model: ten answers weighed": lambda: speaker.weigh(token[0], QUESTION, options),
    }
    yield from timed_rows("one clip", ways, run.size(30, 1))


def batch_rows(run: Run) -> Iterator[Row]:
    """Yield milliseconds per clip of each work and precision, by threads and size of batch."""
    sizes, repeats = run.size((1, 8, 64), (1, 2)), run.size(3, 1)
    works = {"optical flow, fast": lambda batch: [RigidFlow().fit(clip) for clip in batch]}
    for precision in PRECISIONS:
        bundle = if_runnable(run.answerer.bundle, precision)
        if bundle is not None:  # this machine can run it
            works[f"perceived, {precision}"] = bundle.model.perceive
            works[f"words, {precision}"] = partial(_spoken, bundle)
    clips = runtime_clips(run, sizes[-1])
    for count in run.size((1, 2), (1,)):
        with threads(count):
            for size in sizes:
                title = f"batch {size}, {count} thread{'s' * (count > 1)}"
                ways = {name: partial(work, clips[:size]) for name, work in works.items()}
                yield from timed_rows(title, ways, repeats, size)


def _spoken(bundle: Bundle, batch: list[Clip]) -> list[str]:
    tokens = bundle.model.perceive(batch).fused_token
    return bundle.speaker.generate(tokens, [QUESTION] * len(batch))


def size_rows(run: Run) -> Iterator[Row]:
    """Yield one row per size of language model, all trained alike on one frozen perception."""
    learned = perceived(run, TRAINING_OBJECTS, run.size(2_000, 20))
    asked = perceived(run, EVERYDAY_OBJECTS, run.size(200, 10))
    steps, batch = run.size((400, 32), (3, 4))
    speakers = {}
    for name, size in list(SIZES.items())[: run.size(None, 1)]:
        run.progress(f"language model, {name}", 0, 1)
        config = LanguageTraining(steps=steps, batch=batch, seed=run.seed, size=size)
        with tempfile.TemporaryDirectory() as folder:
            speakers[name] = train_language(*learned, config=config, folder=Path(folder))
    token = asked[0][:1]
    ways = {name: partial(one.generate, token, [QUESTION]) for name, one in speakers.items()}
    for row in timed_rows("everyday objects", ways, run.size(60, 1)):
        speaker = speakers[row.variant]
        error = error_by_type(speaker, *asked, run.seed)
        detail = {"parameters": sum(one.numel() for one in speaker.model.parameters())}
        yield replace(row, count=len(asked[1]), error=error, detail=detail)


def perceived(
    run: Run, objects: Sequence[str], count: int
) -> tuple[torch.Tensor, list[MotionLabel]]:
    """Return fused tokens (n, d) and labels of the readable ones of `count` simulated clips."""
    seed = seed_for(run.seed, "sizes", objects[0])
    made = simulate_series(seed, count, objects=objects, motions=MOTIONS)
    perceive = run.answerer.bundle.model.perceive
    found = [(perceive([x.clip]).fused_token, x.label) for x in made if x.label.is_readable]
    return torch.cat([token for token, _ in found]), [label for _, label in found]


def error_by_type(
    speaker: Speaker, tokens: torch.Tensor, labels: Sequence[MotionLabel], seed: int
) -> float:
    """Return the mean over the types of questions of the share of answers that are not the truth.

    One question of every type is asked about every clip; any sentence may come.
    """
    rngs = [generator_for(seed, "scoring", "seen", row) for row in range(len(labels))]
    drawn = [questions_for(label, rng) for label, rng in zip(labels, rngs, strict=True)]
    asked = [(row, one) for row, questions in enumerate(drawn) for one in questions]
    # Questions of one type are of like length: the padding of a batch stays short.
    asked.sort(key=lambda pair: int(pair[1].type_id.removeprefix("T")))
    told_of = tokens[[row for row, _ in asked]]
    said = speaker.generate(told_of, [one.question for _, one in asked])
    wrong = [text != one.answer for text, (_, one) in zip(said, asked, strict=True)]
    return mean(mean_by_group(wrong, [one.type_id for _, one in asked]).values())
