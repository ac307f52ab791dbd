"""The documentation's programs, run as they stand there against the shipped model."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

gradio = pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from app import programs_tab, ui  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/programs.md").read_text()
BLOCKS = re.findall(r"```(python|bash)\n(.*?)```", PAGE, re.DOTALL)


def example(mark, address):
    """Return the page's only block that holds a mark, for a server of ours."""
    (code,) = (text for _, text in BLOCKS if mark in text)
    assert "http://127.0.0.1:7860" in code
    return code.replace("http://127.0.0.1:7860", address.rstrip("/"))


@pytest.fixture(scope="module")
def address(answerer):
    page = ui.build(answerer)
    yield ui.launch(page)
    page.close()


@pytest.fixture(autouse=True)
def _in_the_checkout(monkeypatch):
    monkeypatch.chdir(ROOT)


def test_the_python_example_tells_the_caps_direction(address, capsys):
    exec(example("gradio_client", address), {})
    asked, turn, contact, relation, simulated = capsys.readouterr().out.splitlines()[-5:]
    assert asked == "Clockwise, in the camera image."
    assert turn.startswith("clockwise ")
    assert float(contact) > 0.05
    assert relation == "same"
    assert simulated


def test_the_shells_example_tells_it_too(address):
    if shutil.which("curl") is None:
        pytest.skip("needs curl")
    code = example("curl", address)
    done = subprocess.run(["bash", "-euc", code], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert '"text": "Clockwise, in the camera image."' in done.stdout


def test_the_agents_example_tells_it_too(answerer, capsys):
    pytest.importorskip("mcp", reason="serving agents needs mcp (extra: mcp)")
    page = ui.build(answerer)
    address = ui.launch(page, mcp=True)
    try:
        exec(example("call_tool", address), {})
        assert capsys.readouterr().out.splitlines()[-1] == "clockwise"
    finally:
        page.close()


def test_the_examples_told_on_the_page_are_the_documented_ones():
    for snippet in (programs_tab.SNIPPET, programs_tab.REST_SNIPPET, programs_tab.MCP_SNIPPET):
        assert snippet.strip() in PAGE


def test_every_promised_field_is_in_the_answer(address):
    from gradio_client import Client, handle_file

    from app import results

    client = Client(address, verbose=False)
    clip = handle_file("app/examples/hex_nut_counterclockwise.npz")
    calls = {
        "/ask": ((clip, "Which way?"), results.AnswerResult),
        "/evidence": ((clip,), results.EvidenceFields),
        "/compare": ((clip, clip), results.ComparisonResult),
        "/simulate": (("key", 0.6, 15.0, 0.4, 0.0, 0.1, 4.0, 0), results.SimulatedAnswer),
    }
    for name, (given, promised) in calls.items():
        assert set(client.predict(*given, api_name=name)) == set(promised.__annotations__)
