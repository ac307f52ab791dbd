"""Handlers that fill parts of the page by their names, and tell mistakes beside the field."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from html import escape
from typing import Any

from geotlm_lm import GeoTLMError

from .error_display import gradio

COMPLAINT = "complaint"
"""Name of the part that tells a mistake; emptied by whatever works."""

Filled = dict[str, Any]
"""New values of some parts, by their names; the others stay."""


def complaint() -> Any:
    """Return the component that tells a mistake, empty; screen readers read it out."""
    return gradio().HTML(
        "",
        html_template='<p role="alert">${value}</p>',
        js_on_load=None,
        apply_default_css=False,
        elem_classes=["complaint"],
    )


def filling(
    parts: Mapping[str, Any], function: Callable[..., Iterator[Filled]], takes: Any = None
) -> Callable[..., Iterator[dict[Any, Any]]]:
    """Return a handler of the toolkit that fills parts with what a function yields for their names.

    Args:
        parts: The page's, by name.
        function: Yields new values by name.
        takes: Class of the toolkit that the last argument is of: what is known of a click, or of
            the visit. None where there is none.
    """

    def fill(*given: Any) -> Iterator[dict[Any, Any]]:
        told: Filled | None = None
        # Emptied once: what runs on for long must not take away what another mistake has told.
        emptied: Filled = {COMPLAINT: ""}
        try:
            for told in function(*given):
                yield {parts[name]: value for name, value in (emptied | told).items()}
                emptied = {}
        except GeoTLMError as error:
            # A recording's name is part of the sentence, and anybody may have chosen it.
            yield {parts[COMPLAINT]: escape(str(error), quote=False)}
            return
        if told is None:  # of what yields nothing the toolkit would empty every part
            yield {parts[COMPLAINT]: ""}

    if takes is None:
        return fill

    # First: after the others, which are as many as the page gives, it would not be found.
    def fill_with(about: Any, *given: Any) -> Iterator[dict[Any, Any]]:
        yield from fill(*given, about)

    # Postponed annotations are text, and the toolkit looks for the class itself.
    fill_with.__annotations__["about"] = takes
    return fill_with
