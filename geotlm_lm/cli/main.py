"""The `geotlm-lm` command and what becomes of its errors; each command has its own file."""

from __future__ import annotations

import errno
import os
import re
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from io import TextIOWrapper
from pathlib import Path
from typing import Annotated

import typer

from geotlm_lm import __version__
from geotlm_lm.cli.answer import answer
from geotlm_lm.cli.batch import batch
from geotlm_lm.cli.bench import app as bench
from geotlm_lm.cli.chat import chat
from geotlm_lm.cli.evaluate import evaluate
from geotlm_lm.cli.info import doctor, info
from geotlm_lm.cli.label import label
from geotlm_lm.cli.manifest import manifest
from geotlm_lm.cli.options import grouped, option
from geotlm_lm.cli.simulate import ForwardsClip, simulate, simulate_clip
from geotlm_lm.cli.track import INTERRUPTED, track
from geotlm_lm.cli.train import train
from geotlm_lm.cli.watch import watch
from geotlm_lm.core.errors import GeoTLMError, UsageError, choice_of, nearest

app = typer.Typer(
    name="geotlm-lm",
    help="Ask a camera-based touch sensor, in plain language, how the touched object moves.",
    epilog="Example: geotlm-lm answer clip.npz --q 'Which way is it turning?'",
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)

STOPPED = "Stopped; files already complete are kept."

WITHOUT_FILES = ("answer", "app", "chat", "doctor", "info")
"""Commands that write none, of which there is no more to say than that they stopped."""

UNWRITTEN = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
"""What a disk or a terminal that takes no more says; any other error of the system is a defect."""

NO_OPTION = re.compile(r"No such option: (\S+?)\.?(?: \(Possible options: (.*)\)|$)")
NO_VALUE = re.compile(r"(.*?)'([^']*)' is not one of ('.*)")
"""How the option parser reports unknown names."""

ParseError = typer.BadParameter.__base__
"""What the option parser raises on unknown or missing options; typer names no public alias."""

for command in (answer, batch, chat, doctor, info, label, manifest, track, train, watch):
    app.command()(command)
app.command(cls=ForwardsClip)(simulate)
app.command()(simulate_clip)
app.command(epilog="Example: geotlm-lm evaluate --clips 40 --out mine.json")(evaluate)
app.add_typer(bench, name="bench")


@app.command(name="app")
@grouped
def serve(
    port: int | None = option("To listen on. [default: a free one from 7860 on]", min=1, max=65535),
    mcp: bool = option("Serve agents too, over MCP. Needs the extra mcp.", "--mcp", default=False),
    recordings: Path | None = option(
        "Folder of recordings that programs and agents may name; only read."
    ),
) -> None:
    """Serve a page to look at clips and ask about them, on this machine only (127.0.0.1).

    Example: geotlm-lm app --port 7860
    """
    import_module(f"{_page_package()}.__main__").serve(port, mcp=mcp, recordings=recordings)


def _page_package() -> str:
    """Return the name the page's package is imported by."""
    import geotlm_lm
    from geotlm_lm.core.files import resource_dir

    folder = resource_dir("app")
    if folder.parent == Path(geotlm_lm.__file__).resolve().parent:
        return f"{geotlm_lm.__name__}.app"
    # A checkout keeps the page beside the package, where only a run from its root would find it.
    if str(folder.parent) not in sys.path:
        sys.path.insert(0, str(folder.parent))
    return folder.name


def _show_version(is_asked: bool) -> None:
    if is_asked:
        print(f"geotlm-lm {__version__}")
        raise typer.Exit


@app.callback()
def root(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version."),
    ] = False,
) -> None:
    """Ask a camera-based touch sensor, in plain language, how the touched object moves."""


@contextmanager
def ended_in_order() -> Iterator[None]:
    """Turn SIGTERM into an interruption; after the block the process ends of the signal itself.

    Without it a video that is being written would stay without its index, which no player reads.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # signals are the main thread's
        return
    asked, owner = [], os.getpid()

    def end(number: int, _: object) -> None:
        if asked or os.getpid() != owner:  # asked twice, or a copy of the process made to work
            _end_by(number)
        asked.append(number)
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before or signal.SIG_DFL)  # None: set outside Python
        if asked:
            _end_by(asked[0])


def _end_by(number: int) -> None:
    """End this process as the signal would have; whoever sent it looks for that."""
    signal.signal(number, signal.SIG_DFL)
    os.kill(os.getpid(), number)


def main(arguments: list[str] | None = None) -> None:
    """Run a command and exit: 0 done, 2 wrong call or full disk, 130 stopped, else the error's own.

    An error the user can repair becomes one sentence on stderr; any other exception is a defect
    and keeps its trace (exit code 1). A request to end (SIGTERM) is followed as Ctrl-C is.
    """
    with ended_in_order():
        _run(arguments)


def _run(arguments: list[str] | None) -> None:
    command = typer.main.get_command(app)
    words = sys.argv[1:] if arguments is None else arguments
    if isinstance(sys.stdout, TextIOWrapper):  # names that are not UTF-8 are printed as they are
        sys.stdout.reconfigure(errors="surrogateescape")
    stopped = "Stopped." if words[:1] and words[0] in WITHOUT_FILES else STOPPED
    try:
        code = command.main(args=arguments, prog_name="geotlm-lm", standalone_mode=False)
        sys.stdout.flush()  # here what does not fit can still be told
    except GeoTLMError as error:
        _stop(str(error), error.exit_code)
    except ParseError as error:
        _stop(_sentence(error.format_message()), UsageError.exit_code)
    except (KeyboardInterrupt, typer.Abort):
        _stop(stopped, INTERRUPTED)
    except OSError as error:
        _stop_unwritten(error)
    if code == INTERRUPTED:
        _stop(stopped, INTERRUPTED)
    sys.exit(code if isinstance(code, int) else 0)


def _sentence(message: str) -> str:
    """Return the parser's message as one line that ends by telling where help is."""
    one_line = " ".join(message.split()).rstrip(".").replace("Value error, ", "")
    if option := NO_OPTION.match(one_line):
        name, candidates = option.groups()
        near = nearest(name, re.findall(r"--?[\w-]+", candidates or ""))
        one_line = f"No such option: {name}" + (f". Did you mean '{near}'?" if near else "")
    elif value := NO_VALUE.match(one_line):
        before, name, known = value.groups()
        advice = choice_of(name, re.findall(r"'([^']*)'", known))
        one_line = f"{before}there is no '{name}'; {advice}".rstrip(".")
    # "Did you mean 'answer'?" asks; what follows a question is a sentence of its own.
    if one_line.endswith("?"):
        return f"{one_line} See `geotlm-lm --help`."
    return f"{one_line}; see `geotlm-lm --help`."


def _stop(sentence: str, code: int) -> None:
    print(sentence, file=sys.stderr)
    sys.exit(code)


def _stop_unwritten(error: OSError) -> None:
    """Stop where nothing more can be written; raise any other error again."""
    is_unread = error.errno == errno.EPIPE  # as by `| head`: nobody is there to be told
    if not is_unread and error.errno not in UNWRITTEN:
        raise error
    # What waits in the buffer would fail once more when Python ends.
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    if is_unread:
        sys.exit(1)
    where = error.filename or "The output"
    _stop(
        f"{where} cannot be written ({error.strerror}); make room, or give another place.",
        UsageError.exit_code,
    )
