"""A request to end closes what a command has open; afterwards the signal is the caller's again."""

import signal
import subprocess
import sys

import pytest

from geotlm_lm.cli import main

ENDLESS = """
import sys, time
from geotlm_lm.cli import main
def info():
    try:
        print("begun", flush=True)
        time.sleep({seconds})
    finally:
        print("closed", flush=True)
main.app.registered_commands[:] = []
main.app.command()(info)
main.main(["info"])
"""


def test_a_request_to_end_closes_what_is_open_and_ends_of_the_signal():
    program = [sys.executable, "-c", ENDLESS.format(seconds=60)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(program, **pipes) as running:
        assert running.stdout.readline() == "begun\n"
        running.terminate()
        out, err = running.communicate(timeout=30)
    assert (running.returncode, out, err) == (-signal.SIGTERM, "closed\n", "Stopped.\n")


def test_after_a_command_the_signal_means_what_it_did(capsys):
    before = signal.getsignal(signal.SIGTERM)
    with pytest.raises(SystemExit):
        main.main(["--version"])
    assert capsys.readouterr().out
    assert signal.getsignal(signal.SIGTERM) is before
