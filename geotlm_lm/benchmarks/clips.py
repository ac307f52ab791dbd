"""Which way does it go? Words, probes and flow on simulated, real and semi-real clips.

Every set of clips is put to all variants in turn; simulated and real clips are never pooled.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from geotlm_lm.benchmarks.cases import (
    HALVES,
    TASKS,
    DataSet,
    Half,
    by_half,
    by_task,
    held_across,
    is_reported,
    listed_cases,
    open_data_sets,
    pair_cases,
    real_recordings,
    rows_of_half,
    simulated_cases,
    task_of,
    titled,
    tracked_pairs,
    window_cases,
)
from geotlm_lm.benchmarks.harness import Listing, Pivot, Row, Run, Section, Share
from geotlm_lm.benchmarks.imprints import semi_real_slides
from geotlm_lm.benchmarks.judging import NEAR, Case, Replies, Variant, ask_all, rows_of_replies
from geotlm_lm.benchmarks.rendering import markdown, right_with_interval
from geotlm_lm.benchmarks.variants import GENERATED, LEANING, PROBE, RIVALS, all_variants
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.labels import SLIDES, Motion
from geotlm_lm.data.labelled_recordings import LabelledRecordings
from geotlm_lm.data.manifest import Manifest
from geotlm_lm.data.touch_table import TABLE_NAME, read_touch_table

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer

CLIPS = 300
"""Simulated clips of each task."""

LEFT_OUT = {
    "unreadable_left_out": "whose images do not show the motion",
    "cut_off_left_out": "whose imprint is faint or cut off by the border",
    "files_left_out": "whose files cannot be used",
}
"""Number in a row's detail -> clips that it counts."""

SHOWN_FIRST = {
    "simulated rotation": "simulated turns",
    "simulated sliding": "simulated slides",
    "real physiclear, four frames": "real turns, four frames (physiclear)",
    "real physiclear, pairs": "real turns, two frames (physiclear)",
    "real incipient_slip rotation, four frames": "real turns, gel with markers (incipient_slip)",
    "real incipient_slip sliding, four frames": "real slides, gel with markers (incipient_slip)",
}
"""Sets of clips on the first page -> their titles there; of real ones the half that is reported."""


VariantsOf = Callable[["Answerer", int], Mapping[str, Variant]]


def clip_rows(run: Run, halves: Sequence[Half | None] = (None,)) -> list[Row]:
    """Return the rows of every set of clips.

    Raises:
        UnreadableClip: If recordings or a data set cannot be read, or nothing was judged.
    """
    data_sets = open_data_sets(run.data)
    rows = [row for share in clip_shares(run, halves, data_sets).values() for row in share()]
    if not rows:
        reasons = [reason for own in data_sets.values() for reason in own.left_out.values()]
        raise UnreadableClip(
            f"no clip could be judged ({'; '.join(reasons[:1]) or 'none was asked for'}); give "
            f"other data."
        )
    return rows


def clip_shares(
    run: Run,
    halves: Sequence[Half | None],
    data_sets: Mapping[str, DataSet],
    tasks: Iterable[str] = tuple(TASKS),
    variants_of: VariantsOf = all_variants,
) -> dict[str, Share]:
    """Return what yields the rows of each source of clips, none of which depends on another.

    Sources are `run.clips` readable simulated clips of each task (0 leaves simulation out), each of
    the `halves` of the recordings of `run.real` (None: all of them), and data sets. `variants_of`
    makes what they are put to from the model and the seed.
    """
    clips = run.size(CLIPS, 6) if run.clips is None else run.clips
    shares: dict[str, Share] = {}
    for task in tasks if clips else ():
        shares[f"simulated {task}"] = partial(_simulated, run, variants_of, task, clips)
    for name, real in real_recordings(run.real).items():
        for half in halves:
            shares[titled(f"real {name}", half)] = partial(
                _recordings, run, variants_of, name, real, half
            )
    for name, data_set in data_sets.items():
        shares[f"data {name}"] = partial(data_set_rows, run, name, data_set)
    return shares


class Judge:
    """Puts sets of clips to the same variants: words, probes and flow by default."""

    def __init__(self, run: Run, variants: Mapping[str, Variant] | None = None) -> None:
        self.run = run
        self.variants = all_variants(run.answerer, run.seed) if variants is None else variants

    def ask(self, title: str, cases: Iterable[Case], among: Sequence[Motion], most: int) -> Replies:
        """Return the replies of every variant to at most about `most` cases."""

        def tell(done: int) -> None:
            self.run.progress(title, done, max(done, most))

        return ask_all(self.variants, cases, among, tell)

    def rows(
        self, title: str, replies: Replies, facts: Mapping[str, Any] | None = None
    ) -> list[Row]:
        """Return the rows of some replies."""
        return rows_of_replies(title, replies, LEANING, RIVALS, seed=self.run.seed, facts=facts)


def _simulated(run: Run, variants_of: VariantsOf, task: str, clips: int) -> Iterator[Row]:
    judge = Judge(run, variants_of(run.answerer, run.seed))
    title, left_out = f"simulated {task}", Counter(unreadable_left_out=0)
    cases = simulated_cases(task, clips, run.seed, left_out)
    yield from judge.rows(title, judge.ask(title, cases, TASKS[task], clips), left_out)


def _recordings(
    run: Run, variants_of: VariantsOf, name: str, real: LabelledRecordings, half: Half | None
) -> Iterator[Row]:
    """Yield a folder's windows task by task, and its semi-real clips."""
    judge = Judge(run, variants_of(run.answerer, run.seed))
    for part, whole in by_task(real).items():
        rows = rows_of_half(whole.rows, half)
        own = replace(whole, rows=rows[:: run.size(1, len(rows) or 1)])
        yield from _windows(judge, f"real {name}{part}", own, half)
    touched = rows_of_half(read_touch_table(real.folder / TABLE_NAME), half)
    if run.is_quick or not touched:
        return
    title, left_out = titled(f"semi-real {name}, sliding", half), Counter(cut_off_left_out=0)
    slides = semi_real_slides(touched, run.seed, left_out)
    yield from judge.rows(title, judge.ask(title, slides, SLIDES, 2 * len(touched)), left_out)


def _windows(judge: Judge, name: str, own: LabelledRecordings, half: Half | None) -> Iterator[Row]:
    """Yield four frames and pairs, both ways, and as a sensor without an idle frame or held across.

    Frame rates are told apart: cameras set to another rate often have another gain and zoom.
    """
    among, count = task_of(own.rows), len(own.rows)
    replies = judge.ask(titled(name, half), window_cases(own), among, 4 * count)
    facts = {"labels_left_out": dict(own.skipped)}
    rates = sorted({case.tags["fps"] for case in replies.cases})
    for frames, title in (("four", f"{name}, four frames"), ("pair", f"{name}, pairs")):
        part = replies.where(frames=frames)
        yield from judge.rows(titled(title, half), part, facts)
        for rate in rates if len(rates) > 1 else ():
            yield from judge.rows(titled(f"{title}, {rate} fps", half), part.where(fps=rate))
    shown_as = {
        # As one that starts in contact: each method has to guess the idle gel.
        "no idle frame": lambda case: replace(case, clip=replace(case.clip, background=None)),
        "turned by a quarter": held_across,
    }
    for aside, shown in shown_as.items():
        title = titled(f"{name}, {aside}", half)
        cases = (shown(case) for case in window_cases(own) if case.tags["frames"] == "four")
        yield from judge.rows(title, judge.ask(title, cases, among, 2 * count))


def data_set_rows(
    run: Run, name: str, data_set: DataSet, variants: Mapping[str, Variant] | None = None
) -> Iterator[Row]:
    """Yield a public data set's two tasks, and each sensor of a manifest apart."""
    judge = Judge(run, variants)
    for task in ("rotation", "sliding"):
        title, among = f"{name}, {task}", TASKS[task]
        if isinstance(data_set, Manifest):
            cases, facts = listed_cases(data_set, among), {}
            total = sum(row.motion in among for row in data_set.rows)
        else:
            pairs, rule = tracked_pairs(data_set, task)
            cases, facts = pair_cases(pairs), {"pairs": rule}
            total = sum(len(own) for _, own in pairs)
        replies = judge.ask(title, cases, among, total)
        reasons = list(data_set.left_out.values())  # files turn out unusable as they are read
        facts |= {"files_left_out": len(reasons), "first_left_out": reasons[:1]}
        yield from judge.rows(title, replies, facts)
        sensors = sorted({case.tags.get("sensor", "") for case in replies.cases})
        for sensor in sensors if len(sensors) > 1 else ():
            yield from judge.rows(f"{title}, sensor {sensor}", replies.where(sensor=sensor))


def left_out(row: Row) -> str:
    """Return how many clips were left out of a set and why; "" where none were."""
    parts = [f"{row.detail[key]} {what}" for key, what in LEFT_OUT.items() if row.detail.get(key)]
    labels = row.detail.get("labels_left_out", {})
    return "; ".join(parts + [f"{count} labelled {label}" for label, count in labels.items()])


def _right(row: Row) -> str:
    return right_with_interval(row) + " *" * row.detail.get("rival", {}).get("is_below", False)


def _against(row: Row) -> str:
    gain = row.detail["rival"]
    return f"{gain['difference']:+.3f} ({gain['low']:+.3f} to {gain['high']:+.3f})"


def _claimed(row: Row) -> str:
    return ", ".join(f"{part} {share:.3f}" for part, share in row.detail["claims"].items())


def clips_headline(rows: Sequence[Row]) -> str:
    """Return six sets of clips by words, leaning, probe and both rivals, each with its interval."""
    by_name, lines = {(row.case, row.variant): row for row in rows}, []
    for case, title in SHOWN_FIRST.items():
        reported = titled(case, "report")
        shown = reported if (reported, GENERATED) in by_name else case
        own = [by_name.get((shown, name)) for name in (GENERATED, LEANING, PROBE, *RIVALS)]
        if own[0] is not None:
            cells = ["-" if row is None else _right(row) for row in own]
            lines.append([title, str(own[0].count), *cells])
    methods = ("the model's words", "its leaning", "linear probe", "optical flow")
    return markdown(["clips", "n", *methods, "direct alignment"], lines)


_RIVALRY = {
    "clips": "case",
    "better rival": lambda row: row.detail["rival"]["name"],
    "leaning less it": _against,
    "below": lambda row: "below" * row.detail["rival"]["is_below"],
}

CLIPS_SECTION = Section(
    name="clips",
    title="Which way it goes",
    about=f"""\
Asked is "Which way is it turning?" or "sliding?" of sets of turns or slides, else "Which way is it
moving?". *Words* are free: any sentence may come, and one that does not parse, or is withheld,
counts as wrong; they say what is believed. Rows *of the task* choose among the two turns or the
four slides only, whether or not anything is told: the *belief* by what it leans to; the *language
model's slots* are what it says itself; the *linear probe* reads the
fused token; *optical flow* and *direct alignment* fit a rigid motion and learn nothing. Shares of
right answers, with 95 % intervals that resample whole objects; `*` marks a leaning that is
below the better of these two rivals by more than {NEAR:g} and one clip. Simulated objects were kept
from training; real clips are public GelSight Mini recordings that nothing was trained on, each also
played backwards; semi-real ones move real imprints along known paths. No two kinds are pooled. Real
objects are split once: things are chosen by *tune*, and *report* is what counts.""",
    shares=lambda run: clip_shares(run, HALVES, open_data_sets(run.data)),
    views=by_half(Pivot(_right))
    | {
        "The belief's leaning less the better rival, clip by clip": Listing(
            _RIVALRY, lambda row: "rival" in row.detail and is_reported(row)
        ),
        "A turn or a slide claimed where there is none": Pivot(
            _claimed, shows=lambda row: "claims" in row.detail
        ),
        "Left out": Listing({"clips": "case", "left out": left_out}, shows=left_out),
    },
    headline=clips_headline,
)
