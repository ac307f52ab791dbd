"""Open a recording, read it again, or close it: what each part of the Ask tab then shows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geotlm_lm import FrameSpec, read_clip

from . import saving, stage
from .clip_loading import LoadedClip, latest_upload, load_clip, span_of
from .error_display import literal
from .example_clips import FIRST, Example, examples, perceived
from .facts import frame_preview
from .filling import Filled
from .limits import QUESTION_CHARACTERS
from .suggestions import suggested

if TYPE_CHECKING:
    from geotlm_lm import Answerer

NOTHING_SAID: Filled = {
    "chat": [],
    "notes": "",
    "probabilities": None,
    "band": "",
    "verdicts": None,
    "regions": None,
    "timing": "",
    "command": "",
    "python": "",
    "rest": "",
    "last": None,
}
"""The conversation and all that stands beside it, before anything was asked."""


EMPTY_FIELDS: Filled = {"first": "", "last_frame": "", "topic": ""}
"""What is asked for of a recording that was just opened."""


@dataclass(frozen=True)
class Source:
    """Where what is open comes from.

    Args:
        path: Of the recording, or of several images of it.
        name: As the page calls it.
        example: Its key, where it is an example.
        span: First and last frame, where only a part was read.
        topic: Of a bag's images, where it was named.
    """

    path: Any
    name: str
    example: str | None = None
    span: tuple[int, int] | None = None
    topic: str | None = None


@dataclass
class Before:
    """What the page shows when something else is opened.

    Args:
        facts: That are checked.
        mm_per_px: Size of a pixel; 0 or None where it is not known.
        shown: The clip that is open.
    """

    facts: list[str]
    mm_per_px: float | None = None
    shown: LoadedClip | None = None


@dataclass
class Opening:
    """Opens recordings.

    Args:
        answerer: The model.
        known: Examples that it has looked at: everybody opens the same.
    """

    answerer: Answerer
    known: dict[str, LoadedClip] = field(default_factory=dict)

    def upload(self, paths: list[str] | None, *before: Any) -> Iterator[Filled]:
        """Open what was given last; close everything where all was taken away."""
        given = latest_upload(paths)
        fields = EMPTY_FIELDS | ({} if given == paths else {"files": given})
        if not given:
            yield _closed(Before(*before)) | fields | {"files": None}
            return
        source = Source(given, Path(given[0]).name if len(given) == 1 else "images")
        for told in self._open(source, Before(*before)):
            yield told | fields

    def example(self, key: str, *before: Any) -> Iterator[Filled]:
        """Open an example, and take away what was uploaded; one that is not known changes nothing.

        It plays before the model has looked at it.
        """
        example = examples().get(key)
        if example is None:
            return
        fields = EMPTY_FIELDS | {"files": None}
        yield _closed(Before(*before)) | fields | self.frames(example)
        yield from self._open(_source(example), Before(*before))

    def frames(self, example: Example) -> Filled:
        """Return an example as it plays before the model has looked at it."""
        return {"stage": stage.opening(read_clip(example.path), example.name)}

    def visit(self, query: Mapping[str, str]) -> Iterator[Filled]:
        """Show the example and the question of a link, or the first example; nothing is asked."""
        example = examples().get(query.get("example", FIRST), examples()[FIRST])
        question = query.get("q", "")[:QUESTION_CHARACTERS]
        yield self.frames(example) | {"source": _source(example), "question": question}

    def read_again(
        self, source: Source | None, first: str, last: str, topic: str | None, *before: Any
    ) -> Iterator[Filled]:
        """Read what is open anew, a span of it, or another topic."""
        if source is not None:
            # The toolkit's field that was never filled holds None.
            source = replace(source, topic=(topic or "").strip() or None)
            yield from self._open(source, Before(*before), first, last)

    def _open(
        self, source: Source, before: Before, first: str = "", last: str = ""
    ) -> Iterator[Filled]:
        # A mistake is told only after the clip before is closed: it must not answer for this one.
        try:
            span = span_of(first, last)
            if source.example and span is None:
                shown = perceived(self.answerer, examples()[source.example], self.known)
            else:
                shown = load_clip(self.answerer, source.path, first, last, source.topic)
            yield _opened(shown, replace(source, span=span), before)
        except Exception:
            yield _closed(before) | {"source": source}
            raise


def _source(example: Example) -> Source:
    return Source(example.path, example.name, example.key)


def _opened(shown: LoadedClip, source: Source, before: Before) -> Filled:
    mm_per_px = before.mm_per_px or None
    if before.shown is not None and _size(before.shown) != _size(shown):
        mm_per_px = None  # what was said of other pixels
    frame = FrameSpec(mm_per_px=mm_per_px)
    return NOTHING_SAID | {
        "shown": shown,
        "source": source,
        "stage": stage.stage_of(shown, source.name, frame),
        "clip_notes": literal(shown.notes),
        "told": frame_preview(before.facts, None)[1],
        "mm_per_px": mm_per_px or 0,
        "chips": suggested(shown),
        "saving": saving.offered(shown, source.example),
    }


def _closed(before: Before) -> Filled:
    """Return what is shown when no clip is; the size of a pixel goes with the clip it was of."""
    return NOTHING_SAID | {
        "shown": None,
        "source": None,
        "stage": {},
        "clip_notes": "",
        "told": frame_preview(before.facts, None)[1],
        "mm_per_px": before.mm_per_px if before.shown is None else 0,
        "chips": [],
        "saving": saving.offered(None, None),
    }


def _size(shown: LoadedClip) -> tuple[int, int]:
    return shown.encoded.clip.frames.shape[1:3]
