"""Processes started inside see one thread; the environment is as before afterwards."""

import os
import subprocess
import sys

from geotlm_lm.core.process import THREAD_VARIABLES, one_thread_in_children


def test_children_started_inside_use_one_thread_and_nothing_stays_changed(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    before = dict(os.environ)
    program = f"import os; print([os.environ[name] for name in {THREAD_VARIABLES}])"
    with one_thread_in_children():
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.strip() == "['1', '1', '1']"
    assert dict(os.environ) == before
