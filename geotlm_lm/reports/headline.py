"""The few rows of an evaluation that a first page shows; the whole of it is in `tables`."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

from geotlm_lm.core.labels import DIRECTED, Motion
from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.facts import SHARE_OF_A_TABLE
from geotlm_lm.reports.markdown import markdown
from geotlm_lm.reports.tables import provenance

SHORT_NAMES = {
    "language model, words": "words",
    "language model, words, unseen wordings": "words, unseen wordings",
    "language model, words or lean": "words or lean",
    "language model, scored, all motions": "scored",
    "linear probe on z, all motions": "probe on z",
    "language model, scored": "scored*",
    "linear probe on z": "probe on z*",
    "linear probe on c": "probe on c*",
    "optical flow + rigid fit": "optical flow*",
}
"""Method -> column title, in this order; a star where it chooses among the task's motions only."""

WORDS = "language model, words"

TURNED_ROUND = "of these, the opposite when played backwards"

_FINE_SHARE = re.compile(r", (pairs, .*|\d+ fps|sensor .*)$")

_ASIDE = re.compile(
    r", (no idle frame|no visible contact|pressed in|held or pressed|unsteady hand"
    r"|whole recordings|turned by a quarter)$"
)
"""Tables that get no column of their own where tables stand side by side."""


def accuracy_headline(record: RunRecord) -> str:
    """Return one row per table and one column per method, the interval of the words beside it."""
    tables = {t: x for t, x in record.numbers["tables"].items() if not _FINE_SHARE.search(t)}
    methods = _in_order(name for table in tables.values() for name in table["methods"])
    rows = [
        [title, str(table["clips"])]
        + [_accuracy(table["methods"].get(name)) for name in methods]
        + [_interval(table["methods"].get(WORDS))]
        for title, table in tables.items()
    ]
    header = ["clips", "n", *(SHORT_NAMES.get(name, name) for name in methods), "words, 95 %"]
    return markdown(header, rows) + "\n\n" + provenance(record)


def difference_headline(record: RunRecord) -> str:
    """Return one row per pair of methods and one column per table: paired differences."""
    tables = _whole_tables(record)
    pairs = _in_order(
        (one["first"], one["second"]) for table in tables.values() for one in table["differences"]
    )
    rows = [
        [_pair_title(pair), *(_difference(table, pair) for table in tables.values())]
        for pair in pairs
    ]
    return markdown(["difference, 95 %", *tables], rows) + "\n\n" + provenance(record)


def false_claim_headline(record: RunRecord) -> str:
    """Return how often a direction is claimed where none is, a row per table with such clips.

    Below a table whose clips were also played backwards stands how many claims turned round with
    the clip.
    """
    tables = {
        title: table
        for title, table in record.numbers["tables"].items()
        if any(own["false_claim_rate"] is not None for own in table["methods"].values())
    }
    methods = _in_order(name for table in tables.values() for name in table["methods"])
    rows = []
    for title, table in tables.items():
        claimed = [_claimed(table["methods"].get(name)) for name in methods]
        rows.append([title, str(_undirected(table)), *claimed])
        if any(own["directions"] for own in table.get("claims", {}).values()):
            turned = [_turned_round(table["claims"].get(name)) for name in methods]
            rows.append([TURNED_ROUND, "", *turned])
    header = ["clips without a direction", "n", *(SHORT_NAMES.get(name, name) for name in methods)]
    return markdown(header, rows) + "\n\n" + provenance(record)


def time_headline(record: RunRecord) -> str:
    """Return one row per method and one column per table: median and 95th percentile."""
    tables = _whole_tables(record)
    methods = _in_order(name for table in tables.values() for name in table["methods"])
    rows = [
        [SHORT_NAMES.get(name, name), *(_time(x["methods"].get(name)) for x in tables.values())]
        for name in methods
    ]
    return markdown(["ms per clip, median / p95", *tables], rows) + "\n\n" + provenance(record)


def _whole_tables(record: RunRecord) -> dict[str, dict[str, Any]]:
    tables = record.numbers["tables"].items()
    return {
        title: table
        for title, table in tables
        if not (SHARE_OF_A_TABLE.search(title) or _ASIDE.search(title))
    }


def _in_order(names: Iterable[Any]) -> list[Any]:
    """Return each name once: those with a short name in its order, then the others as met."""
    order = list(SHORT_NAMES)
    once = dict.fromkeys(names)
    return sorted(once, key=lambda name: order.index(name) if name in order else len(order))


def _pair_title(pair: tuple[str, str]) -> str:
    return " less ".join(SHORT_NAMES.get(name, name) for name in pair)


def _undirected(table: dict[str, Any]) -> int:
    return sum(n for motion, n in table["truths"].items() if Motion(motion) not in DIRECTED)


def _claimed(scores: dict[str, Any] | None) -> str:
    rate = None if scores is None else scores["false_claim_rate"]
    return "-" if rate is None else f"{rate:.3f}"


def _turned_round(claims: dict[str, int] | None) -> str:
    return (
        "-"
        if not claims or not claims["directions"]
        else "{turned_round} of {directions}".format(**claims)
    )


def _accuracy(scores: dict[str, Any] | None) -> str:
    return "-" if scores is None else f"{scores['accuracy']:.3f}"


def _interval(scores: dict[str, Any] | None) -> str:
    return "-" if scores is None else "{:.3f}-{:.3f}".format(*scores["interval"])


def _difference(table: dict[str, Any], pair: tuple[str, str]) -> str:
    for one in table["differences"]:
        if (one["first"], one["second"]) == pair:
            return f"{one['difference']:+.3f} ({one['low']:+.3f} to {one['high']:+.3f})"
    return "-"


def _time(scores: dict[str, Any] | None) -> str:
    return "-" if scores is None else f"{scores['ms_median']:.1f} / {scores['ms_p95']:.1f}"
