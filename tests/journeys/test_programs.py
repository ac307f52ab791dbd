"""The documentation's programs, run as they stand there against the shipped model."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

gradio = pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from app import ui  # noqa: E402
from app.guards import SENTENCE  # noqa: E402
from tests.track.recordings import there_and_back  # noqa: E402

pytestmark = pytest.mark.page

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
    asked, turn, contact, relation, behind, simulated = capsys.readouterr().out.splitlines()[-6:]
    assert asked == "It turns clockwise, about 12 degrees, in the camera image."
    assert turn.startswith("clockwise ")
    assert float(contact) > 0.05
    assert relation == "opposite"
    assert behind == "clockwise"  # a nut that turns counterclockwise, seen from its own side
    assert simulated


def test_the_shells_example_tells_it_too(address):
    if shutil.which("curl") is None:
        pytest.skip("needs curl")
    code = example("curl", address)
    done = subprocess.run(["bash", "-euc", code], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    # A cap that turns clockwise, seen from its own side.
    assert '"direction": "counterclockwise"' in done.stdout


def test_the_agents_example_tells_tracks_and_looks(answerer, capsys, tmp_path, monkeypatch):
    pytest.importorskip("mcp", reason="serving agents needs mcp (extra: mcp)")
    monkeypatch.chdir(tmp_path)
    page = ui.build(answerer)
    address = ui.launch(page, mcp=True)
    try:
        exec(example("call_tool", address), {})
    finally:
        page.close()
    way, track = capsys.readouterr().out.splitlines()[:2]
    assert way == "counterclockwise"  # a cap that turns clockwise, seen from its own side
    assert track.startswith("4 [")
    assert (tmp_path / "overlay.png").read_bytes().startswith(b"\x89PNG")


def test_the_limits_are_stated_alike_in_the_documents():
    assert SENTENCE in " ".join(PAGE.split())


def test_every_promised_field_is_in_the_answer(address):
    from gradio_client import Client, handle_file

    from app import schema as results
    from app.api import SHORT_ANSWER

    client = Client(address, verbose=False)
    clip = handle_file("app/examples/hex_nut_counterclockwise.npz")
    calls = {
        "/recordings": ((), results.Listing),
        "/track": ((clip,), results.TrackResult),
        "/evidence": ((clip,), results.EvidenceFields),
        "/compare": ((clip, clip), results.ComparisonResult),
        "/simulate": (("key", 0.6, 15.0, 0.4, 0.0, 0.1, 4.0, 0), results.SimulatedAnswer),
        "/picture": ((clip,), results.PictureResult),
    }
    assert set(client.predict(clip, "Which way?", api_name="/ask")) == set(SHORT_ANSWER)
    whole = client.predict(clip, "Which way?", details=True, api_name="/ask")
    assert set(whole) == set(results.AnswerResult.__annotations__)
    for name, (given, promised) in calls.items():
        assert set(client.predict(*given, api_name=name)) == set(promised.__annotations__)


def test_a_real_recording_is_listed_tracked_asked_about_and_drawn(answerer, tmp_path):
    """The round trip of an agent with the shipped model, on a turn there and back."""
    from app.tools import Tool

    whole = there_and_back()
    np.savez(tmp_path / "turn.npz", frames=whole.frames, fps=whole.fps)
    tools: dict[str, Tool] = {tool.name: tool for tool in ui.build(answerer, tmp_path).tools}
    (listed,) = tools["recordings"].call({})["recordings"]
    name = {"recording": listed["name"]}
    track = tools["track"].call(name)
    assert [one["way"] for one in track["events"] if one["event"] == "turn"][:1] == ["clockwise"]
    asked = (
        "When did it turn clockwise?",
        "How far did it turn, there and back added up?",
        "Is anything touching the gel?",
    )
    answers = [tools["ask"].call(name | {"question": one, "details": True}) for one in asked]
    assert [one["abstained"] for one in answers] == [False] * 3
    assert answers[1]["amount"]["low"] < 50 < answers[1]["amount"]["high"]
    assert tools["picture"].call(name | {"shows": "timeline"})["height_px"] > 100
