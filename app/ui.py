"""The page: its tabs, and what stands above them; each tab has its own file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .agents import require_mcp, speak_json
from .error_display import gradio
from .own_names import OWN_NAMES, OwnNamesOnly

if TYPE_CHECKING:
    from geotlm_lm import Answerer

HEAD = (
    "<h1>geotlm-lm</h1> <p>Ask a camera-based touch sensor, in plain language, how the touched "
    "object moves.</p>"
)


def build(answerer: Answerer) -> Any:
    """Return the page (a `gradio.Blocks`), not yet served.

    Raises:
        MissingDependency: If gradio is not installed.
    """
    gr = gradio()
    from . import api, ask_tab, benchmark_tab, compare_tab, live_tab, session_files, simulate_tab

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
            api.build(answerer)
        session_files.connect(page, [one for one in page.blocks.values() if type(one) is gr.File])
    return page


HOST = "127.0.0.1"
"""Where the page listens: on this machine only."""

QUEUE = 64
"""Requests that may wait; one more is told to come back. Uses of the model run one by one."""


def launch(page: Any, *, port: int | None = None, mcp: bool = False) -> str:
    """Serve the page in the background, on this machine only, and return its address.

    Args:
        page: What `build` returned.
        port: To listen on; None takes a free one from 7860 on.
        mcp: Whether to serve its functions over the Model Context Protocol as well.

    Raises:
        MissingDependency: If the protocol's package is missing.
    """
    if mcp:
        require_mcp()
    from starlette.middleware import Middleware

    from .theme import STYLES, theme

    names = (*OWN_NAMES, HOST)
    page.queue(max_size=QUEUE)
    _, address, _ = page.launch(
        server_name=HOST,
        server_port=port,
        share=False,
        max_file_size="512mb",
        prevent_thread_lock=True,
        quiet=True,
        ssr_mode=False,
        mcp_server=mcp,
        theme=theme(),
        css_paths=STYLES,
        app_kwargs={"middleware": [Middleware(OwnNamesOnly, names=names)]},
    )
    if mcp:
        speak_json(page)
    return address
