"""`app` starts the page from wherever it lies, and says what is missing before it loads a model."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.running import run


def test_a_missing_toolkit_ends_with_one_sentence_and_code_7(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "gradio", None)
    assert run(capsys, "app") == (
        7,
        "",
        "The app needs gradio, which is not installed; run `pip install 'geotlm-lm[app]'`.\n",
    )


@pytest.mark.parametrize("is_served", [True, False])
def test_the_port_and_the_wish_to_serve_agents_are_handed_on(capsys, monkeypatch, is_served):
    served = []

    def serve(port, *, mcp, recordings):
        served.append((port, mcp, recordings))

    monkeypatch.setattr("app.__main__.serve", serve)
    options = ("--port", "7999", "--recordings", "here")
    run(capsys, "app", *options, *["--mcp"] * is_served)
    assert served == [(7999, is_served, Path("here"))]


def test_a_port_that_cannot_be_is_a_wrong_call(capsys):
    code, _, said = run(capsys, "app", "--port", "70000")
    assert code == 2
    assert said.startswith("Invalid value for '--port': ")


def test_the_page_started_as_a_module_takes_the_same_options():
    started = subprocess.run(
        [sys.executable, "-m", "app", "--port", "70000"], capture_output=True, text=True, timeout=60
    )
    assert started.returncode == 2
    assert started.stderr.startswith("Invalid value for '--port': ")
