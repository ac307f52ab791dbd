"""`geotlm-lm batch`: a file of questions about a folder of clips, to JSON lines."""

from __future__ import annotations

import json
import sys
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from geotlm_lm.cli.options import (
    BundleFolder,
    ClusterAddress,
    FramesPerSecond,
    LayoutName,
    MmPerPixel,
    Precision,
    SquarePixels,
    TopicName,
    path_option,
    require_writable_file,
)
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.workers import Workers

NAMES_TOLD = 5
"""Skipped files that are named; of more than these, how many."""

COMMENT = "#"
"""Begins a line of a question file that is no question."""

ROW_FIELDS = {"clip", "question", "answer", "error"}
"""Of a batch's row, whatever the version that wrote it."""


def batch(
    clips: Annotated[
        Path, path_option(help="Folder of recordings: files, or folders of images in it.")
    ],
    questions: Annotated[
        Path, path_option(help="Text file, one question a line; # begins a comment.")
    ],
    out: Annotated[Path, path_option(help="Where the rows go, one JSON object a line.")],
    workers: Annotated[
        int | None,
        typer.Option(min=1, help="Processes that answer. [default: one per usable core]"),
    ] = None,
    cluster: ClusterAddress = None,
    layout: LayoutName = None,
    fps: FramesPerSecond = None,
    square_pixels: SquarePixels = None,
    topic: TopicName = None,
    mm_per_px: MmPerPixel = None,
    model: BundleFolder = None,
    precision: Precision = "float32",
) -> None:
    """Ask every question about every clip; one row each, answer or error.

    A clip is encoded once. A stopped run continues where it was when it is started again; the file
    appears when all of it is there. It may take the place of an earlier batch's, and of no other.

    Example: geotlm-lm batch --clips recordings --questions questions.txt --out answers.jsonl
    """
    from geotlm_lm.recordings.listing import clips_in
    from geotlm_lm.recordings.pixels import check_layout
    from geotlm_lm.recordings.read import require_rate

    by = Workers(workers, cluster)
    require_rate(fps)
    reading = {
        "layout": check_layout(layout),
        "fps": fps,
        "square_pixels": square_pixels,
        "topic": topic,
    }
    frame = FrameSpec(mm_per_px=mm_per_px)
    found, asked = clips_in(clips), read_questions(questions)
    require_writable_file(out, "--out", inputs=[questions, *found])
    require_replaceable(out)
    _tell_skipped(clips, own=[questions, out, out.with_name(f"{out.name}.part")])

    # Imported only now: a wrong path must not wait for the model's libraries.
    from geotlm_lm.answering.batch import answer_all
    from geotlm_lm.answering.loaded import loaded
    from geotlm_lm.cli.progress import progress_on_stderr

    report = progress_on_stderr()
    result = answer_all(
        partial(loaded, model, precision),
        found,
        asked,
        out,
        reading=reading,
        frame=frame,
        workers=by,
        progress=lambda done, total: report("answered", done, total),
    )
    if result.continued:
        print(f"note: {result.continued} rows were there from a stopped run", file=sys.stderr)
    print(f"{out}: {result.rows} rows, {result.errors} of them errors")


def require_replaceable(out: Path) -> None:
    """Refuse to replace a file that is neither empty nor the rows of a batch.

    Raises:
        UsageError: If there is such a file.
    """
    if out.exists() and not (out.is_file() and _holds_rows(out)):
        raise UsageError(
            f"--out: {out} holds something else than a batch's rows and would be replaced, "
            f"expected a new file or an earlier batch's; give another name."
        )


def _holds_rows(path: Path) -> bool:
    try:
        with path.open(encoding="utf-8") as stream:
            rows = map(json.loads, stream)
            return all(isinstance(row, dict) and set(row) == ROW_FIELDS for row in rows)
    except (OSError, ValueError, RecursionError):  # a text that is no UTF-8 among them
        return False


def _tell_skipped(folder: Path, own: list[Path]) -> None:
    """Name on stderr what gets no row, apart from the run's own files."""
    from geotlm_lm.recordings.listing import EXPECTED, skipped_in

    mine = {path.resolve() for path in own}
    names = [one.name for one in skipped_in(folder) if one.resolve() not in mine]
    if names:
        more = len(names) - NAMES_TOLD
        told = ", ".join(names[:NAMES_TOLD]) + (f" and {more} more" if more > 0 else "")
        print(f"note: skipped as no recording ({EXPECTED}): {told}", file=sys.stderr)


def read_questions(path: Path) -> list[str]:
    """Return the questions of a text file, one a line; blank lines and # comments are left out.

    Raises:
        UsageError: If the file cannot be read, is no UTF-8 text, or holds no question.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        raise UsageError(
            f"{path}: cannot be read ({error.strerror}); give a text file of questions."
        ) from error
    except UnicodeDecodeError as error:
        raise UsageError(f"{path}: is no UTF-8 text; save the questions as UTF-8.") from error
    stripped = map(str.strip, lines)
    questions = [line for line in stripped if line and not line.startswith(COMMENT)]
    if not questions:
        raise UsageError(f"{path}: holds no question; write one a line.")
    return list(dict.fromkeys(questions))
