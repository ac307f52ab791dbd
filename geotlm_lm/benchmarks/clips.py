"""Which way does it go? Words, probes and flow on simulated, real and semi-real clips.

Every set of clips is put to all variants in turn; simulated and real clips are never pooled.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from geotlm_lm.benchmarks.cases.beyond_windows import (
    NoContactWindows,
    backwards,
    pressed_in,
    whole_recordings,
)
from geotlm_lm.benchmarks.cases.data_sets import (
    DATA_TASKS,
    DataSet,
    data_set_name,
    listed_cases,
    open_data_sets,
    pair_cases,
    tracked_pairs,
)
from geotlm_lm.benchmarks.cases.recordings import (
    by_task,
    four_frames,
    held_across,
    real_recordings,
    task_of,
    window_cases,
    without_idle_frame,
)
from geotlm_lm.benchmarks.cases.semi_real import SemiRealSlides, semi_real_held, untouched_cases
from geotlm_lm.benchmarks.cases.simulated import TASKS, SimulatedCases
from geotlm_lm.benchmarks.halves import Half, rows_of_half, titled
from geotlm_lm.benchmarks.judging import (
    Case,
    Replies,
    Variant,
    ask_all,
    claims_turned_round,
    rows_of_replies,
)
from geotlm_lm.benchmarks.rows import Row, Run, Share
from geotlm_lm.benchmarks.variants import GENERATED, RIVALS, all_variants
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.labels import SLIDES, Motion
from geotlm_lm.data.labelled_recordings import LabelledRecordings
from geotlm_lm.data.manifest import Manifest
from geotlm_lm.data.touch_table import (
    TABLE_NAME,
    read_directed,
    read_touch_table,
    read_untouched,
)

CLIPS = 300
"""Simulated clips of each task."""


class Judge:
    """Puts sets of clips to the same variants.

    Args:
        run: The model, the seed and who is told how far it is.
        variants: What is compared; words, probes and flow by default.
    """

    def __init__(self, run: Run, variants: Mapping[str, Variant] | None = None) -> None:
        self.run = run
        self.variants = all_variants(run.answerer, run.seed) if variants is None else variants

    def replies(
        self, title: str, cases: Iterable[Case], among: Sequence[Motion], total: int
    ) -> Replies:
        """Return what every variant said of every case."""

        def tell(done: int) -> None:
            self.run.progress(title, done, max(done, total))

        return ask_all(self.variants, cases, among, tell)

    def rows(
        self, title: str, replies: Replies, facts: Mapping[str, Any] | None = None
    ) -> list[Row]:
        """Return the rows of some replies."""
        seed = self.run.seed
        return rows_of_replies(title, replies, GENERATED, RIVALS, seed=seed, facts=facts)


def clip_rows(run: Run, halves: Sequence[Half | None] = (None,)) -> Iterator[Row]:
    """Yield the rows of every set of clips; arguments are those of `clip_shares`.

    Raises:
        UnreadableClip: If recordings or a data set cannot be read, or nothing was judged.
        UsageError: If two data sets have one name.
    """
    data_sets, found = open_data_sets(run.data), 0
    for share in _shares(run, halves, data_sets).values():
        for row in share():
            found += 1
            yield row
    if not found:
        left_out = [reason for one in data_sets.values() for reason in one.left_out.values()]
        raise UnreadableClip(
            f"no clip could be judged ({'; '.join(left_out[:1]) or 'none was asked for'}); give "
            f"other data."
        )


def clip_shares(run: Run, halves: Sequence[Half | None] = (None,)) -> dict[str, Share]:
    """Return what yields the rows of each source of clips; none remembers another's questions.

    Args:
        run: What is judged: `run.clips` readable simulated clips of each task (0 leaves simulation
            out), recordings of `run.real`, data sets of `run.data`.
        halves: Of the recordings, each judged apart; None for all of them.

    Raises:
        UnreadableClip: If recordings or a data set cannot be read.
        UsageError: If two data sets have one name.
    """
    return _shares(run, halves, open_data_sets(run.data))


def _shares(
    run: Run, halves: Sequence[Half | None], data_sets: Mapping[str, DataSet]
) -> dict[str, Share]:
    clips = run.size(CLIPS, 6) if run.clips is None else run.clips
    shares: dict[str, Share] = {}
    for task in TASKS if clips else ():
        shares[f"simulated {task}"] = partial(_simulated, run, task, clips)
    for name, real in real_recordings(run.real).items():
        for half in halves:
            shares[titled(f"real {name}", half)] = partial(_recordings, run, name, real, half)
    for name, data_set in data_sets.items():
        shares[f"data {name}"] = partial(_data_set, run, data_set)
    return shares


def _simulated(run: Run, task: str, clips: int) -> Iterator[Row]:
    """Yield a simulated task."""
    judge, cases = Judge(run), SimulatedCases(task, clips, run.seed)
    title = f"simulated {task}"
    replies = judge.replies(title, cases, cases.among, clips)
    yield from judge.rows(title, replies, {"unreadable_left_out": cases.unreadable})


def _data_set(run: Run, data_set: DataSet) -> Iterator[Row]:
    yield from data_set_rows(Judge(run), data_set)


def _recordings(run: Run, name: str, real: LabelledRecordings, half: Half | None) -> Iterator[Row]:
    """Yield one folder's windows task by task, and what else it can be asked."""
    judge = Judge(run)
    for part, whole in by_task(real).items():
        rows = rows_of_half(whole.rows, half)
        own = replace(whole, rows=rows[:: judge.run.size(1, len(rows) or 1)])
        yield from _windows(judge, f"real {name}{part}", own, half)
        for aside, change in (
            ("no idle frame", without_idle_frame),
            ("turned by a quarter", held_across),
        ):
            title = titled(f"real {name}{part}, {aside}", half)
            shown, total = four_frames(own, change), 2 * len(own.rows)
            yield from judge.rows(title, judge.replies(title, shown, task_of(own.rows), total))
    if not judge.run.is_quick:
        yield from _beyond_windows(judge, name, real, half)


def _windows(judge: Judge, name: str, own: LabelledRecordings, half: Half | None) -> Iterator[Row]:
    """Yield four frames and pairs, both ways; each frame rate apart.

    Cameras set to another rate often have another gain and zoom.
    """
    among, total = task_of(own.rows), 4 * len(own.rows)
    replies = judge.replies(titled(name, half), window_cases(own), among, total)
    facts = {"labels_left_out": dict(own.skipped)}
    rates = sorted({case.tags["fps"] for case in replies.cases})
    for frames, title in (("four", f"{name}, four frames"), ("pair", f"{name}, pairs")):
        part = replies.where(frames=frames)
        yield from judge.rows(titled(title, half), part, facts)
        for rate in rates if len(rates) > 1 else ():
            yield from judge.rows(titled(f"{title}, {rate} fps", half), part.where(fps=rate))


def _beyond_windows(
    judge: Judge, name: str, real: LabelledRecordings, half: Half | None
) -> Iterator[Row]:
    """Yield whole recordings, semi-real slides, and clips without a direction."""
    table, seed = real.folder / TABLE_NAME, judge.run.seed
    directed, touched, untouched = (
        rows_of_half(read(table), half)
        for read in (read_directed, read_touch_table, read_untouched)
    )
    if directed:
        title, whole = titled(f"real {name}, whole recordings", half), whole_recordings(directed)
        replies = judge.replies(title, whole, task_of(directed), len(directed))
        yield from judge.rows(title, replies)
    if touched:
        title, slides = titled(f"semi-real {name}, sliding", half), SemiRealSlides(touched, seed)
        replies = judge.replies(title, slides, SLIDES, len(slides))
        yield from judge.rows(title, replies, {"cut_off_left_out": slides.cut_off})
    for title, cases in (
        (f"real {name}, untouched", partial(untouched_cases, touched)),
        (f"real {name}, no visible contact", NoContactWindows(untouched)),
        (f"real {name}, pressed in", partial(pressed_in, touched)),
        (f"semi-real {name}", partial(semi_real_held, touched, seed)),
    ):
        total = len(untouched if isinstance(cases, NoContactWindows) else touched)
        yield from _without_direction(judge, title, cases, total, half)


def _without_direction(
    judge: Judge,
    title: str,
    cases: Callable[[], Iterator[Case]],
    total: int,
    half: Half | None,
) -> Iterator[Row]:
    """Yield the rows of clips without a direction, each also played backwards, by how held."""
    whole = titled(title, half)
    said = judge.replies(whole, cases(), tuple(Motion), total)
    facts = {"too_short_left_out": getattr(cases, "too_short", 0)}
    again = backwards(cases())
    turned = judge.replies(f"{whole}, backwards", again, tuple(Motion), total)
    for held in sorted({case.tags.get("held", "") for case in said.cases}):
        tags = {"held": held} if held else {}
        claims = claims_turned_round(said.where(**tags), turned.where(**tags))
        shown = titled(f"{title}, {held}" if held else title, half)
        for row in judge.rows(shown, said.where(**tags), facts):
            yield replace(row, detail={**row.detail, "turned_round": claims[row.variant]})


def data_set_rows(judge: Judge, data_set: DataSet) -> Iterator[Row]:
    """Yield a public data set's two tasks, and each sensor of a manifest apart."""
    name = data_set_name(data_set)
    for task, among in DATA_TASKS.items():
        title = f"{name}, {task}"
        if isinstance(data_set, Manifest):
            cases, facts = listed_cases(data_set, among), {}
            total = sum(row.motion in among for row in data_set.rows)
        else:
            pairs, told = tracked_pairs(data_set, task)
            cases, facts = pair_cases(pairs), {"pairs": told}
            total = sum(len(own) for _, own in pairs)
        replies = judge.replies(title, cases, among, total)
        reasons = list(data_set.left_out.values())  # files are found unusable as they are read
        facts |= {"files_left_out": len(reasons), "first_left_out": reasons[:1]}
        yield from judge.rows(title, replies, facts)
        sensors = sorted({case.tags.get("sensor", "") for case in replies.cases})
        for sensor in sensors if len(sensors) > 1 else ():
            yield from judge.rows(f"{title}, sensor {sensor}", replies.where(sensor=sensor))


LEFT_OUT = {
    "unreadable_left_out": "whose images do not show the motion",
    "cut_off_left_out": "whose imprint is faint or cut off by the border",
    "too_short_left_out": "shorter than a window",
    "files_left_out": "whose files cannot be used",
}
"""Number in a row's detail -> clips that it counts."""


def left_out(row: Row) -> str:
    """Return how many clips were left out of a set and why; "" where none were."""
    parts = [f"{row.detail[key]} {what}" for key, what in LEFT_OUT.items() if row.detail.get(key)]
    labels = row.detail.get("labels_left_out", {})
    return "; ".join(parts + [f"{count} labelled {label}" for label, count in labels.items()])
