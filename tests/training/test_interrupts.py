"""Ctrl-C: worker processes end with their parent, silently."""

import os
import signal
import subprocess
import sys
import time

import pytest

from tests.process_groups import in_proc, members

pytestmark = pytest.mark.slow

WITH_WORKERS = 4
"""The command, what tracks its resources, and two workers."""

SIMULATE = """
import sys
from pathlib import Path
from geotlm_lm.training import config, train
config.write_text_atomically(Path(sys.argv[1]) / "ready", "")
from geotlm_lm.cli.main import main
main(["train", "--preset", "smoke", "--out", sys.argv[1], "--workers", "2"])
"""


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
    wait_until(lambda: (tmp_path / "ready").exists() and members(run.pid) >= WITH_WORKERS)
    yield run
    if is_alive(run.pid):
        os.killpg(run.pid, signal.SIGKILL)


@in_proc
def test_ctrl_c_while_simulating_ends_everything_with_one_sentence(simulating, tmp_path):
    os.killpg(simulating.pid, signal.SIGINT)  # as a terminal does: to every process
    out, err = simulating.communicate(timeout=60)
    assert simulating.returncode == 130
    assert out == ""
    assert err.splitlines() == [
        f"training preset smoke into {tmp_path}",
        "Stopped; files already complete are kept.",
    ]
    wait_until(lambda: not is_alive(simulating.pid))  # no worker is left behind


@in_proc
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
