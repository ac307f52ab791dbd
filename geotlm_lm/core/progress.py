"""How a long run tells how far it is, whoever shows it."""

from __future__ import annotations

from typing import Protocol


class Progress(Protocol):
    """Called whenever a part of a run is done."""

    def __call__(self, what: str, done: int, total: int) -> None:
        """Take in that `done` of `total` units of a stage are done.

        Args:
            what: The stage, and after a comma what may change within it, such as the loss.
            done: Units done, those of an earlier, interrupted run among them.
            total: Units of the stage.
        """


def silent(what: str, done: int, total: int) -> None:
    """Show nothing."""
