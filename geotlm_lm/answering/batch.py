"""Answer many questions about many recordings into JSON lines; interrupted runs are resumed.

What each clip's questions gave is kept in `NAME.part` while the run lasts, a line a clip in the
order in which they are done; in the order of the clips it takes the place of NAME when it is
complete, so that a reader of NAME never sees half a table.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from geotlm_lm.answering.encoded import Encoded
from geotlm_lm.answering.schema import answer_schema
from geotlm_lm.core.errors import GeoTLMError, UsageError
from geotlm_lm.core.files import append_text, only_writer, replacing, write_text_atomically
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.workers import ALONE, LOST, Workers

if TYPE_CHECKING:
    from geotlm_lm.answering.answerer import Answerer
    from geotlm_lm.core.clip import Clip

CAMERA = FrameSpec()

PART_VERSION = 3
"""Of what a stopped run leaves: another version's is not continued."""

Progress = Callable[[int, int], None]
"""Called with the number of clips done, and of all."""


class Source(Protocol):
    """What is asked about: a recording, or an episode; processes are sent it, and read it there."""

    @property
    def name(self) -> str:
        """What its rows call it."""

    def read(self) -> Clip:
        """Return its frames.

        Raises:
            GeoTLMError: If it cannot be read.
        """

    @property
    def seen_at(self) -> Path:
        """What a machine that reads it must have."""

    def stamp(self) -> list[Any]:
        """Return what changes when it does or is read otherwise, plain JSON values."""


@dataclass(frozen=True)
class BatchResult:
    """What a run wrote.

    Args:
        rows: Rows in the file, one per clip and question.
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
    progress: Progress = lambda done, total: None,
) -> BatchResult:
    """Write one row per clip and question to `out`, as JSON lines.

    A row holds clip, question, answer (as in the published schema) and error; of the last two one
    is null. A clip that cannot be read, or a question that cannot be asked, gives rows with the
    error's one sentence; so does one that ends the process which reads it, but for `ALONE`, where
    that is this process. A run that was stopped continues with the clips that it had not done.

    Args:
        load: Returns the model, the same object every time; each process asks its own.
        clips: What is asked about.
        questions: What to ask about each.
        out: The file to write.
        frame: What is known of how all of them were taken.
        workers: Who answers; but for the times in them, rows do not depend on it.
        progress: Told how many clips are done.

    Raises:
        UsageError: If an unfinished run of other clips, questions, frame or reading, or of
            another model or version, lies beside `out`, or a file that is none, or if another
            process is at it.
        Unwritten: If the rows cannot be written.
        GeoTLMError: If no worker can be started.
        ValueError: If there is no question.
    """
    if not questions:
        raise ValueError("a run takes 1 question or more, found none")
    part = out.with_name(f"{out.name}.part")
    settings = _settings(load(), clips, questions, frame)
    with only_writer(part) as is_alone:
        if not is_alone:
            raise UsageError(
                f"{part}: another run is writing it, expected one at a time; wait for it, or give "
                f"another --out."
            )
        there = _resumable(part, settings)
        if not there:
            write_text_atomically(part, f"{json.dumps(settings)}\n")
        work = partial(_numbered_rows, load, questions, frame)
        lost = partial(_lost_rows, questions)
        missing = [(number, clip) for number, clip in enumerate(clips) if number not in there]
        seen = sorted({clip.seen_at for _, clip in missing})
        each = workers.each_done(work, missing, seen=seen, lost=lost)
        for done, told in enumerate(each, len(there) + 1):
            append_text(part, f"{json.dumps(told)}\n")
            progress(done, len(clips))
        errors = _replace_output(part, out)
    return BatchResult(len(clips) * len(questions), errors, len(there) * len(questions))


def _numbered_rows(
    load: Callable[[], Answerer],
    questions: Sequence[str],
    frame: FrameSpec,
    numbered: tuple[int, Source],
) -> dict[str, Any]:
    """Return what a run keeps of one clip."""
    number, clip = numbered
    return {"clip": number, "rows": list(rows_of(load(), clip, questions, frame))}


def _lost_rows(questions: Sequence[str], numbered: tuple[int, Source]) -> dict[str, Any]:
    """Return what a run keeps of a clip that ends the process which asks about it."""
    number, clip = numbered
    row = {"clip": clip.name, "answer": None, "error": f"{clip.name}: {LOST}"}
    return {"clip": number, "rows": [row | {"question": question} for question in questions]}


def _replace_output(part: Path, out: Path) -> int:
    """Let the rows of a complete run take the place of `out`; return how many hold an error."""
    places, errors = {}, 0
    with part.open("rb") as written, replacing(out) as stream:
        written.readline()  # what the run was of
        place = written.tell()
        for line in iter(written.readline, b""):
            places[json.loads(line)["clip"]] = place
            place = written.tell()
        for _, place in sorted(places.items()):
            written.seek(place)
            for row in json.loads(written.readline())["rows"]:
                stream.write(f"{json.dumps(row)}\n".encode())
                errors += row["error"] is not None
    part.unlink()
    return errors


def rows_of(
    answerer: Answerer,
    clip: Source,
    questions: Sequence[str],
    frame: FrameSpec = CAMERA,
) -> Iterator[dict[str, Any]]:
    """Yield the rows of one clip, which is encoded once."""
    encoded, error = _encode(answerer, clip)
    for question in questions:
        answer = None
        if encoded is not None:
            try:
                answer, error = answerer.ask(encoded, question, frame=frame).to_dict(), None
            except GeoTLMError as refused:
                error = str(refused)
        yield {"clip": clip.name, "question": question, "answer": answer, "error": error}


def _encode(answerer: Answerer, clip: Source) -> tuple[Encoded | None, str | None]:
    try:
        return answerer.encode(clip.read()), None
    except GeoTLMError as error:
        return None, str(error)


def _settings(
    answerer: Answerer,
    clips: Sequence[Source],
    questions: Sequence[str],
    frame: FrameSpec,
) -> dict[str, Any]:
    """Return what decides the rows, so that no other run's are taken for them.

    The schema is among it: a run that an older version began had other fields.
    """
    asked = [list(questions), frame.to_dict()]
    told = json.dumps([[clip.stamp() for clip in clips], asked, answer_schema()])
    digest = hashlib.sha256(told.encode()).hexdigest()[:16]
    return {"format": PART_VERSION, "model": answerer.bundle.digest(), "asked": digest}


def _resumable(part: Path, settings: dict[str, Any]) -> set[int]:
    """Return the numbers of the clips that a stopped run had done; half a line is cut off."""
    done: set[int] = set()
    if not part.exists() or part.stat().st_size == 0:
        return done
    with part.open("r+b") as stream:
        first = stream.readline()
        if not first.endswith(b"\n") or _parsed(first) != settings:
            raise UsageError(
                f"{part}: belongs to a run of other clips, questions or facts, or of another model "
                f"or version, expected this one's; delete it to begin anew, or give another --out."
            )
        end = stream.tell()
        for number, line in enumerate(iter(stream.readline, b""), start=1):
            if not line.endswith(b"\n"):
                break
            told = _parsed(line)
            if not isinstance(told, dict) or set(told) != {"clip", "rows"}:
                raise UsageError(
                    f"{part}: its line {number} is damaged, expected one JSON object a line; "
                    f"delete the file to begin anew, or give another --out."
                )
            done.add(told["clip"])
            end = stream.tell()
        stream.truncate(end)
    return done


def _parsed(line: bytes) -> Any:
    """Return what a line holds; None where it is no JSON."""
    try:
        return json.loads(line)
    except (ValueError, RecursionError):
        return None
