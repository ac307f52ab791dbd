"""Ctrl-C: a step is taken whole, and worker processes end with their parent, silently."""

import os
import signal
import subprocess
import sys
import time

import pytest

from geotlm_lm.training.interrupts import whole_step

SIMULATE = """
import sys
from pathlib import Path
from geotlm_lm.training import train
train.write_text_atomically(Path(sys.argv[1]) / "ready", "")
from geotlm_lm.cli.main import main
main(["train", "--preset", "smoke", "--out", sys.argv[1], "--workers", "2"])
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_waits_until_the_step_is_taken(number):
    done = []

    def step():
        with whole_step():
            signal.raise_signal(number)
            done.append("step")

    # As a command takes a request to end.
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            step()
        assert signal.getsignal(number) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGTERM, before)
    assert done == ["step"]


def test_outside_a_step_interrupts_arrive_as_ever():
    with whole_step():
        pass
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)


def test_an_error_in_a_step_is_told_as_it_is():
    with pytest.raises(ZeroDivisionError), whole_step():
        raise ZeroDivisionError
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.fixture
def simulating(tmp_path):
    """A training command whose workers are loading or simulating; no chunk is near its end."""
    run = subprocess.Popen(
        [sys.executable, "-c", SIMULATE, str(tmp_path)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    wait_until(lambda: (tmp_path / "ready").exists())
    time.sleep(2.0)
    yield run
    if is_alive(run.pid):
        os.killpg(run.pid, signal.SIGKILL)


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="needs process groups")
def test_ctrl_c_while_simulating_ends_everything_with_one_sentence(simulating, tmp_path):
    os.killpg(simulating.pid, signal.SIGINT)  # as a terminal does: to every process
    out, err = simulating.communicate(timeout=20)
    assert simulating.returncode == 130
    assert out == ""
    assert err.splitlines() == [
        f"training preset smoke into {tmp_path}",
        "Stopped; files already complete are kept.",
    ]
    wait_until(lambda: not is_alive(simulating.pid))  # no worker is left behind


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="needs process groups")
def test_workers_end_when_their_parent_is_killed(simulating):
    simulating.kill()
    simulating.communicate(timeout=60)  # returns once no worker holds its end of the pipes
    wait_until(lambda: not is_alive(simulating.pid))


def is_alive(group):
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def wait_until(is_true, seconds=60.0):
    end = time.monotonic() + seconds
    while not is_true():
        assert time.monotonic() < end
        time.sleep(0.05)
