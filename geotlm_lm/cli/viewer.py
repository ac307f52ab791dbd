"""What `--rerun` asks for: a file, or Rerun's viewer on this machine until Ctrl-C."""

from __future__ import annotations

import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from urllib.parse import quote

SERVE = Path("serve")
"""In place of a file's name: what would be written is shown."""

HOST = "127.0.0.1"


def write_or_serve(target: Path, write: Callable[[Path], None]) -> None:
    """Write a Rerun recording, or show it in a browser until Ctrl-C.

    Args:
        target: Of the file, or `SERVE`.
        write: Writes the recording to a file.
    """
    if target != SERVE:
        write(target)
        return
    with TemporaryDirectory() as folder:
        path = Path(folder) / "seen.rrd"
        write(path)
        sys.stdout.flush()  # what was answered is read while the viewer runs
        with suppress(KeyboardInterrupt), viewer(path) as (address, running):
            print(f"Rerun's viewer is at {address} until Ctrl-C.", file=sys.stderr)
            running.wait()


@contextmanager
def viewer(path: Path) -> Iterator[tuple[str, subprocess.Popen[bytes]]]:
    """Yield the address of a viewer of a recording, for this machine alone, and its process.

    Args:
        path: Of the .rrd file.
    """
    data_port, page_port = _free_ports(2)
    command = [str(_program()), str(path), "--serve-web", "--bind", HOST]
    command += ["--port", str(data_port), "--web-viewer-port", str(page_port)]
    running = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    try:
        source = quote(f"rerun+http://{HOST}:{data_port}/proxy", safe="")
        yield f"http://{HOST}:{page_port}/?url={source}", running
    finally:
        running.terminate()
        running.wait()


def _program() -> Path:
    """Return the viewer's own program: the wrapper that Python runs would leave it behind."""
    folder = Path(find_spec("rerun_cli").origin).parent
    names = ("Rerun.app/Contents/MacOS/Rerun", "rerun.exe", "rerun")  # macOS, Windows, others
    return next(folder / name for name in names if (folder / name).is_file())


def _free_ports(count: int) -> list[int]:
    with ExitStack() as held:
        sockets = [held.enter_context(socket.socket()) for _ in range(count)]
        for one in sockets:
            one.bind((HOST, 0))
        return [one.getsockname()[1] for one in sockets]
