"""Conditions that `watch` waits for, and what is done when one holds."""

from __future__ import annotations

import json
import math
import shlex
import shutil
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import typer

from geotlm_lm.core.errors import NotReached, TimedOut, UsageError

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer
    from geotlm_lm.answering.monitor import Monitor, Verdict
    from geotlm_lm.core.frame_spec import FrameSpec


@dataclass(frozen=True)
class Conditions:
    """What is waited for."""

    until: Annotated[
        list[str] | None,
        typer.Option(
            help="End with exit code 0 once this holds: 'it has turned 30 degrees clockwise', 'it "
            "slips by more than 0.5 mm', 'contact is lost'. Of several the first ends it."
        ),
    ] = None
    while_: Annotated[
        list[str] | None,
        typer.Option("--while", help="End with exit code 0 once this holds no more."),
    ] = None
    every: Annotated[
        list[str] | None,
        typer.Option(help="Print each time that this begins to hold, counted from the last time."),
    ] = None
    run: Annotated[
        str | None,
        typer.Option(
            metavar="COMMAND",
            help="Start this each time that --every holds, without a shell; it reads the verdict "
            "as JSON from its input.",
        ),
    ] = None
    sure: Annotated[float, typer.Option(help="Probability with which a condition has to hold.")] = (
        0.95
    )
    lasting: Annotated[float, typer.Option("--for", help="Seconds for which it has to hold.")] = 0.0
    timeout: Annotated[
        float | None,
        typer.Option(help="Seconds of the stream after which --until ends with exit code 8."),
    ] = None

    @property
    def is_any(self) -> bool:
        """Whether anything is waited for."""
        return bool(self.until or self.while_ or self.every)

    @property
    def is_ending(self) -> bool:
        """Whether the command ends once something holds."""
        return bool(self.until or self.while_)

    def require(self) -> None:
        """Refuse options that do not go together, and a command that is not there.

        Raises:
            UsageError: Then.
        """
        if self.run is not None and not self.every:
            raise UsageError("--run starts a command whenever --every holds; give --every as well.")
        if self.timeout is not None and not self.is_ending:
            raise UsageError("--timeout ends --until and --while; give one of them as well.")
        if self.timeout is not None and not self.timeout > 0:
            raise UsageError(f"--timeout {self.timeout:g} was given, expected more than 0 seconds.")
        if self.run is not None and not shutil.which(self.command[0]):
            raise UsageError(
                f"--run: there is no program '{self.command[0]}' to be started; give its path."
            )

    @property
    def command(self) -> list[str]:
        """The words of --run.

        Raises:
            UsageError: If a quotation mark is left open, or there is none.
        """
        try:
            words = shlex.split(self.run or "")
        except ValueError as error:
            raise UsageError(f"--run '{self.run}' cannot be split into words: {error}.") from error
        if not words:
            raise UsageError("--run was given no command.")
        return words

    def monitors(self, answerer: Answerer, frame: FrameSpec) -> Waiting:
        """Return what waits, each condition as it was understood.

        Raises:
            UsageError: If a condition is refused.
        """
        from geotlm_lm.answering.monitor import Monitor

        tracker, options = answerer.tracker(), {"sure": self.sure, "lasting_s": self.lasting}
        ending = [
            Monitor(
                tracker, answerer.condition(text, frame=frame, is_negated=is_negated), **options
            )
            for texts, is_negated in ((self.until, False), (self.while_, True))
            for text in texts or ()
        ]
        repeated = [
            Monitor(tracker, answerer.condition(text, frame=frame), since="last", **options)
            for text in self.every or ()
        ]
        return Waiting(
            answerer, ending, repeated, self.command if self.run else [], self.timeout or math.inf
        )


class Waiting:
    """Looks at every frame whether what is waited for holds.

    Args:
        answerer: Tracks, and understood the conditions.
        ending: What ends the command.
        repeated: What is told each time.
        command: Started each time; none if empty.
        timeout_s: Seconds of the stream after which waiting ends.
    """

    def __init__(
        self,
        answerer: Answerer,
        ending: list[Monitor],
        repeated: list[Monitor],
        command: list[str],
        timeout_s: float,
    ) -> None:
        self.answerer, self._ending, self._repeated = answerer, ending, repeated
        self._command, self._timeout_s = command, timeout_s
        self._started: list[subprocess.Popen] = []
        self._begin_s: float | None = None
        self.tracker = (ending or repeated)[0].tracker
        self.is_met = False

    def notes(self) -> Iterator[str]:
        """Yield how each condition was read."""
        for monitor in self._ending:
            yield f"Waiting until {monitor.condition.restated}."
        for monitor in self._repeated:
            yield f"Telling each time that {monitor.condition.restated}."

    def look(self, time_s: float, number: int, *, as_json: bool) -> bool:
        """Judge the frame that was tracked last; return whether waiting is over.

        Raises:
            TimedOut: If it took too long.
        """
        self._begin_s = time_s if self._begin_s is None else self._begin_s
        for monitor in (*self._ending, *self._repeated):
            verdict = monitor.judged(time_s, number)
            if verdict.is_new:
                _print(monitor, verdict, as_json=as_json)
                if monitor in self._repeated:
                    self._start(monitor, verdict)
                self.is_met |= monitor in self._ending
        if self.is_met:
            return True
        if time_s - self._begin_s > self._timeout_s:
            raise TimedOut(
                f"{self._unmet()} did not hold within {self._timeout_s:g} s; wait longer by "
                f"--timeout, or look at what was seen by leaving --until out."
            )
        return False

    def require_met(self) -> None:
        """Refuse that the stream ended before what should end it.

        Raises:
            NotReached: Then.
        """
        for each in self._started:
            each.wait()
        if self._ending and not self.is_met:
            raise NotReached(f"{self._unmet()} did not hold before the recording ended.")

    def _unmet(self) -> str:
        return "That " + ", or that ".join(each.condition.restated for each in self._ending)

    def _start(self, monitor: Monitor, verdict: Verdict) -> None:
        if not self._command:
            return
        text = json.dumps({"condition": monitor.condition.text} | verdict.to_dict())
        try:
            started = subprocess.Popen(self._command, stdin=subprocess.PIPE, text=True)  # noqa: S603
        except OSError as error:
            raise UsageError(f"--run: {self._command[0]} does not start: {error}.") from error
        try:
            with started.stdin as stream:
                stream.write(text)
        except BrokenPipeError:  # it reads nothing
            pass
        self._started = [each for each in (*self._started, started) if each.poll() is None]


def _print(monitor: Monitor, verdict: Verdict, *, as_json: bool) -> None:
    if as_json:
        line = {"type": "verdict", "condition": monitor.condition.text} | verdict.to_dict()
        print(json.dumps(line), flush=True)
        return
    seen = " seen from the sensor" if verdict.is_relative else ""
    print(
        f"{verdict.time_s:.2f} s, frame {verdict.number}: {monitor.condition.restated}{seen}, "
        f"{verdict.probability:.1%} sure, {verdict.latency_ms:.0f} ms after the frame. "
        f"{verdict.text}",
        flush=True,
    )
