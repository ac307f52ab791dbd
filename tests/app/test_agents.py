"""The functions over the Model Context Protocol, called by a real client of it."""

import asyncio
import base64
import json
import sys
from types import SimpleNamespace

import numpy as np
import pytest

gradio = pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from app import agents, ui  # noqa: E402
from app.__main__ import serve  # noqa: E402
from geotlm_lm.core.errors import MissingDependency  # noqa: E402
from tests.app.fakes import FakeAnswerer  # noqa: E402

MISSING = "--mcp needs the package mcp, which is not installed; run `pip install 'geotlm-lm[mcp]'`."


def test_a_missing_package_is_told_before_the_model_is_loaded(monkeypatch):
    monkeypatch.setitem(sys.modules, "mcp", None)
    monkeypatch.setattr("geotlm_lm.Answerer.load", lambda: pytest.fail("it was loaded"))
    with pytest.raises(MissingDependency) as caught:
        serve(mcp=True)
    assert str(caught.value) == MISSING


def test_a_toolkit_that_serves_without_it_is_not_silent():
    page = SimpleNamespace(mcp_server=False, mcp_server_obj=None, mcp_error="too old")
    with pytest.raises(MissingDependency) as caught:
        agents.speak_json(page)
    assert str(caught.value) == (
        "MCP could not be served (too old); run `pip install 'geotlm-lm[mcp]'`."
    )


def in_message(folder, level):
    frames = np.full((6, 48, 64, 3), level, np.uint8)
    frames[3:, 20:30, 20:30] += 9
    np.save(folder / "clip.npy", frames)
    return "data:;base64," + base64.b64encode((folder / "clip.npy").read_bytes()).decode()


@pytest.fixture(scope="module")
def address():
    pytest.importorskip("mcp", reason="serving agents needs mcp (extra: mcp)")
    page = ui.build(FakeAnswerer())
    yield ui.launch(page, mcp=True)
    page.close()


@pytest.fixture
def use(address):
    """Return a function that calls tools in one session and returns their texts and errors."""
    from mcp import ClientSession
    from mcp.client.streamable_http import streamable_http_client

    async def talk(calls):
        served = f"{address}{agents.PATH}"
        async with (
            streamable_http_client(served) as (read, write, _),
            ClientSession(read, write) as session,
        ):
            await session.initialize()
            if calls is None:
                return (await session.list_tools()).tools
            told = [await session.call_tool(name, given) for name, given in calls]
            return [(one.content[0].text, one.isError) for one in told]

    return lambda *calls: asyncio.run(talk(list(calls) or None))


def test_exactly_the_four_functions_are_tools_typed_and_documented(use):
    tools = {tool.name: tool for tool in use()}
    assert set(tools) == {"ask", "evidence", "compare", "simulate"}
    for tool in tools.values():
        assert "Returns: " in tool.description
        assert all(one["description"] for one in tool.inputSchema["properties"].values())
        assert set(tool.inputSchema["required"]) == set(tool.inputSchema["properties"])
    assert tools["simulate"].inputSchema["properties"]["seed"]["type"] == "integer"


def test_each_tool_answers_in_json(use, tmp_path):
    bright, dark = in_message(tmp_path, 150), in_message(tmp_path, 60)
    touch = {"object_name": "key", "depth_mm": 0.6, "twist_deg": 0.0, "slide_x_mm": 1.0}
    touch |= {"slide_y_mm": 0.0, "press_mm": 0.1, "thickness_mm": 4.0, "seed": 1}
    told = use(
        ("ask", {"clip": bright, "question": "Which way?"}),
        ("evidence", {"clip": bright}),
        ("compare", {"first": bright, "second": dark}),
        ("simulate", touch),
    )
    assert not any(is_error for _, is_error in told)
    answer, evidence, comparison, simulated = (json.loads(text) for text, _ in told)
    assert (answer["direction"], answer["query"]) == ("right", "way")
    assert (evidence["contact_share"], np.shape(evidence["contact_mask"])) == (0.5, (14, 14))
    assert comparison["relation"] == "opposite"
    assert simulated["true_motion"] == "right"


def test_a_mistake_is_one_sentence(use, tmp_path):
    clip = in_message(tmp_path, 150)
    said = use(
        ("evidence", {"clip": "/etc/passwd"}),
        ("evidence", {"clip": "http://127.0.0.1:9/clip.npz"}),
        ("evidence", {"clip": clip[:-4000]}),
        (
            "simulate",
            dict.fromkeys(("depth_mm", "twist_deg", "slide_x_mm", "slide_y_mm", "press_mm"), 0.5)
            | {"object_name": "unicorn", "thickness_mm": 4.0, "seed": 1},
        ),
    )
    assert all(is_error for _, is_error in said)
    beginnings = (
        "The clip is no upload; ",
        "The clip is no upload; ",
        "clip.npy: is cut off, ",
        "There is no shape 'unicorn'",
    )
    for (text, _), beginning in zip(said, beginnings, strict=True):
        assert text.startswith(beginning)
        assert "\n" not in text


def test_a_call_that_lacks_an_argument_names_it(use):
    ((text, is_error),) = use(("ask", {"question": "Which way?"}))
    assert is_error
    assert "'clip' is a required property" in text
