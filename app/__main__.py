"""Start the page on this machine only (127.0.0.1), with a folder of its own for uploads."""

from __future__ import annotations

import os
import runpy
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from filelock import FileLock, Timeout

import geotlm_lm as lm
from geotlm_lm.core.errors import require_package

PREFIX, LOCK = "geotlm-lm-app-", ".lock"
"""Beginning of the names of servers' folders, and the file in each that its server locks."""

VARIABLE = "GRADIO_TEMP_DIR"
"""Where the toolkit reads its folder from, as long as it serves."""


def serve(port: int | None = None, *, mcp: bool = False, recordings: Path | None = None) -> None:
    """Build the page and serve it until stopped; the model is loaded as soon as the page stands.

    Args:
        port: To listen on; None takes a free one from 7860 on.
        mcp: Whether to serve agents as well, over the Model Context Protocol.
        recordings: Folder of recordings that programs and agents may name; it is only read.

    Raises:
        GeoTLMError: If the toolkit or the model is missing, or the port is taken.
    """
    with own_cache_folder():  # before the toolkit is imported, which looks for it
        require_package("gradio", "The app needs gradio", "app")
        from .turns import LazyAnswerer
        from .ui import build, launch

        model = LazyAnswerer(lambda: lm.Answerer.load())
        page = build(model, recordings)
        try:
            address = launch(page, port=port, mcp=mcp)
        except OSError as error:
            raise lm.GeoTLMError(
                f"Port {port} is taken or not allowed; give another by --port, or none."
            ) from error
        print(f"Serving {address} on this machine only; Ctrl-C stops it.", flush=True)
        try:
            model.load()
            page.warm()
            page.block_thread()
        finally:
            page.close()


@contextmanager
def own_cache_folder(parent: Path | None = None) -> Iterator[Path]:
    """Give this process a folder for uploads and pictures, and remove it in the end.

    Folders of servers that died are removed first. A folder is in use while the file in it is
    locked, which ends with the process that holds the lock, however it ends. They lie in the
    system's temporary folder, or in `parent`.
    """
    parent = Path(tempfile.gettempdir()) if parent is None else parent
    for lock in parent.glob(f"{PREFIX}*/{LOCK}"):
        with suppress(OSError, Timeout):  # in use
            # Where systems do not tell whose a folder is, temporary folders are the user's.
            if not hasattr(os, "getuid") or lock.parent.lstat().st_uid == os.getuid():
                with FileLock(lock, blocking=False):
                    shutil.rmtree(lock.parent, ignore_errors=True)
    folder, before = Path(tempfile.mkdtemp(prefix=PREFIX, dir=parent)), os.environ.get(VARIABLE)
    with FileLock(folder / LOCK):
        folder.chmod(0o700)  # if another server removed it before it was locked, it was made anew
        os.environ[VARIABLE] = str(folder)
        try:
            yield folder
        finally:
            if before is None:
                del os.environ[VARIABLE]
            else:
                os.environ[VARIABLE] = before
            shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    # The same as `geotlm-lm app`, options and errors and all.
    sys.argv[:] = ["geotlm-lm", "app", *sys.argv[1:]]
    runpy.run_module("geotlm_lm", run_name="__main__", alter_sys=True)
