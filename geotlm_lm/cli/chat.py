"""`geotlm-lm chat`: questions about clips, one a line; the model is loaded once."""

from __future__ import annotations

import json
import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from geotlm_lm.cli.options import Answering, Reading, Recording, grouped
from geotlm_lm.cli.progress import print_notes
from geotlm_lm.core.errors import GeoTLMError, UsageError, choice_of
from geotlm_lm.core.frame_spec import FrameSpec

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer, Encoded, Session

PROMPT = "> "

HELP = """Ask a question, or state a fact about the recording ("the image is mirrored").
/clip PATH   look at another clip; the one before stays for comparisons
/frame       what is known of the frame; /frame FACTS adds facts, /frame reset forgets them
/why         the reasons for the last answer
/evidence    the geometry the last clip shows, as JSON
/history     the conversation so far
/json        answer in JSON from now on; again: in words
/quit        leave; so does the end of the input"""


@grouped
def chat(*, recording: Recording, answering: Answering) -> None:
    """Talk about a clip; questions come from the terminal or from a pipe, one a line.

    Answers go to stdout, notes and mistakes to stderr. /help lists the commands.

    Example: geotlm-lm chat clip.npz
    """
    span, frame = recording.span, answering.frame
    clip = recording.read()
    answerer = answering.load()
    encoded = answerer.encode(clip, span=span)
    Conversation(answerer, encoded, frame, replace(recording.reading, background=None)).run()


_WITHOUT_STROKE = {"quit": "/quit", "exit": "/quit", "bye": "/quit", "help": "/help"}
"""Commands that people type without their stroke; none of them asks about a clip."""


class Conversation:
    """What the lines of the input do; later recordings are read as `reading` has it."""

    def __init__(
        self, answerer: Answerer, encoded: Encoded, frame: FrameSpec, reading: Reading
    ) -> None:
        self.answerer, self._reading = answerer, reading
        self.session: Session = answerer.session(encoded, frame)
        self.is_json = False
        print_notes(*encoded.clip.notes)

    def run(self) -> None:
        """Answer line after line until /quit or the end of the input."""
        is_person = sys.stdin.isatty()
        if is_person:
            print("Ask how the touched object moves; /help lists the commands.", file=sys.stderr)
        while True:
            if is_person:
                print(PROMPT, end="", file=sys.stderr, flush=True)
            line = sys.stdin.readline()
            if not line or not self.take(line.strip()):
                return

    def take(self, line: str) -> bool:
        """Act on one line; return whether the conversation goes on."""
        command, _, rest = _WITHOUT_STROKE.get(line.lower().rstrip("!. "), line).partition(" ")
        if command == "/quit":
            return False
        try:
            self._act(command, rest.strip(), line)
        except GeoTLMError as error:
            # A mistake in one line must not end the conversation.
            print(str(error), file=sys.stderr)
        sys.stdout.flush()
        return True

    def _act(self, command: str, rest: str, line: str) -> None:
        match command:
            case "":
                pass
            case "/help":
                print(HELP)
            case "/clip":
                self._clip(rest)
            case "/frame":
                self._frame(rest)
            case "/why":
                self._why()
            case "/evidence":
                from geotlm_lm.answering.encoded import regions_of

                print(json.dumps(regions_of(self.session.encoded)))
            case "/history":
                for turn in self.session.history:
                    print(f"{PROMPT}{turn.question}\n{turn.answer.text}")
            case "/json":
                self.is_json = not self.is_json
                words = "in JSON" if self.is_json else "in words"
                print(f"answers {words}", file=sys.stderr)
            case _ if command.startswith("/"):
                known = ["/help", *re.findall("^/[a-z]+", HELP, re.MULTILINE)]
                print(f"there is no {command}; {choice_of(command, known)}", file=sys.stderr)
            case _:
                reply = self.session.ask(line)
                print(json.dumps(reply.to_dict()) if self.is_json else reply.text)
                if reply.abstained and not self.is_json:  # of a form that has no words for it
                    print_notes(*getattr(reply, "withheld", ()))

    def _clip(self, path: str) -> None:
        if not path:
            print("/clip needs a path, such as /clip other.npz.", file=sys.stderr)
            return
        from geotlm_lm.recordings.read import read_clip

        encoded = self.answerer.encode(read_clip(Path(path), **vars(self._reading)))
        self.session.add_clip(encoded)
        print_notes(*encoded.clip.notes)
        print(f"Looking at {path}; {len(self.session.clips)} clips are open.")

    def _frame(self, facts: str) -> None:
        if facts == "reset":
            self.session.frame = FrameSpec()
        elif facts:
            self.session.frame = self._stated(facts)
        print(f"Frame: {self.session.frame.summary()}.")

    def _stated(self, facts: str) -> FrameSpec:
        """Return the frame in which some facts hold as well."""
        from geotlm_lm.answering.understanding import understand
        from geotlm_lm.query.evaluate import with_facts

        understood = understand(self.answerer.bundle.reader, facts)
        if understood.ask_back is not None:
            raise UsageError(understood.ask_back)
        if understood.program.answers or not understood.program.facts:
            raise UsageError(
                f"'{facts}' is no fact I know; say for example 'left-hand thread', 'the image is "
                f"mirrored' or 'I look from the object's side'."
            )
        columns = self.session.encoded.clip.frames.shape[2]
        return with_facts(self.session.frame, understood.program.facts, columns)

    def _why(self) -> None:
        last = self.session.last
        turn = next((turn for turn in self.session.history if turn.answer is last), None)
        if getattr(last, "evidence", None) is None:
            print("there is no answer about one clip yet; ask a question first.", file=sys.stderr)
            return
        reasons = self.answerer.why(turn.encoded, turn.answer)
        if turn.encoded is not self.session.encoded:
            print("Of the clip before:")
        print("\n".join(reasons.steps))
        print_notes(f"told {reasons.source}")
