"""Start the page on this machine only (127.0.0.1)."""

import sys

from geotlm_lm import Answerer, GeoTLMError

from .ui import build


def main() -> None:
    """Load the model, build the page, serve it until stopped."""
    try:
        page = build(Answerer.load())
    except GeoTLMError as error:
        print(error, file=sys.stderr)
        sys.exit(error.exit_code)
    page.launch(server_name="127.0.0.1", share=False, max_file_size="512mb")


if __name__ == "__main__":
    main()
