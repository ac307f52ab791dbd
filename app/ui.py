"""The page: its tabs, each of which has its own file, how it looks, and how it is served."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gradio as gr
from gradio.utils import get_upload_folder
from starlette.middleware import Middleware
from starlette.routing import Route

import geotlm_lm as lm

from . import ask_tab, guards, live_tab, sessions, simulate_tab, stage
from .api import Api
from .sources import Sources
from .toolkit import MODEL_LINE, report_progress
from .tools import Tool, manager_of, require_mcp
from .turns import AnswererInTurns, Turns

HOST = "127.0.0.1"
"""Where the page listens: on this machine only."""

PATH = "mcp"
"""Where agents are served, below the page's address."""

NAMED = """() => {
    const name = () => {
        document.querySelectorAll('.empty[aria-label]:not([role])')
            .forEach(picture => picture.setAttribute('role', 'img'));
        document.querySelectorAll('button[role=tab]').forEach(tab => {
            tab.tabIndex = tab.getAttribute('aria-selected') === 'true' ? 0 : -1;
        });
    };
    const watched = {childList: true, subtree: true, attributeFilter: ['aria-selected']};
    new MutationObserver(name).observe(document.body, watched);
    document.addEventListener('keydown', event => {
        const step = {ArrowLeft: -1, ArrowRight: 1}[event.key];
        if (!step || !event.target.matches('button[role=tab]')) return;
        const tabs = [...event.target.parentElement.querySelectorAll('button[role=tab]')];
        const next = tabs[(tabs.indexOf(event.target) + step + tabs.length) % tabs.length];
        next.click();
        next.focus();
    });
    name();
    const camera = navigator.mediaDevices, words = {
        NotAllowedError: 'The browser lets this page use no camera; allow it beside the address.',
        NotFoundError: 'No camera is connected; connect one, or drop a recording.',
        NotReadableError: 'The camera is used by another program; close that, and start again.',
    };
    if (!camera) return;
    const wanted = camera.getUserMedia.bind(camera);
    camera.getUserMedia = (what) => wanted(what).catch(error => {
        const line = document.querySelector('.live .complaint p');
        if (line) line.textContent = words[error.name] || `The camera fails: ${error.message}.`;
        throw error;
    });
}"""
"""What the toolkit lacks: roles, and tabs that are one stop of the keyboard, moved by arrows."""

HEAD = "<h1>geotlm-lm</h1>"

# The toolkit's bundled fonts are incomplete (its semibold holds two letters), others are fetched.
FONT = ("system-ui", "-apple-system", "Segoe UI", "Roboto", "Ubuntu", "Cantarell", "sans-serif")
MONO = ("ui-monospace", "SFMono-Regular", "Menlo", "Consolas", "monospace")


def build(answerer: lm.Answerer, recordings: Path | None = None) -> Any:
    """Return the page (a `gradio.Blocks`), not yet served; its `tools` are what programs call.

    Args:
        answerer: The model.
        recordings: Folder of recordings that programs may name; None for none.
    """
    answerer = AnswererInTurns(answerer, Turns(report_progress))
    api = Api(answerer, Sources(get_upload_folder(), recordings))
    tools = [Tool(function) for function in api.functions]
    # Without analytics nothing leaves the machine, and the page starts offline without a wait.
    with gr.Blocks(
        title="geotlm-lm", analytics_enabled=False, delete_cache=sessions.DELETE_CACHE
    ) as page:
        gr.HTML(HEAD, elem_classes=["page-head"], apply_default_css=False)
        with gr.Tab("Ask"):
            ask_tab.build(answerer, page)
        with gr.Tab("Live"):
            live_tab.build(answerer)
        with gr.Tab("Simulate") as tab:
            simulate_tab.build(answerer, tab)
        for tool in tools:
            tool.serve()
        sessions.remove_uploads_with_session(page)
        page.load(None, js=NAMED, api_visibility="private")
    guards.refuse_addresses(page)
    page.tools = tools
    return page


def launch(page: Any, *, port: int | None = None, mcp: bool = False) -> str:
    """Serve the page in the background, on this machine only, and return its address.

    Args:
        page: What `build` returned.
        port: To listen on; None takes a free one from 7860 on.
        mcp: Whether to serve its tools over the Model Context Protocol as well.

    Raises:
        MissingDependency: If the protocol's package is missing.
    """
    routes = [Route(f"/{stage.ROUTE}/{{key}}", stage.serve_pack)]
    served: dict[str, Any] = {"middleware": [Middleware(guards.Guard)], "routes": routes}
    if mcp:
        require_mcp()
        from mcp.server.fastmcp.server import StreamableHTTPASGIApp

        manager = manager_of(page.tools)
        routes.append(Route(f"/{PATH}", StreamableHTTPASGIApp(manager)))
        served["lifespan"] = lambda _: manager.run()
    page.queue(max_size=guards.QUEUE)
    sessions.keep_order(page._queue, MODEL_LINE)
    guards.keep_messages_counted(page._queue)
    app, address, _ = page.launch(
        server_name=HOST,
        server_port=port,
        share=False,
        max_file_size=guards.UPLOAD_BYTES,
        max_threads=2 * guards.AT_ONCE,
        prevent_thread_lock=True,
        quiet=True,
        ssr_mode=False,
        theme=theme(),
        css_paths=Path(__file__).with_name("page.css"),
        footer_links=[],
        i18n=gr.I18n(en={"common.upload": "Upload"}),  # a key that the toolkit lacks
        mcp_server=False,
        app_kwargs=served,
    )
    app.state_holder = sessions.LightSessions(page)
    return address


def theme() -> Any:
    """Return the page's theme, light and dark; nothing is fetched for it."""
    base = gr.themes.Base(
        primary_hue=gr.themes.colors.teal,
        secondary_hue=gr.themes.colors.teal,
        neutral_hue=gr.themes.colors.slate,
        spacing_size=gr.themes.sizes.spacing_sm,
        radius_size=gr.themes.sizes.radius_md,
        text_size=gr.themes.sizes.text_md,
        font=FONT,
        font_mono=MONO,
    )
    return base.set(
        body_background_fill="*neutral_50",
        body_background_fill_dark="*neutral_950",
        body_text_color_subdued="*neutral_600",
        body_text_color_subdued_dark="*neutral_400",
        block_label_text_color="*neutral_700",
        block_label_text_color_dark="*neutral_300",
        input_placeholder_color="*neutral_500",
        input_placeholder_color_dark="*neutral_400",
        # The toolkit's own links are too pale on white, and followed ones in the dark as well.
        link_text_color="*secondary_700",
        link_text_color_active="*secondary_700",
        link_text_color_visited="*secondary_700",
        link_text_color_visited_dark="*secondary_500",
        # White letters on it have a contrast of 5.5.
        button_primary_background_fill="*primary_700",
        button_primary_background_fill_hover="*primary_800",
        button_primary_background_fill_dark="*primary_700",
        button_primary_background_fill_hover_dark="*primary_600",
        button_primary_text_color="white",
        button_primary_text_color_dark="white",
    )
