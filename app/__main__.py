"""Start the page on this machine only (127.0.0.1)."""

from __future__ import annotations

import sys

from geotlm_lm import GeoTLMError

from .agents import require_mcp
from .told import gradio


def serve(port: int | None = None, *, mcp: bool = False, precision: str = "float32") -> None:
    """Load the model, build the page, serve it until stopped.

    Args:
        port: To listen on; None takes a free one from 7860 on.
        mcp: Whether to serve agents as well, over the Model Context Protocol.
        precision: Number format of the model, as in `Answerer.load`.

    Raises:
        GeoTLMError: If the toolkit or the model is missing, or the port is taken.
    """
    gradio()  # told before the model is loaded
    if mcp:
        require_mcp()
    from geotlm_lm import Answerer

    from .ui import build, launch

    page = build(Answerer.load(precision=precision))
    try:
        launch(page, port=port, mcp=mcp)
    except OSError as error:
        raise GeoTLMError(
            f"Port {port} is taken or not allowed; give another by --port, or none."
        ) from error


def main() -> None:
    """Serve the page; an error becomes one sentence."""
    try:
        serve()
    except GeoTLMError as error:
        print(error, file=sys.stderr)
        sys.exit(error.exit_code)


if __name__ == "__main__":
    main()
