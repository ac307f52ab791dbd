"""The same functions for agents, over the Model Context Protocol (extra: mcp)."""

from __future__ import annotations

import json
from importlib.util import find_spec
from typing import Any

from geotlm_lm.core.errors import MissingDependency

PATH = "gradio_api/mcp/"
"""Where the protocol is served, below the page's address."""


def require_mcp() -> None:
    """Refuse where the protocol's package is missing.

    Raises:
        MissingDependency: If it is not installed; the toolkit alone would serve the page without.
    """
    if find_spec("mcp") is None:
        raise MissingDependency(
            "--mcp needs the package mcp, which is not installed; "
            "run `pip install 'geotlm-lm[mcp]'`."
        )


def speak_json(page: Any) -> None:
    """Have a served page's tools answer in JSON; the toolkit's own text is Python's.

    Raises:
        MissingDependency: If the toolkit serves the page without the protocol, with its reason.
    """
    server = page.mcp_server_obj
    if not page.mcp_server or server is None:
        raise MissingDependency(
            f"MCP could not be served ({getattr(page, 'mcp_error', None) or 'no reason given'}); "
            f"run `pip install 'geotlm-lm[mcp]'`."
        )

    def in_json(values: list[Any], root_url: str) -> list[Any]:
        del root_url  # none of our results names a file
        return [server.types.TextContent(type="text", text=json.dumps(one)) for one in values]

    server.postprocess_output_data = in_json
