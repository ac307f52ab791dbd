"""Options that go together, declared once as a dataclass and taken whole by several commands."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from functools import wraps
from inspect import Parameter, Signature, signature
from typing import TYPE_CHECKING, Any, get_type_hints

from geotlm_lm.cli.options import (
    Background,
    BundleFolder,
    FramesPerSecond,
    LayoutName,
    MmPerPixel,
    SquarePixels,
    TopicName,
)
from geotlm_lm.core.frame_spec import FrameSpec

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer


@dataclass(frozen=True)
class Reading:
    """How a recording is read: options of `read_clip`, by their names."""

    layout: LayoutName = None
    background: Background = None
    fps: FramesPerSecond = None
    square_pixels: SquarePixels = None
    topic: TopicName = None


@dataclass(frozen=True)
class Answering:
    """Which model answers, and in which unit of length."""

    mm_per_px: MmPerPixel = None
    model: BundleFolder = None

    @property
    def frame(self) -> FrameSpec:
        """The frame that answers are told in.

        Raises:
            UsageError: If no pixel is of that size.
        """
        return FrameSpec(mm_per_px=self.mm_per_px)

    def load(self) -> Answerer:
        """Load the model; its libraries only now, so that a wrong path need not wait for them."""
        from geotlm_lm.answering import Answerer

        return Answerer.load(self.model)


def grouped(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command with the fields of its dataclasses as options in their place.

    Args:
        command: Takes all by keyword; what is annotated with a dataclass is given whole.
    """
    hints, groups = get_type_hints(command, include_extras=True), {}
    parameters: list[Parameter] = []
    for one in signature(command).parameters.values():
        hint = hints[one.name]
        if not is_dataclass(hint):
            parameters.append(one.replace(annotation=hint))
            continue
        own, groups[one.name] = get_type_hints(hint, include_extras=True), hint
        parameters += [
            Parameter(field.name, one.kind, default=field.default, annotation=own[field.name])
            for field in fields(hint)
        ]

    @wraps(command)
    def call(**given: Any) -> None:
        for name, group in groups.items():
            given[name] = group(**{field.name: given.pop(field.name) for field in fields(group)})
        command(**given)

    call.__signature__ = Signature(parameters)
    call.__annotations__ = {one.name: one.annotation for one in parameters}
    return call


def given_of(group: Any) -> dict[str, Any]:
    """Return which options of a group were given, by their names on the command line."""
    given = ((name, value) for name, value in vars(group).items() if value is not None)
    return {f"--{name.replace('_', '-')}": value for name, value in given}
