"""A step is taken whole, and children run in one thread without interrupts."""

import os
import signal
import subprocess
import sys

import pytest

from geotlm_lm.core.process import THREAD_VARIABLES, one_thread_in_children, uninterrupted_step


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_waits_until_the_step_is_taken(number):
    done = []

    def step():
        with uninterrupted_step():
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


def test_children_started_inside_use_one_thread_and_nothing_stays_changed(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    before = dict(os.environ)
    program = f"import os; print([os.environ[name] for name in {THREAD_VARIABLES}])"
    with one_thread_in_children():
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.strip() == "['1', '1', '1']"
    assert dict(os.environ) == before
