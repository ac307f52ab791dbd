"""Show repairable errors in the page as one sentence; defects keep their traces on the console."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import wraps
from html import escape
from inspect import isgeneratorfunction
from typing import Any

from geotlm_lm import GeoTLMError
from geotlm_lm.core.errors import MissingDependency

from .budget import TITLE, Busy
from .limits import AT_ONCE
from .turns import LISTENER


def gradio() -> Any:
    """Return the toolkit, imported only now: the package works without it.

    Raises:
        MissingDependency: If it is not installed.
    """
    try:
        import gradio as gr
    except ImportError as error:
        raise MissingDependency(
            "The app needs gradio, which is not installed; run `pip install 'geotlm-lm[app]'`."
        ) from error
    return gr


def with_errors_shown(function: Callable[..., Any], *, is_page: bool = True) -> Callable[..., Any]:
    """Return the function with its repairable errors told by the toolkit.

    Args:
        function: A handler, or a generator of its results.
        is_page: Whether the sentence is shown in the page, which takes it for HTML; programs get
            it as it is.
    """
    if isgeneratorfunction(function):

        @wraps(function)
        def generate(*arguments: Any, **named: Any) -> Any:
            try:
                yield from function(*arguments, **named)
            except GeoTLMError as error:
                raise _shown(error, is_page) from error

        return generate

    @wraps(function)
    def call(*arguments: Any, **named: Any) -> Any:
        try:
            return function(*arguments, **named)
        except GeoTLMError as error:
            raise _shown(error, is_page) from error

    return call


def _shown(error: GeoTLMError, is_page: bool) -> Exception:
    # A recording's name is part of the sentence, and anybody may have chosen it.
    sentence = escape(str(error), quote=False) if is_page else str(error)
    title = {"title": TITLE} if isinstance(error, Busy) else {}
    return gradio().Error(sentence, print_exception=False, **title)


MARKUP = re.compile(r"[!-,./:-@\[-`{-~]")
"""All that may mean anything else than itself in Markdown, HTML or a formula: punctuation, without
the dash that begins an entry of a list."""


def literal(text: str) -> str:
    """Return a text as Markdown that shows it as it is.

    Words may hold what a person typed, or what somebody called a file: shown as markup, a picture
    in them would be fetched from its site, and a link would lead there.

    Args:
        text: Any; lines that begin with a dash are a list all the same.
    """
    return MARKUP.sub(r"\\\g<0>", text)


MODEL_LINE = "model"

MODEL = {"concurrency_limit": AT_ONCE, "concurrency_id": MODEL_LINE}
"""Uses of the model are worked on at once and take turns at it (`turns`); those of one visitor wait
for each other (`session_order`)."""

CAMERA = {"concurrency_limit": AT_ONCE, "concurrency_id": "camera"}
"""What is watched goes on for as long as it likes: it must not hold up its visitor's questions."""


def tell_progress(what: str, done: int, total: int) -> None:
    """Show how far a request is, where its results will stand; or tell whoever listens instead."""
    if (listener := LISTENER.get()) is not None:
        listener(what, done, total)
    else:
        gradio().Progress()((done, total), desc=what)


def model_at(*parts: Any) -> dict[str, Any]:
    """Return the options of a page's event that uses the model.

    Args:
        parts: Where it is seen that it runs, or failed; else every part that it fills would say so.
    """
    return {"api_visibility": "private", "show_progress_on": list(parts), **MODEL}
