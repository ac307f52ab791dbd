"""What recordings tools may be given: by name, inside a message, or as an upload; nothing else."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from geotlm_lm import GeoTLMError

from .limits import NAME_CHARACTERS
from .recordings_folder import RecordingsFolder
from .results import Listing
from .uploads import Uploads

EXAMPLE = "example:"
"""Beginning of an example's name."""

EXAMPLES = {
    f"{EXAMPLE}{path.stem}": path
    for path in sorted((Path(__file__).parent / "examples").glob("*.npz"))
}


class Sources:
    """Finds a recording, whatever it was given as.

    Args:
        uploads: Holds what was sent.
        folder: Of the recordings that are served by name; None for none.
    """

    def __init__(self, uploads: Uploads, folder: RecordingsFolder | None = None) -> None:
        self._uploads, self._folder = uploads, folder

    def listing(self) -> Listing:
        """Return the names that can be given, with the kind and the size of each."""
        stored, has_more = ([], False) if self._folder is None else self._folder.listing()
        return {
            "recordings": [
                {"name": one.name, "kind": one.kind, "size_bytes": one.size_bytes} for one in stored
            ],
            "examples": list(EXAMPLES),
            "is_folder_served": self._folder is not None,
            "has_more": has_more,
        }

    @contextmanager
    def opened(self, given: str) -> Iterator[Path]:
        """Yield where a recording lies; one that came inside a message is removed afterwards.

        Raises:
            GeoTLMError: If it is none that can be given, in one sentence.
        """
        if given.startswith("data:"):
            with self._uploads.unpacked(given) as path:
                yield path
            return
        if given.startswith(EXAMPLE):
            if given not in EXAMPLES:
                raise GeoTLMError(
                    f"There is no example {given[:80]!r}; the tool recordings lists them."
                )
            yield EXAMPLES[given]
            return
        if self._uploads.holds(given):
            path = Path(self._uploads.path_of(given))
            if not path.is_file():
                raise GeoTLMError("The upload is not on the server any more; send the file again.")
            yield path
            return
        yield self._named(given)

    def _named(self, name: str) -> Path:
        if len(name) > NAME_CHARACTERS or "://" in name or name.startswith(("/", "\\")):
            raise GeoTLMError(
                "The recording is neither a name nor a data URI nor an upload; give a name that "
                "the tool recordings lists, or send the file itself, in Python by "
                "handle_file('clip.npz'), elsewhere as 'data:;base64,...'."
            )
        if self._folder is None:
            listed = f" such as {next(iter(EXAMPLES))!r}" if EXAMPLES else ""
            raise GeoTLMError(
                f"There is no recording {name[:80]!r}, as no folder is served; name an example"
                f"{listed}, or start the server with --recordings FOLDER."
            )
        return self._folder.path_of(name)
