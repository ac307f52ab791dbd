"""The accuracy bench: what the words, the probes and optical flow get right, and on which clips."""

from __future__ import annotations

from collections.abc import Sequence

from geotlm_lm.benchmarks.amounts import AMOUNTS
from geotlm_lm.benchmarks.clips import clip_rows, left_out
from geotlm_lm.benchmarks.optics import OPTICS
from geotlm_lm.benchmarks.protocols import PROTOCOLS
from geotlm_lm.benchmarks.questions import QUESTIONS
from geotlm_lm.benchmarks.rendering import markdown, number, right_with_interval
from geotlm_lm.benchmarks.rows import Bench, Listing, Pivot, Row, Section, every
from geotlm_lm.benchmarks.variants import FLOW, GENERATED, PROBE_FREE

CLIPS_ABOUT = """\
Every clip is asked which way it goes. *Words* are free: any sentence may come, out of ten motions,
and one that does not parse, or is withheld, counts as wrong. *Ten answers scored* is the likeliest
of the ten answers, the *linear probe* reads the fused token. Rows *of the task* choose among the
two turns or the four slides only, as optical flow does. Shares of right answers, with 95 %
intervals that resample whole objects. Simulated objects were kept from training; real clips are
public GelSight Mini recordings that nothing was trained on, each also played backwards; semi-real
ones move real imprints along known paths. No two kinds are pooled."""


def _difference(row: Row) -> str:
    return "; ".join(
        f"{second} {one['difference']:+.3f} ({one['low']:+.3f} to {one['high']:+.3f})"
        for second, one in row.detail["less"].items()
    )


def _claimed(row: Row) -> str:
    claims = row.detail.get("claims_of")
    turned = "" if not claims or not claims[0] else f", {claims[1]} of {claims[0]} turn round"
    return f"{row.detail['false_directions']:.3f}{turned}"


SHOWN_FIRST = {
    "simulated rotation": "simulated turns",
    "simulated sliding": "simulated slides",
    "real physiclear, four frames": "real turns, four frames (physiclear)",
    "real physiclear, pairs": "real turns, two frames (physiclear)",
    "real incipient_slip rotation, four frames": "real turns, gel with markers (incipient_slip)",
    "real incipient_slip sliding, four frames": "real slides, gel with markers (incipient_slip)",
}
"""Sets of clips on the first page -> what it calls them."""


def clips_headline(rows: Sequence[Row]) -> str:
    """Return six sets of clips by words, probe and flow, each with its interval."""
    found = {(row.case, row.variant): row for row in rows}
    lines = []
    for case, title in SHOWN_FIRST.items():
        own = [found.get((case, name)) for name in (GENERATED, PROBE_FREE, FLOW)]
        if None not in own:
            lines.append([title, str(own[0].count), *map(right_with_interval, own)])
    header = ["clips", "n", "the model's words", "linear probe", "optical flow (fewer choices)"]
    return markdown(header, lines)


CLIPS_SECTION = Section(
    name="clips",
    title="Which way it goes",
    about=CLIPS_ABOUT,
    run=lambda run: list(clip_rows(run)),
    views={
        "": (Pivot(right_with_interval), every),
        "Less than another, clip by clip": (
            Listing(
                {
                    "clips": lambda row: row.case,
                    "variant": lambda row: row.variant,
                    "less": _difference,
                }
            ),
            lambda row: "less" in row.detail,
        ),
        "A direction claimed where there is none": (
            Pivot(_claimed),
            lambda row: "false_directions" in row.detail,
        ),
        "Left out": (
            Listing({"clips": lambda row: row.case, "left out": left_out}),
            lambda row: bool(left_out(row)),
        ),
        "Milliseconds a clip, median and 95th percentile": (
            Pivot(lambda row: f"{number(row.ms_p50, '.1f')} / {number(row.ms_p95, '.1f')}"),
            every,
        ),
    },
    headline=clips_headline,
)

ACCURACY = Bench(
    name="accuracy",
    title="Accuracy",
    about="What is right, how often, and beside what: simulated, real and published numbers apart.",
    sections=(CLIPS_SECTION, AMOUNTS, QUESTIONS, PROTOCOLS, OPTICS),
)

EVALUATION = Bench(
    name="evaluate",
    title="Answers against truth",
    about="The model's words beside linear probes and optical flow, on clips none has seen.",
    sections=(CLIPS_SECTION,),
)
"""The accuracy of a user's own recordings, data sets and model."""
