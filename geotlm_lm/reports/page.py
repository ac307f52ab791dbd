"""How long a person waits at the page, as a block of the README."""

from __future__ import annotations

from collections.abc import Sequence

from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.tables import markdown, provenance

ROWS = {
    "server_s": "from the command until the server replies",
    "model_s": "from the command until a program that asks at once has its first answer",
    "page_s": "from the address until the page and its examples stand",
    "first_word_s": "from the click until an answer's first word, server warm",
    "last_word_s": "until its last",
}
"""Keys of a tour's numbers -> what the page says of them."""


def page_times(record: RunRecord) -> str:
    """Return the waiting times of a tour, and what twenty at once got, as Markdown."""
    numbers = record.numbers
    rows = [[title, *_told(numbers[key])] for key, title in ROWS.items()]
    users = numbers["users"]
    right = users["users"] - users["wrong"]
    return "\n\n".join(
        [
            markdown(("seconds", "median", "least to most"), rows),
            f"{users['users']} programs that asked at once had their answers after "
            f"{users['all_s']:.1f} s (median of one {users['median_s']:.1f} s); {right} of them "
            f"were word for word what each gets alone.",
            provenance(record),
        ]
    )


def _told(seconds: Sequence[float]) -> tuple[str, str]:
    return f"{seconds[len(seconds) // 2]:.2f}", f"{seconds[0]:.2f}-{seconds[-1]:.2f}"
