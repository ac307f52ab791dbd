"""Answer many questions about many recordings into JSON lines; interrupted runs are continued.

The rows of each clip are kept in the folder `NAME.part` while the run lasts; in the order of the
clips they take the place of NAME when all are there, so that a reader never sees half a table.
"""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from geotlm_lm.answering.answer import answer_schema
from geotlm_lm.core.errors import GeoTLMError
from geotlm_lm.core.files import replacing
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.process import Progress, silent, uninterrupted_step
from geotlm_lm.runs.run import (
    ALONE,
    LOST,
    Workers,
    do_parts,
    holds_json,
    load_json,
    run_folder,
    save_json,
)

if TYPE_CHECKING:
    from geotlm_lm.answering.answerer import Answerer
    from geotlm_lm.core.clip import Clip

CAMERA = FrameSpec()

ROWS_VERSION = 4
"""Of what a stopped run leaves: another version's is not continued."""

Row = dict[str, Any]


class Source(Protocol):
    """A recording or an episode: processes are sent it, and read it there."""

    @property
    def name(self) -> str:
        """What its rows call it."""

    @property
    def seen_at(self) -> Path:
        """What a machine that reads it must have."""

    def read(self) -> Clip:
        """Return its frames.

        Raises:
            GeoTLMError: If it cannot be read.
        """

    def stamp(self) -> list[Any]:
        """Return plain JSON values that change when its content or its reading does."""


@dataclass(frozen=True)
class BatchResult:
    """What a run wrote.

    Args:
        rows: One for each clip and question.
        errors: How many of them hold an error in place of an answer.
        continued: How many of them an earlier, stopped run had written.
    """

    rows: int
    errors: int
    continued: int


def answer_all(
    load: Callable[[], Answerer],
    clips: Sequence[Source],
    questions: Sequence[str],
    out: Path,
    *,
    frame: FrameSpec = CAMERA,
    workers: Workers = ALONE,
    progress: Progress = silent,
) -> BatchResult:
    """Write one row for each clip and question to `out`, as JSON lines.

    A row holds clip, question, answer (as in the published schema) and error; of the last two one
    is null. A clip that cannot be read, or a question that cannot be asked, gives rows with the
    error's one sentence; so does one that ends the process which reads it, but for `ALONE`, where
    that is this process.

    Args:
        load: Returns the model, the same object every time; each process asks its own.
        clips: What is asked about.
        questions: Asked about each clip.
        out: The file to write.
        frame: What is known of how all clips were taken.
        workers: Who answers; but for the times in them, rows do not depend on it.
        progress: Called after every clip.

    Raises:
        UsageError: If an unfinished run of something else lies beside `out`, or another process is
            at it.
        Unwritten: If the rows cannot be written.
        GeoTLMError: If no worker can be started.
        ValueError: If there is no question.
    """
    if not questions:
        raise ValueError("a run takes 1 question or more, found none")
    folder = out.with_name(f"{out.name}.part")
    # The schema is among what is asked: a run that an older version began had other fields.
    asked = [list(questions), frame.to_dict()]
    asked_text = json.dumps([[clip.stamp() for clip in clips], asked, answer_schema()])
    settings = {
        "format": ROWS_VERSION,
        "model": load().bundle.digest(),
        "asked": hashlib.sha256(asked_text.encode()).hexdigest()[:16],
    }
    jobs = [(clip, folder / f"clip-{number:06d}.json") for number, clip in enumerate(clips)]
    with run_folder(folder, settings, "clips, questions or facts") as stamp:
        continued = do_parts(
            "answered",
            partial(_rows, load, questions, frame),
            jobs,
            save_json,
            is_kept=holds_json,
            workers=workers,
            seen=[stamp, *sorted({clip.seen_at for clip in clips})],
            lost=partial(_lost_rows, questions),
            progress=progress,
        )
        errors = 0
        with replacing(out) as stream:
            for row in (row for _, path in jobs for row in load_json(path)):
                stream.write(f"{json.dumps(row)}\n".encode())
                errors += row["error"] is not None
        with uninterrupted_step():
            shutil.rmtree(folder)
    return BatchResult(len(clips) * len(questions), errors, continued * len(questions))


def _rows(
    load: Callable[[], Answerer], questions: Sequence[str], frame: FrameSpec, clip: Source
) -> list[Row]:
    """Return the rows of one clip, which is encoded once."""
    answerer = load()
    try:
        encoded = answerer.encode(clip.read())
    except GeoTLMError as error:
        return [_row(clip, question, error=str(error)) for question in questions]
    rows = []
    for question in questions:
        try:
            answer = answerer.ask(encoded, question, frame=frame).to_dict()
        except GeoTLMError as error:
            rows.append(_row(clip, question, error=str(error)))
        else:
            rows.append(_row(clip, question, answer))
    return rows


def _lost_rows(questions: Sequence[str], clip: Source) -> list[Row]:
    return [_row(clip, question, error=f"{clip.name}: {LOST}") for question in questions]


def _row(
    clip: Source, question: str, answer: dict[str, Any] | None = None, error: str | None = None
) -> Row:
    return {"clip": clip.name, "question": question, "answer": answer, "error": error}
