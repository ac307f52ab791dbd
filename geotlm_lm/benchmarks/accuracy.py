"""The accuracy bench: what the words, the probes and two rivals get right, and on which clips."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from geotlm_lm.benchmarks.amounts import AMOUNTS
from geotlm_lm.benchmarks.clips import clip_rows, clip_shares, left_out
from geotlm_lm.benchmarks.halves import HALVES, by_half, is_reported, titled
from geotlm_lm.benchmarks.judging import NEAR
from geotlm_lm.benchmarks.mixtures import MIXTURES
from geotlm_lm.benchmarks.optics import OPTICS
from geotlm_lm.benchmarks.protocols import PROTOCOLS
from geotlm_lm.benchmarks.questions import QUESTIONS
from geotlm_lm.benchmarks.reading import READING
from geotlm_lm.benchmarks.rendering import markdown, right_with_interval
from geotlm_lm.benchmarks.rows import Bench, Listing, Pivot, Row, Section
from geotlm_lm.benchmarks.tracks import TRACKS
from geotlm_lm.benchmarks.variants import GENERATED, PROBE, RIVALS

CLIPS_ABOUT = f"""\
Asked is "Which way is it turning?" or "sliding?" of sets of turns or slides, else "Which way is it
moving?". *Words* are free: any sentence may come, and one that does not parse, or is withheld,
counts as wrong; they say what is believed. Rows *of the task* choose among the two turns or the
four slides only: the *language model's slots* are what it says itself; the *linear probe* reads the
fused token; *optical flow* and *direct alignment* fit a rigid motion and learn nothing. Shares of
right answers, with 95 % intervals that resample whole objects; `*` marks words more than {NEAR:g}
below the better of these two rivals. Simulated objects were kept from training; real clips are
public GelSight Mini recordings that nothing was trained on, each also played backwards; semi-real
ones move real imprints along known paths. No two kinds are pooled. Real
objects are split once: things are chosen by *tune*, and *report* is what counts."""


def _right(row: Row) -> str:
    return right_with_interval(row) + " *" * row.detail.get("rival", {}).get("is_below", False)


def _against(row: Row) -> str:
    gain = row.detail["rival"]
    return f"{gain['difference']:+.3f} ({gain['low']:+.3f} to {gain['high']:+.3f})"


def _claimed(row: Row) -> str:
    """Return the shares of clips of which a turn and a slide are claimed."""
    cells, turned = [], row.detail.get("turned_round", {})
    for part, share in row.detail["claims"].items():
        claimed, round_too = turned.get(part, (0, 0))
        survives = f" ({round_too} of {claimed} turn round)" if claimed else ""
        cells.append(f"{part} {share:.3f}{survives}")
    return ", ".join(cells)


SHOWN_FIRST = {
    "simulated rotation": "simulated turns",
    "simulated sliding": "simulated slides",
    "real physiclear, four frames": "real turns, four frames (physiclear)",
    "real physiclear, pairs": "real turns, two frames (physiclear)",
    "real incipient_slip rotation, four frames": "real turns, gel with markers (incipient_slip)",
    "real incipient_slip sliding, four frames": "real slides, gel with markers (incipient_slip)",
}
"""Sets of clips on the first page -> what it calls them; of real ones the half that is reported."""


def clips_headline(rows: Sequence[Row]) -> str:
    """Return six sets of clips by words, probe and both rivals, each with its interval."""
    found, lines = {(row.case, row.variant): row for row in rows}, []
    methods = (GENERATED, PROBE, *RIVALS)
    for case, title in SHOWN_FIRST.items():
        reported = titled(case, "report")
        shown = reported if (reported, GENERATED) in found else case
        own = [found.get((shown, name)) for name in methods]
        if own[0] is not None:
            cells = ["-" if row is None else _right(row) for row in own]
            lines.append([title, str(own[0].count), *cells])
    header = ["clips", "n", "the model's words", "linear probe", "optical flow", "direct alignment"]
    return markdown(header, lines)


CLIPS_SECTION = Section(
    name="clips",
    title="Which way it goes",
    about=CLIPS_ABOUT,
    run=lambda run: list(clip_rows(run, HALVES)),
    views=by_half(Pivot(_right))
    | {
        "Words less the better rival, clip by clip": (
            Listing(
                {
                    "clips": lambda row: row.case,
                    "better rival": lambda row: row.detail["rival"]["name"],
                    "words less it": _against,
                    "below": lambda row: "below" * row.detail["rival"]["is_below"],
                }
            ),
            lambda row: "rival" in row.detail and is_reported(row),
        ),
        "A turn or a slide claimed where there is none": (
            Pivot(_claimed),
            lambda row: "claims" in row.detail,
        ),
        "Left out": (
            Listing({"clips": lambda row: row.case, "left out": left_out}),
            lambda row: bool(left_out(row)),
        ),
    },
    headline=clips_headline,
    shares=lambda run: clip_shares(run, HALVES),
)

ACCURACY = Bench(
    name="accuracy",
    title="Accuracy",
    about="What is right, how often, and beside what: simulated, real and published numbers apart.",
    sections=(CLIPS_SECTION, TRACKS, MIXTURES, AMOUNTS, READING, QUESTIONS, PROTOCOLS, OPTICS),
)

EVALUATION = Bench(
    name="evaluate",
    title="Answers against truth",
    about="The model's words beside linear probes and optical flow, on clips none has seen.",
    sections=(replace(CLIPS_SECTION, run=lambda run: list(clip_rows(run)), shares=None),),
)
"""The accuracy of a user's own recordings, data sets and model: nothing is split."""
