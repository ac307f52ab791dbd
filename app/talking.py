"""The conversation of the Ask tab: ask, ask again, begin anew; what each part then shows."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from html import escape, unescape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import handlers, saving, stage
from .as_code import calls_of
from .clip_loading import LoadedClip
from .error_display import literal
from .facts import facts_of, fields_of, frame_preview
from .filling import Filled
from .opening import NOTHING_SAID, Source
from .suggestions import suggested

if TYPE_CHECKING:
    from geotlm_lm import Answerer

Messages = list[dict[str, Any]]


def _whole(shown: LoadedClip, source: Source) -> dict[str, Any]:
    return stage.stage_of(shown, source.name, shown.session.frame)


@dataclass
class Talking:
    """Answers the questions of the page.

    Args:
        answerer: The model.
        redraw: Returns what the stage shows once the size of a pixel is another.
    """

    answerer: Answerer
    redraw: Callable[[LoadedClip, Source], dict[str, Any]] = _whole

    def ask(
        self,
        question: str,
        chat: Messages,
        shown: LoadedClip | None,
        source: Source | None,
        facts: list[str],
        mm_per_px: float | None,
        address: str,
    ) -> Iterator[Filled]:
        """Yield the conversation word by word, and with the last all that stands beside."""
        before, said = [*(chat or []), _message("user", question)], ""
        field = {"question": ""}  # emptied once: what is typed meanwhile is the next question
        fields = fields_of(facts) | {"mm_per_px": mm_per_px or None}
        size_before = None if shown is None else shown.session.frame.mm_per_px
        for told_so_far in handlers.converse(self.answerer, shown, question, fields):
            if isinstance(told_so_far, str):
                said += told_so_far
                yield {"chat": [*before, _message("assistant", said)]} | field
                field = {}
            else:
                reply = told_so_far
        size = shown.session.frame.mm_per_px
        redrawn = {}
        if size != size_before:
            redrawn["stage"] = self.redraw(shown, source)
        chat = [*before, _message("assistant", reply.sentence)]
        yield field | {"chat": chat} | _beside(reply, shown, source, address) | redrawn

    def again(self, chat: Messages, shown: LoadedClip | None, *others: Any) -> Iterator[Filled]:
        """Ask the last question of the conversation again, in its old place."""
        asked = [place for place, one in enumerate(chat or []) if one["role"] == "user"]
        if not asked:
            return
        question = text_of(chat[asked[-1]])
        if shown is not None:
            shown.session.take_back(question)
        for told in self.ask(question, chat[: asked[-1]], shown, *others):
            yield {name: value for name, value in told.items() if name != "question"}

    def resize(
        self, shown: LoadedClip | None, source: Source | None, mm_per_px: float | None
    ) -> Iterator[Filled]:
        """Tell lengths by another size of a pixel, in the picture as well; 0 and None: in pixels.

        Raises:
            GeoTLMError: If no camera has pixels of that size.
        """
        size = mm_per_px or None
        if shown is None or size == shown.session.frame.mm_per_px:
            return
        shown.session.frame = replace(shown.session.frame, mm_per_px=size)
        yield {"stage": self.redraw(shown, source), "chips": suggested(shown)}

    def forget(
        self, shown: LoadedClip | None, source: Source | None, facts: list[str], *_: Any
    ) -> Iterator[Filled]:
        """Begin the conversation about the clip anew; the frame that the page shows still holds."""
        anew = None
        if shown is not None:
            anew = replace(shown, session=self.answerer.session(shown.encoded))
        yield NOTHING_SAID | {
            "shown": anew,
            "told": frame_preview(facts, None),
            "chips": suggested(anew),
            "saving": saving.offered(anew, source.example if source else None),
        }


def _beside(reply: Any, shown: LoadedClip, source: Source, address: str) -> Filled:
    frame = shown.session.frame
    stated = facts_of(frame)
    direction = None if reply.motion is None else reply.motion.value
    path = source.path if isinstance(source.path, str) else source.path[0]
    # The folder it was uploaded to means nothing to anybody.
    path = f"{'' if source.example is None else 'app/examples/'}{Path(path).name}"
    asked = [turn.question for turn in shown.session.history]
    calls = calls_of(path, asked, frame, source.span, address, source.topic)
    return {
        "notes": literal(reply.notes),
        "probabilities": reply.probabilities,
        "band": reply.band,
        "verdicts": reply.verdicts,
        "regions": reply.regions,
        "timing": reply.timing,
        "last": direction,
        "frame": stated,
        "mm_per_px": frame.mm_per_px or 0,
        "told": frame_preview(stated, direction),
        "command": calls.command,
        "python": calls.python,
        "rest": calls.rest,
        "chips": suggested(shown),
        "saving": saving.offered(shown, source.example),
    }


def _message(role: str, text: str) -> dict[str, Any]:
    """Return a message that the conversation shows as it is."""
    return {"role": role, "content": escape(text, quote=False)}


def text_of(message: dict[str, Any]) -> str:
    """Return a message's words; the toolkit hands them back as a list of blocks."""
    content = message["content"]
    if isinstance(content, str):
        return unescape(content)
    return unescape(" ".join(block.get("text", "") for block in content if isinstance(block, dict)))
