"""`geotlm-lm answer`: one question about one clip; the answer alone goes to stdout."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from geotlm_lm.cli.options import Answering, AsJson, Recording, RerunOutput, grouped, option
from geotlm_lm.cli.progress import print_notes
from geotlm_lm.core.errors import Abstained, check_question

if TYPE_CHECKING:
    from geotlm_lm.answering import Answer
    from geotlm_lm.answering.encoded import Encoded


@grouped
def answer(
    *,
    recording: Recording,
    question: str = option("The question, in plain English.", "--q"),
    as_json: AsJson = False,
    answering: Answering,
    why: bool = option("Print the reasons before the answer, one a line.", "--why", default=False),
    fail_on_abstain: bool = option(
        "Exit with code 5 if the model will not say.", "--fail-on-abstain", default=False
    ),
    outputs: RerunOutput,
) -> None:
    """Answer a question about a clip.

    Directions are told as seen in the camera image, for the object relative to the sensor. Notes on
    what was guessed go to stderr.

    Example: geotlm-lm answer clip.npz --q 'Is it turning clockwise?' --json
    """
    check_question(question)
    path, span, frame = recording.path, recording.span, answering.frame
    outputs.require([path])
    clip = recording.read()

    from geotlm_lm.answering.pipeline import PIXELS_NOTE

    answerer = answering.load()
    encoded = answerer.encode(clip, span=span)
    reply = answerer.ask(encoded, question, frame=frame)
    print_notes(*(note for note in reply.notes if not note.startswith(PIXELS_NOTE)))
    reasons = answerer.why(encoded, reply) if why else None
    if reasons is not None:
        print_notes(f"the reasons are told {reasons.source}")
    if as_json:
        more = {} if reasons is None else {"why": asdict(reasons)}
        print(json.dumps(reply.to_dict() | more))
    else:
        print("\n".join((*(reasons.steps[:-1] if reasons else ()), reply.text)))
    if outputs.rerun is not None:
        from geotlm_lm.track.rerun_log import write_or_serve

        scale = frame.mm_per_px
        write_or_serve(outputs.rerun, lambda rrd: _log(rrd, encoded, question, reply, scale))
    if fail_on_abstain and reply.abstained:
        raise Abstained(
            f"{path}: the model would not answer; see `geotlm-lm info {path}` for contact, or give "
            f"a part with more motion by --frames."
        )


def _log(
    path: Path, encoded: Encoded, question: str, reply: Answer, mm_per_px: float | None
) -> None:
    """Write the recording, the question and the answer for the Rerun viewer."""
    from geotlm_lm.track.export import Exported
    from geotlm_lm.track.rerun_log import log_answer, log_clip, log_track, rerun_recording

    with rerun_recording(path) as stream:
        if encoded.track is None:
            log_clip(stream, encoded.clip)
        else:
            log_track(stream, Exported(encoded.track, mm_per_px), encoded.recording)
        log_answer(stream, question, reply.text, reply.notes)
