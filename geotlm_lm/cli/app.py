"""`geotlm-lm app`: the page in the browser, from a checkout or from an installation."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from typing import Annotated

import typer

from geotlm_lm.cli.options import path_option


def app(
    port: Annotated[
        int | None,
        typer.Option(min=1, max=65535, help="To listen on. [default: a free one from 7860 on]"),
    ] = None,
    mcp: Annotated[
        bool, typer.Option("--mcp", help="Serve agents too, over MCP. Needs the extra mcp.")
    ] = False,
    recordings: Annotated[
        Path | None,
        path_option(help="Folder of recordings that programs and agents may name; only read."),
    ] = None,
) -> None:
    """Serve a page to look at clips and ask about them, on this machine only (127.0.0.1).

    Example: geotlm-lm app --port 7860
    """
    import_module(f"{page_package()}.__main__").serve(port, mcp=mcp, recordings=recordings)


def page_package() -> str:
    """Return the name the page's package is imported by."""
    import geotlm_lm
    from geotlm_lm.core.resources import resource_dir

    folder = resource_dir("app")
    if folder.parent == Path(geotlm_lm.__file__).resolve().parent:
        return f"{geotlm_lm.__name__}.app"
    # A checkout keeps the page beside the package, where only a run from its root would find it.
    if str(folder.parent) not in sys.path:
        sys.path.insert(0, str(folder.parent))
    return folder.name
