"""Errors a user can repair, each one sentence with an exit code; checks of what a user asks for."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from importlib.util import find_spec

LONGEST_MESSAGE = 3000
"""Characters of a sentence: the longest lawful one names every shape, in 1,800."""


class GeoTLMError(Exception):
    """Something the user can repair: what was found, what was expected, what to do.

    Names and values that a file or a person chose stand in the sentence, so it is kept to one line
    of printable characters whatever these hold, and to a length; its end says what to do.
    """

    exit_code = 1

    def __init__(self, message: str = "") -> None:
        text = str(message)
        is_clean = text.isprintable()
        super().__init__(_shortened(text if is_clean else "".join(map(_printable, text))))


def _printable(character: str) -> str:
    if "\ud800" <= character <= "\udfff":  # a byte of a file's name that is no text
        return "\ufffd"
    return character if character.isprintable() else " "


def _shortened(text: str) -> str:
    if len(text) <= LONGEST_MESSAGE:
        return text
    return f"{text[: LONGEST_MESSAGE // 2]} ... {text[-(LONGEST_MESSAGE // 3) :]}"


class UsageError(GeoTLMError):
    """The call itself is wrong: an empty question, an unknown name, options that exclude others."""

    exit_code = 2


class Unsure(UsageError):
    """Words were not surely understood; `guess` says in plain ones what they most likely mean."""

    def __init__(self, message: str, guess: str) -> None:
        super().__init__(message)
        self.guess = guess


class Unwritten(UsageError):
    """A file cannot be written: the disk is full, or nothing may be written there."""


class UnreadableClip(GeoTLMError):
    """A file is missing, is not a recording, or holds no usable frames."""

    exit_code = 3


class TopicNeeded(UnreadableClip):
    """A bag holds images on several topics, or none on the one that was given."""


class IncompatibleBundle(GeoTLMError):
    """A model bundle is missing, incomplete, or of another format."""

    exit_code = 4


class Abstained(GeoTLMError):
    """The model would not answer, and the caller asked to treat that as a failure."""

    exit_code = 5


class BelowMinimum(GeoTLMError):
    """An evaluation fell below the accuracy the caller asked for."""

    exit_code = 6


class MissingDependency(GeoTLMError):
    """An optional package or a device is not there."""

    exit_code = 7


class TimedOut(GeoTLMError):
    """What was waited for did not hold in time."""

    exit_code = 8


class NotReached(GeoTLMError):
    """A recording ended before what was waited for held."""

    exit_code = 9


class Stalled(GeoTLMError):
    """A camera is there and gives no frames any more."""

    exit_code = 10


class IncompatibleWeights(IncompatibleBundle):
    """A released encoder's file is missing, damaged, or not what its name says."""


@contextmanager
def damage_as(sentence: str) -> Iterator[None]:
    """Turn whatever other libraries raise in the block into an `UnreadableClip` of this sentence.

    They believe what a damaged file says, and fail in a dozen ways.
    """
    try:
        yield
    except GeoTLMError:
        raise
    except Exception as error:
        raise UnreadableClip(sentence) from error


def require_package(name: str, needed_by: str, extra: str) -> None:
    """Refuse what needs a package that is not installed; `needed_by` begins the sentence.

    Raises:
        MissingDependency: If it is not, with the extra that installs it.
    """
    if find_spec(name) is None:
        raise MissingDependency(
            f"{needed_by}, which is not installed; run `pip install 'geotlm-lm[{extra}]'`."
        )


def first_line(error: Exception) -> str:
    """Return the first line of what an error of another library says, or else what it is."""
    return next(iter(str(error).strip().splitlines()), type(error).__name__)


def nearest(name: str, known: Iterable[str]) -> str | None:
    """Return the known name that an unknown one was most likely meant to be, if any is alike."""
    by_small = {candidate.lower(): candidate for candidate in known}
    matches = get_close_matches(name[:200].lower(), by_small, 1)
    return by_small[matches[0]] if matches else None


def choice_of(name: str, known: Iterable[str]) -> str:
    """Return how a sentence about an unknown name ends: the nearest known name, or all of them."""
    known = list(known)
    near = nearest(name, known)
    return f"choose one of {', '.join(known)}." if near is None else f"did you mean '{near}'?"


def require_inside(first: int, last: int, lowest: int, highest: int) -> None:
    """Refuse a span that runs backwards or leaves the recording; nothing is clamped."""
    if not lowest <= first < last <= highest:
        raise UsageError(
            f"Frames {first}:{last} were asked for, expected FIRST < LAST within "
            f"{lowest}:{highest}; give frame numbers inside the recording."
        )


OPEN_QUESTION = "Which way is it moving?"


def check_question(question: object) -> str:
    """Return a question without the white space around it; refuse an empty one, and no text."""
    if not isinstance(question, str):
        raise TypeError(
            f"a question is a text, found {type(question).__name__}; give one such as "
            f"'{OPEN_QUESTION}'"
        )
    if not question.strip():
        raise UsageError(f"The question is empty; ask something like '{OPEN_QUESTION}'.")
    # Bytes that a terminal could not decode arrive as lone surrogates, which no tokenizer takes.
    if any("\ud800" <= letter <= "\udfff" for letter in question):
        raise UsageError("The question holds bytes that are no text; give it in UTF-8.")
    return question.strip()
