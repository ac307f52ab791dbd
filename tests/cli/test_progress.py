"""How far a command is goes to stderr, in the shape that fits where stderr leads."""

import io
import os
import pty
import subprocess
import sys

import pytest

from geotlm_lm.cli.progress import ProgressBars, ProgressLines


def lines_of(capsys, reports, unit="clips"):
    times = iter([0.0, *(time for time, *_ in reports)])
    show = ProgressLines(unit, clock=lambda: next(times))
    for _, *report in reports:
        show(*report)
    printed = capsys.readouterr()
    assert printed.out == ""
    return printed.err.splitlines()


def test_a_line_comes_at_most_every_two_seconds_and_at_each_end(capsys):
    reports = [(0.5, "a", 1, 9), (1.9, "a", 2, 9), (2.1, "a", 3, 9), (2.2, "a", 9, 9)]
    assert lines_of(capsys, [*reports, (2.3, "b", 4, 4)], "") == [
        "a: 3 of 9, 1.2/s, 5 s left",
        "a: 9 of 9, 4.7/s",
        "b: 4 of 4",
    ]


def test_the_rate_counts_from_the_first_report(capsys):
    reports = [(10.0, "simulated", 64, 164), (12.0, "simulated", 128, 164)]
    assert lines_of(capsys, [*reports, (15.0, "simulated", 164, 164)]) == [
        "simulated: 64 of 164 clips",
        "simulated: 164 of 164 clips, 20.0/s",
    ]
    together = [(10.0, "simulated", 64, 128), (10.001, "simulated", 128, 128)]
    assert lines_of(capsys, together)[-1] == "simulated: 128 of 128 clips"


def test_what_changes_within_a_stage_does_not_begin_another(capsys):
    reports = [(0.0, "train, loss 2.0", 0, 10), (5.0, "train, loss 1.0", 10, 10)]
    assert lines_of(capsys, reports, "steps") == ["train, loss 1.0: 10 of 10 steps, 2.0/s"]


def test_a_terminal_shows_a_bar_for_every_stage_and_gets_its_cursor_back():
    stream = io.StringIO()
    stream.isatty = lambda: True
    show = ProgressBars(stream)
    show("simulate [1]", 5, 10)  # brackets are text and no markup
    show("simulate [1]", 10, 10)
    show("train, loss 0.5", 1, 3)
    show.close()
    shown = stream.getvalue()
    assert "simulate [1]" in shown
    assert "10/10" in shown
    assert "train, loss 0.5" in shown
    assert "1/3" in shown
    show.close()  # once more does no harm


PROGRAM = """
import sys
from geotlm_lm.cli.progress import progress_on_stderr
show = progress_on_stderr()
for done in range(4):
    show("simulated", done, 3)
print("rich" in sys.modules)
"""


@pytest.mark.parametrize("is_terminal", [False, True])
def test_rich_is_loaded_for_a_terminal_only(is_terminal):
    theirs, ours = os.pipe() if not is_terminal else pty.openpty()
    command = [sys.executable, "-c", PROGRAM]
    narrow = os.environ | {"COLUMNS": "60"}  # all of it fits the terminal's buffer
    done = subprocess.run(
        command, stdout=subprocess.PIPE, stderr=ours, text=True, check=True, env=narrow
    )
    os.close(ours)
    shown = os.read(theirs, 65536).decode()
    os.close(theirs)
    assert done.stdout == f"{is_terminal}\n"
    assert (shown == "simulated: 3 of 3 clips\n") != is_terminal
    assert ("3/3" in shown) == is_terminal
