"""The page: its tabs, and what stands above them; each tab has its own file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .agents import PATH, AgentServer, require_mcp
from .budget import keep_messages_counted
from .busy_status import BusyStatus
from .error_display import MODEL_LINE, gradio, tell_progress
from .limits import AT_ONCE, QUEUE, UPLOAD_BYTES
from .message_limit import MessageLimit
from .no_addresses import NoAddresses, refuse_addresses
from .own_names import OWN_NAMES, OwnNamesOnly
from .session_order import keep_session_order
from .turns import AnswererInTurns, Turns

if TYPE_CHECKING:
    from pathlib import Path

    from geotlm_lm import Answerer

NAME_EMPTY = """() => {
    const name = () => document.querySelectorAll('.empty[aria-label]:not([role])')
        .forEach(one => one.setAttribute('role', 'img'));
    new MutationObserver(name).observe(document.body, {childList: true, subtree: true});
    name();
}"""
"""Gives a picture that is not there yet a role: the toolkit labels it without one."""

HEAD = (
    "<h1>geotlm-lm</h1> <p>Ask a camera-based touch sensor, in plain language, how the touched "
    "object moves.</p>"
)


def build(answerer: Answerer, recordings: Path | None = None) -> Any:
    """Return the page (a `gradio.Blocks`), not yet served; its `tools` are what programs call.

    Args:
        answerer: The model.
        recordings: Folder of recordings that programs may name; None for none.

    Raises:
        MissingDependency: If gradio is not installed.
    """
    gr = gradio()
    from . import (
        ask_tab,
        benchmark_tab,
        compare_tab,
        live_tab,
        programs_tab,
        session_files,
        simulate_tab,
    )

    answerer = AnswererInTurns(answerer, Turns(tell_progress))
    tools = _tools(answerer, recordings)

    # Without analytics nothing leaves the machine, and the page starts offline without a wait.
    with gr.Blocks(
        title="geotlm-lm", analytics_enabled=False, delete_cache=session_files.DELETE_CACHE
    ) as page:
        gr.HTML(HEAD, elem_classes=["page-head"], apply_default_css=False)
        with gr.Tab("Ask"):
            ask_tab.build(answerer, page)
        with gr.Tab("Compare"):
            compare_tab.build(answerer)
        with gr.Tab("Live"):
            live_tab.build(answerer)
        with gr.Tab("Simulate"):
            simulate_tab.build(answerer)
        with gr.Tab("Benchmark"):
            benchmark_tab.build()
        with gr.Tab("API"):
            programs_tab.build(tools)
        session_files.connect(page, [one for one in page.blocks.values() if type(one) is gr.File])
        page.load(None, js=NAME_EMPTY, api_visibility="private")
    refuse_addresses(page)
    page.tools = tools
    return page


def _tools(answerer: Answerer, recordings: Path | None) -> list[Any]:
    from gradio.utils import get_upload_folder

    from .api import Api
    from .recordings_folder import RecordingsFolder
    from .sources import Sources
    from .tools import Tool
    from .uploads import Uploads

    folder = None if recordings is None else RecordingsFolder(recordings)
    served = Api(answerer, Sources(Uploads(get_upload_folder()), folder))
    return [Tool.of(function) for function in served.functions]


HOST = "127.0.0.1"
"""Where the page listens: on this machine only."""


def launch(page: Any, *, port: int | None = None, mcp: bool = False) -> str:
    """Serve the page in the background, on this machine only, and return its address.

    Args:
        page: What `build` returned.
        port: To listen on; None takes a free one from 7860 on.
        mcp: Whether to serve its tools over the Model Context Protocol as well.

    Raises:
        MissingDependency: If the protocol's package is missing.
    """
    from starlette.middleware import Middleware
    from starlette.routing import Route

    from .light_sessions import LightSessions
    from .theme import STYLES, theme

    names = (*OWN_NAMES, HOST)
    guards = [
        Middleware(OwnNamesOnly, names=names),
        Middleware(NoAddresses),
        Middleware(MessageLimit),
        Middleware(BusyStatus),
    ]
    served: dict[str, Any] = {"middleware": guards}
    if mcp:
        require_mcp()
        agents = AgentServer(page.tools)
        served |= {"routes": [Route(f"/{PATH}", agents)], "lifespan": agents.lifespan}
    page.queue(max_size=QUEUE)
    keep_session_order(page._queue, MODEL_LINE)
    keep_messages_counted(page._queue)
    app, address, _ = page.launch(
        server_name=HOST,
        server_port=port,
        share=False,
        max_file_size=UPLOAD_BYTES,
        max_threads=2 * AT_ONCE,
        prevent_thread_lock=True,
        quiet=True,
        ssr_mode=False,
        theme=theme(),
        css_paths=STYLES,
        mcp_server=False,
        app_kwargs=served,
    )
    app.state_holder = LightSessions(page)
    return address
