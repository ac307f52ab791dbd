"""One thing that was looked at: what was measured, what it means, what to do."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

Verdict = Literal["fine", "limit", "fault", "unknown"]
"""Nothing to do; nothing to do, but answers are less good; to repair; cannot be told."""


@dataclass(frozen=True)
class Finding:
    """What is known about one side of a recording.

    Args:
        subject: What was looked at, such as "frame rate".
        verdict: What comes of it.
        measured: In words, with units.
        means: For the answers; "" where all is fine.
        advice: Which option or fact to set, or what to change; "" likewise.
    """

    subject: str
    verdict: Verdict
    measured: str
    means: str = ""
    advice: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Return it for JSON."""
        return asdict(self)

    def lines(self) -> list[str]:
        """Return it as one line, and one each for what it means and what to do."""
        head = f"{self.verdict:<8}{self.subject}: {self.measured}"
        return [head, *(f"{'':<8}{one}" for one in (self.means, self.advice) if one)]


def judged(subject: str, measured: str, means: str, advice: str, *, is_fault: bool) -> Finding:
    """Return a finding that is a fault, with what it means, or fine, without."""
    if is_fault:
        return Finding(subject, "fault", measured, means, advice)
    return Finding(subject, "fine", measured)
