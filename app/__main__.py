"""Start the page on this machine only (127.0.0.1)."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from geotlm_lm import GeoTLMError

from .agents import require_mcp
from .cache_folder import own_cache_folder
from .error_display import gradio

if TYPE_CHECKING:
    from geotlm_lm import Answerer


def serve(
    port: int | None = None,
    *,
    mcp: bool = False,
    recordings: Path | None = None,
) -> None:
    """Build the page and serve it until stopped; the model is loaded as soon as the page stands.

    Args:
        port: To listen on; None takes a free one from 7860 on.
        mcp: Whether to serve agents as well, over the Model Context Protocol.
        recordings: Folder of recordings that programs and agents may name; it is only read.

    Raises:
        GeoTLMError: If the toolkit or the model is missing, or the port is taken.
    """
    with own_cache_folder():  # before the toolkit is imported, which looks for it
        gradio()  # told before the model is loaded
        if mcp:
            require_mcp()
        _serve(port, mcp, recordings)


def _serve(port: int | None, mcp: bool, recordings: Path | None) -> None:
    from .lazy_answerer import LazyAnswerer
    from .ui import build, launch

    model = LazyAnswerer(_load)
    page = build(model, recordings)
    try:
        address = launch(page, port=port, mcp=mcp)
    except OSError as error:
        raise GeoTLMError(
            f"Port {port} is taken or not allowed; give another by --port, or none."
        ) from error
    print(f"Serving {address} on this machine only; Ctrl-C stops it.", flush=True)
    try:
        model.load()
        page.block_thread()
    finally:
        page.close()


def _load() -> Answerer:
    from geotlm_lm import Answerer

    return Answerer.load()


if __name__ == "__main__":
    # The same as `geotlm-lm app`, options and errors and all.
    sys.argv[:] = ["geotlm-lm", "app", *sys.argv[1:]]
    runpy.run_module("geotlm_lm", run_name="__main__", alter_sys=True)
