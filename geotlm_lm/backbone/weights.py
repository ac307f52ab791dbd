"""Named tensors from a file that others made: safetensors or a torch pickle, nothing executed.

Knows nothing of the encoders the tensors belong to.
"""

from __future__ import annotations

import argparse
import sys
from _compat_pickle import IMPORT_MAPPING
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError
from safetensors.torch import load_file
from torch import Tensor

from geotlm_lm.core.errors import IncompatibleWeights

CONTAINERS = ("model", "state_dict")
"""Levels under which training programs keep weights beside their own state."""

WRAPPERS = ("module.", "_orig_mod.")
"""What data-parallel training and compilation put before every name."""

_ZIP, _PICKLE = b"PK\x03\x04", b"\x80"


def read_tensors(path: Path) -> dict[str, Tensor]:
    """Return the tensors of a checkpoint by name, on the CPU, in the type they are stored in.

    Args:
        path: A safetensors file, or what `torch.save` wrote, with or without a level of `model` or
            `state_dict` and foreign objects beside it.

    Raises:
        IncompatibleWeights: If the file is missing, damaged, of another kind, holds no named
            tensors, or would run code when unpickled the ordinary way.
    """
    start = _first_bytes(path)
    try:
        if start[8:9] == b"{":  # safetensors: eight bytes of header length, then JSON
            stored = load_file(path)
        elif start.startswith((_ZIP, _PICKLE)):
            stored = _unpickled(path, start.startswith(_ZIP))
        else:
            raise _refused(path, _what_else(start))
    except (SafetensorError, ValueError) as error:
        raise _refused(path, f"is damaged or cut short ({_one_line(error)})") from error
    for level in CONTAINERS:
        if isinstance(stored, dict) and isinstance(stored.get(level), dict):
            stored = stored[level]
    tensors = _tensors_of(stored)
    if not tensors:
        raise _refused(path, "holds no named tensors")
    return tensors


def _first_bytes(path: Path) -> bytes:
    if path.is_dir():
        raise IncompatibleWeights(f"{path} is a folder, expected an encoder's file; name the file.")
    try:
        with path.open("rb") as stream:
            return stream.read(64)
    except OSError as error:
        raise IncompatibleWeights(
            f"{path}: cannot be read ({error.strerror}); give the file the encoder's authors "
            f"release."
        ) from error


def _unpickled(path: Path, is_zip: bool) -> Any:
    """Load a pickle through torch's restricted loader; foreign classes become empty stand-ins."""
    try:
        return torch.load(path, map_location="cpu", weights_only=True, mmap=is_zip)
    except Exception as error:
        if not is_zip:
            raise _refused(path, f"cannot be read safely ({_one_line(error)})") from error
    try:
        names = torch.serialization.get_unsafe_globals_in_checkpoint(path)
    except Exception as error:
        raise _refused(path, f"is damaged or cut short ({_one_line(error)})") from error
    dangerous = sorted(filter(_may_run_code, map(_name_today, names)))
    if dangerous:
        raise IncompatibleWeights(
            f"{path}: would call {dangerous[0]} when unpickled, which no weights need; do not open "
            f"it, get the file from the encoder's authors."
        )
    try:
        with torch.serialization.safe_globals([_stand_in(name) for name in names]):
            return torch.load(path, map_location="cpu", weights_only=True, mmap=True)
    except Exception as error:
        raise _refused(path, f"cannot be read safely ({_one_line(error)})") from error


class _StandIn:
    """An object of a class that need not be installed: takes anything, does nothing."""

    def __new__(cls, *_: Any, **__: Any) -> _StandIn:
        return object.__new__(cls)

    def __init__(self, *_: Any, **__: Any) -> None: ...

    def __setstate__(self, _: Any) -> None: ...


_HARMLESS: dict[str, Callable] = {
    "argparse.Namespace": argparse.Namespace,
    "builtins.dict": dict,
    "builtins.list": list,
    "builtins.set": set,
    "builtins.int": int,
    "builtins.float": float,
    # The restricted loader fills only what is a `dict` or a `list`.
    "collections.defaultdict": lambda *_: {},
    "collections.deque": lambda *_: [],
}
"""What is loaded as itself, or as the plain form of itself."""

_INERT = (
    *("pathlib.", "datetime.", "enum.", "typing.", "decimal.", "fractions.", "uuid."),
    *(f"builtins.{name}" for name in ("bytearray", "bytes", "complex", "frozenset", "object")),
    *("builtins.range", "builtins.slice", "builtins.tuple", "collections.Counter"),
    *("_codecs.encode", "copyreg._reconstructor", "functools.partial", "types.SimpleNamespace"),
)
"""Parts of the standard library in which training programs keep their state, numpy's arrays among
it; they become stand-ins too, so that even `partial` calls nothing."""


def _name_today(name: str) -> str:
    """Return a name as Python 3 has it: pickles of torch write modules by their Python 2 names."""
    module, _, own = name.rpartition(".")
    return f"{IMPORT_MAPPING.get(module, module)}.{own}"


def _may_run_code(name: str) -> bool:
    """Tell whether a name belongs to Python itself and is not known to be mere data.

    Names of other packages are never imported, whatever they do there.
    """
    belongs_to_python = name.split(".")[0] in sys.stdlib_module_names
    return belongs_to_python and name not in _HARMLESS and not name.startswith(_INERT)


def _stand_in(name: str) -> tuple[Callable, str]:
    return _HARMLESS.get(_name_today(name)) or type(name, (_StandIn,), {}), name


def _tensors_of(stored: Any) -> dict[str, Tensor]:
    if not isinstance(stored, dict):
        return {}
    named = {
        name: value
        for name, value in stored.items()
        if isinstance(name, str) and isinstance(value, Tensor)
    }
    for wrapper in WRAPPERS:
        if named and all(name.startswith(wrapper) for name in named):
            named = without_prefix(named, wrapper)
    return named


def without_prefix(tensors: dict[str, Tensor], prefix: str) -> dict[str, Tensor]:
    """Return the tensors whose names start with `prefix`, named without it."""
    return {
        name[len(prefix) :]: value for name, value in tensors.items() if name.startswith(prefix)
    }


def listed(names: Iterable[str]) -> str:
    """Return the first three of `names` as words, and how many there are when some are left out."""
    names = list(names)
    shown = ", ".join(names[:3]) or "nothing"
    return shown if len(names) <= 3 else f"{shown} ... ({len(names)} names)"


def _what_else(start: bytes) -> str:
    if not start:
        return "is empty"
    if start.startswith(b"version https://git-lfs"):
        return "is a Git LFS pointer, not the weights themselves"
    if start.lstrip().startswith((b"<!", b"<html")):
        return "is a web page, as a download without access gives"
    return "is neither a safetensors file nor a PyTorch checkpoint"


def _refused(path: Path, reason: str) -> IncompatibleWeights:
    return IncompatibleWeights(f"{path}: {reason}; get the file the encoder's authors release.")


def _one_line(error: Exception) -> str:
    """Return what the error says, of torch's long advice only the reason in it."""
    text = str(error).partition("WeightsUnpickler error: ")[2] or str(error)
    lines = text.strip().splitlines() or [type(error).__name__]
    return lines[0][:120].rstrip(". ")
