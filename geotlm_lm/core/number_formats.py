"""Number formats a user may have the model run in; nothing heavy: a typo is told at once."""

from __future__ import annotations

from geotlm_lm.core.errors import UsageError

INT8 = "int8"

OFFERED = ("float32", "bfloat16", INT8)
"""Measured to err alike; bfloat16 answers in 0.90, int8 in 0.88 of float32's time
(docs/results/pareto.md)."""


def require_offered(precision: str) -> str:
    """Return the name of a number format, if it is one of `OFFERED`.

    Raises:
        UsageError: If it is not.
    """
    if precision not in OFFERED:
        raise UsageError(
            f"found precision '{str(precision)[:40]}', expected one of {', '.join(OFFERED)}; "
            f"give one of them, or leave it out."
        )
    return precision
