"""`geotlm-lm batch`: a file of questions about a folder of recordings, to JSON lines."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geotlm_lm.cli.options import (
    Answering,
    CameraName,
    ClusterAddress,
    Pixels,
    argument,
    grouped,
    option,
    require_writable_file,
    touch_camera,
)
from geotlm_lm.cli.progress import print_notes, progress_on_stderr
from geotlm_lm.core.errors import UsageError
from geotlm_lm.runs.run import Workers

if TYPE_CHECKING:
    from geotlm_lm.answering.batch import Source

NAMED = 5
"""Skipped files that are named; of more than these, how many."""

COMMENT = "#"
"""Begins a line of a question file that is no question."""

ROW_FIELDS = {"clip", "question", "answer", "error"}
"""Of a batch's row, whatever the version that wrote it."""


@grouped
def batch(
    *,
    clips: Path = argument(
        "FOLDER",
        "Of recordings (files, folders of images, bags), or a LeRobot data set, each of whose "
        "episodes is one.",
        "--clips",
    ),
    questions: Path = option("Text file, one question a line; # begins a comment."),
    out: Path = option("Where the rows go, one JSON object a line."),
    workers: int | None = option("Processes that answer. [default: one per usable core]", min=1),
    cluster: ClusterAddress = None,
    pixels: Pixels,
    camera: CameraName = None,
    answering: Answering,
) -> None:
    """Ask every question about every clip; one row each, answer or error.

    A clip is encoded once. A stopped run continues where it was when it is started again; the file
    appears when all of it is there. It may take the place of an earlier batch's, and of no other.

    Example: geotlm-lm batch recordings --questions questions.txt --out answers.jsonl
    """
    from geotlm_lm.data_sets.lerobot import is_data_set
    from geotlm_lm.recordings.pixels import check_layout
    from geotlm_lm.recordings.read import require_rate

    by = Workers(workers, cluster)
    require_rate(pixels.fps)
    reading = {"fps": pixels.fps, "square_pixels": pixels.square_pixels}
    of_files = {"layout": check_layout(pixels.layout), "topic": pixels.topic}
    asked = read_questions(questions)
    if is_data_set(clips):
        sources = _episodes(clips, camera, out, of_files, reading)
    else:
        sources = _recordings(clips, camera, questions, out, of_files | reading)
    require_writable_file(out, "--out", inputs=[questions])
    require_replaceable(out)

    # Imported only now: a wrong path must not wait for the model's libraries.
    from geotlm_lm.answering.answerer import loaded
    from geotlm_lm.answering.batch import answer_all

    result = answer_all(
        partial(loaded, answering.model),
        sources,
        asked,
        out,
        frame=answering.frame,
        workers=by,
        progress=progress_on_stderr(),
    )
    if result.continued:
        print_notes(f"{result.continued} rows were there from a stopped run")
    print(f"{out}: {result.rows} rows, {result.errors} of them errors")


def _episodes(
    root: Path,
    camera: str | None,
    out: Path,
    of_files: dict[str, Any],
    reading: dict[str, Any],
) -> list[Source]:
    """Return the episodes of a data set; refuse options of other recordings."""
    from geotlm_lm.data_sets.lerobot import every_episode, read_data_set

    for name, value in of_files.items():
        if value is not None:
            raise UsageError(
                f"--{name} is of files, and {root} is a LeRobot data set, which tells its own; "
                f"leave it out."
            )
    if out.resolve().is_relative_to(root.resolve()):
        raise UsageError(
            f"--out: {out} lies in the data set that is read, expected a file beside it; give "
            f"another place."
        )
    data_set = read_data_set(root)
    return list(every_episode(data_set, touch_camera(data_set, camera), **reading))


def _recordings(
    folder: Path, camera: str | None, questions: Path, out: Path, reading: dict[str, Any]
) -> list[Source]:
    """Return the recordings of a folder; name on stderr what gets no row, but the run's own."""
    from geotlm_lm.recordings.read import EXPECTED, StoredRecording, clips_in, skipped_in

    if camera is not None:
        raise UsageError(f"--camera is of a LeRobot data set, and {folder} is none; leave it out.")
    paths = clips_in(folder)
    require_writable_file(out, "--out", inputs=paths)
    own = {path.resolve() for path in (questions, out, out.with_name(f"{out.name}.part"))}
    names = [path.name for path in skipped_in(folder) if path.resolve() not in own]
    if names:
        more = len(names) - NAMED
        listed = ", ".join(names[:NAMED]) + (f" and {more} more" if more > 0 else "")
        print_notes(f"skipped as no recording ({EXPECTED}): {listed}")
    return [StoredRecording(path, reading) for path in paths]


def require_replaceable(out: Path) -> None:
    """Refuse to replace a file that is neither empty nor the rows of a batch."""
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


def read_questions(path: Path) -> list[str]:
    """Return the questions of a text file, one a line; blank lines and # comments are left out."""
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
