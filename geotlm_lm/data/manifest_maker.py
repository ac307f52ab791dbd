"""A manifest from a folder of frames whose names say what they are, by the user's own pattern."""

from __future__ import annotations

import os
import re
from collections import Counter, defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.data.manifest_rows import ACTIONS, ManifestRow
from geotlm_lm.recordings.frame_order import natural_order
from geotlm_lm.recordings.images import IMAGE_SUFFIXES

GROUPS = ("object", "sensor", "action", "trial", "frame")
REQUIRED_GROUPS = ("object", "action")


@dataclass(frozen=True)
class MadeManifest:
    """What a pattern found.

    Args:
        rows: One per clip, in natural order of their names.
        unmatched: Images whose paths the pattern does not fit.
        too_short: Clips of fewer than two frames; they get no row.
    """

    rows: tuple[ManifestRow, ...]
    unmatched: tuple[Path, ...]
    too_short: tuple[str, ...]


def make_manifest(
    root: str | Path,
    pattern: str,
    *,
    relative_to: str | Path | None = None,
    background_frame: str | None = None,
    actions: Mapping[str, str] | None = None,
    fps: float | None = None,
) -> MadeManifest:
    """Gather the images below `root` into clips.

    Args:
        root: Folder of the data set.
        pattern: Regular expression over a file's path below `root`, with '/' between folders and
            the named groups object, action and, where there are such, sensor, trial and frame. A
            clip is what agrees in all but the frame; frames stand in natural order.
        relative_to: Folder the manifest will lie in; None is `root`.
        background_frame: What `frame` says of the picture of the untouched gel, if one lies among
            a clip's frames; it becomes the background.
        actions: Other names of actions -> those of `manifest.ACTIONS`.
        fps: Frames per second, if known.

    Raises:
        UnreadableClip: If `root` holds no image the pattern fits.
        UsageError: If the pattern is none, lacks a group, or finds an action that is not known.
    """
    root = Path(root)
    matcher = _compiled(pattern, background_frame)
    words = {name: name for name in ACTIONS} | _checked(actions or {})
    found: dict[tuple[str, ...], list[tuple[str | None, Path]]] = defaultdict(list)
    unmatched = []
    for path in _images(root):
        match = matcher.search(path.relative_to(root).as_posix())
        if match is None:
            unmatched.append(path)
            continue
        groups = match.groupdict()
        key = tuple(groups.get(name) or "" for name in GROUPS[:-1])
        found[key].append((groups.get("frame"), path))
    if not found:
        raise UnreadableClip(
            f"{root}: the pattern fits none of {len(unmatched)} images, the first of them "
            f"{unmatched[0].relative_to(root).as_posix() if unmatched else 'not there'}; write one "
            f"such as '(?P<object>[^/]+)/(?P<action>[^/]+)/(?P<frame>[0-9]+)[.]png'."
        )
    _require_known(found, words)
    base = root if relative_to is None else Path(relative_to)
    rows, too_short = [], []
    for key, frames in found.items():
        row = _row_of(key, frames, words, base, background_frame, fps)
        if len(row.frames) < 2:
            too_short.append(row.clip_id)
        else:
            rows.append(row)
    return MadeManifest(tuple(rows), tuple(unmatched), tuple(too_short))


def _compiled(pattern: str, background_frame: str | None) -> re.Pattern[str]:
    try:
        matcher = re.compile(pattern)
    except re.error as error:
        raise UsageError(
            f"the pattern '{pattern[:80]}' is no regular expression ({error}); correct it."
        ) from error
    needed = (*REQUIRED_GROUPS, "frame") if background_frame is not None else REQUIRED_GROUPS
    missing = [name for name in needed if name not in matcher.groupindex]
    strange = [name for name in matcher.groupindex if name not in GROUPS]
    if missing or strange:
        told = f"lacks the group {missing[0]}" if missing else f"has the group {strange[0]}"
        raise UsageError(
            f"the pattern '{pattern[:80]}' {told}, expected named groups such as "
            f"(?P<object>...) out of {', '.join(GROUPS)}; object and action are needed."
        )
    return matcher


def _checked(actions: Mapping[str, str]) -> dict[str, str]:
    for token, action in actions.items():
        if action not in ACTIONS:
            raise UsageError(
                f"'{token}' is to mean '{action}', expected one of {', '.join(ACTIONS)}."
            )
    return dict(actions)


def _require_known(found: Mapping[tuple[str, ...], list], words: Mapping[str, str]) -> None:
    """Refuse actions without a meaning: left out silently they would skew what is measured."""
    place = GROUPS.index("action")
    unknown: Counter[str] = Counter()
    for key, frames in found.items():
        if key[place] not in words:
            unknown[key[place]] += len(frames)
    if unknown:
        told = ", ".join(f"'{token}' ({count} images)" for token, count in unknown.items())
        raise UsageError(
            f"found the actions {told}, expected {', '.join(words)}; say what they mean with "
            f"--action WORD=ACTION, or narrow the pattern."
        )


def _row_of(
    key: tuple[str, ...],
    frames: list[tuple[str | None, Path]],
    words: Mapping[str, str],
    base: Path,
    background_frame: str | None,
    fps: float | None,
) -> ManifestRow:
    object_id, sensor, action, trial = key
    # Where the pattern names no frame, the whole path stands in for its number.
    names = [frame or path.with_suffix("").as_posix() for frame, path in frames]
    ordered = [frames[place] for place in natural_order(names)]
    idles = [path for frame, path in ordered if frame is not None and frame == background_frame]
    shown = [path for _, path in ordered if path not in idles]
    return ManifestRow(
        clip_id="/".join(part for part in key if part),
        object_id=object_id,
        sensor=sensor,
        motion=ACTIONS[words[action]],
        frames=tuple(_relative(path, base) for path in shown),
        background=_relative(idles[0], base) if idles else None,
        fps=fps,
    )


def _relative(path: Path, base: Path) -> str:
    return Path(os.path.relpath(path.resolve(), base.resolve())).as_posix()


def _images(root: Path) -> list[Path]:
    if not root.is_dir():
        raise UnreadableClip(f"{root}: no such folder; give the one the data set lies in.")
    files = [
        path
        for path in root.rglob("*")
        if path.suffix.lower() in IMAGE_SUFFIXES and not path.name.startswith(".")
    ]
    stems = [path.relative_to(root).with_suffix("").as_posix() for path in files]
    return [files[place] for place in natural_order(stems)]
