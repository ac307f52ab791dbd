"""Simulated clips on disk: shards with truth that survive a kill; same seed, same bytes.

A folder holds `shard-00000.npz` and so on, or files of another form (`shard_forms`), each written
whole and then renamed, `dataset.json` with what was asked for, and a card. Shard k holds clips
[k * SHARD_CLIPS, (k + 1) * SHARD_CLIPS) of the seed's series, whoever wrote it and whenever; a
resumed run only writes the missing ones.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.files import replacing, write_text_atomically
from geotlm_lm.core.labels import MotionLabel
from geotlm_lm.core.process import Progress, silent, uninterrupted_step
from geotlm_lm.simulation.card import card_of
from geotlm_lm.simulation.presets import PresetName, preset_named
from geotlm_lm.simulation.randomise import MARKER_SHARE, MIXED_SHARE
from geotlm_lm.simulation.series import SERIES_VERSION, simulate_series
from geotlm_lm.simulation.shard_forms import FORMS, FormName, require_packages, told_by
from geotlm_lm.simulation.simulate import SimulatedClip
from geotlm_lm.workers import ALONE, Workers

SHARD_CLIPS = 64
"""Clips per shard: about 50 MB of frames, a few seconds of work to lose in a kill."""

CARD_FILE, ASKED_FILE = "README.md", "dataset.json"

DATASET_FORMAT = 2


@dataclass(frozen=True)
class _Shard:
    path: str
    first_index: int
    count: int
    form: FormName


def write_dataset(
    out: Path,
    count: int,
    *,
    seed: int,
    objects: Sequence[str],
    workers: Workers = ALONE,
    preset: PresetName = "fast",
    with_drift: bool = False,
    marker_share: float = MARKER_SHARE,
    mixed_share: float = MIXED_SHARE,
    with_frames: bool = True,
    form: FormName = "npz",
    progress: Progress = silent,
) -> Path:
    """Write `count` clips of `objects` into the folder `out`, or finish writing them.

    Args:
        out: Folder; created when absent, resumed when it holds part of the same data set.
        count: Number of clips.
        seed: Root seed; clip i is the same in every data set of this seed, these objects
            and these settings.
        objects: Names from `indenters.INDENTERS`.
        workers: Who simulates; the result does not depend on it.
        preset: How finely and tightly the contact is solved.
        with_drift: Whether the gel's tangential displacement is part of the truth.
        marker_share: Share of clips on a gel with markers.
        mixed_share: Share of clips that turn, slide and press at once, as they may.
        with_frames: Whether pictures are written beside labels and true fields.
        form: Of the shards' files, a key of `shard_forms.FORMS`.
        progress: Told after every shard how many clips are done.

    Returns:
        `out`.

    Raises:
        UsageError: If the folder holds another or a larger data set, or the request is empty.
        GeoTLMError: If a worker was killed.
        MissingDependency: If the package that writes the form is not installed.
    """
    require_packages(form)
    out = Path(out)
    options = {
        "seed": seed,
        "objects": list(objects),
        "preset": preset_named(preset).name,
        "with_drift": with_drift,
        "marker_share": marker_share,
        "mixed_share": mixed_share,
        "with_frames": with_frames,
    }
    wanted = {"format": DATASET_FORMAT, "series": SERIES_VERSION, "form": form} | options
    _check(out, count, wanted)
    out.mkdir(parents=True, exist_ok=True)
    asked = out / ASKED_FILE
    write_text_atomically(asked, json.dumps(wanted | {"count": count}) + "\n")
    shards = _shards(out, count, form)
    missing = [shard for shard in shards if not _is_whole(shard)]
    done = count - sum(shard.count for shard in missing)
    for written in workers.each_done(partial(_write_shard, options), missing, seen=[asked]):
        done += written
        progress("simulated", done, count)
    write_text_atomically(out / CARD_FILE, card_of(out, count, wanted))
    return out


def read_shard(path: Path) -> tuple[dict[str, NDArray[Any]], list[MotionLabel]]:
    """Return the arrays of one shard by name, and the label of each of its clips."""
    with np.load(path, allow_pickle=False) as stored:
        arrays = {name: stored[name] for name in stored.files if name != "labels"}
        labels = json.loads(str(stored["labels"]))
    return arrays, [MotionLabel.from_dict(values) for values in labels]


def _check(out: Path, count: int, wanted: dict[str, Any]) -> None:
    if count < 1 or not wanted["objects"]:
        raise UsageError(f"found {count} clips of {len(wanted['objects'])} objects; ask for some.")
    if not (out / ASKED_FILE).exists():
        if (out / CARD_FILE).exists():
            raise UsageError(
                f"{out} has a {CARD_FILE} of something else, which the data set's card would "
                f"replace; choose an empty folder."
            )
        return
    try:
        found = json.loads((out / ASKED_FILE).read_text())
        found_count = int(found["count"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UsageError(
            f"{out / ASKED_FILE} does not say what the folder holds; choose an empty folder."
        ) from error
    # A folder that does not say has no mixed clips, in archives.
    found = {"mixed_share": 0.0, "form": "npz"} | found
    if {name: found.get(name) for name in wanted} != wanted:
        raise UsageError(
            f"{out} holds another data set (seed {found.get('seed')}, expected "
            f"{wanted['seed']}, or other objects or settings); choose an empty folder."
        )
    if found_count > count:
        raise UsageError(
            f"{out} was made for {found_count} clips, {count} were asked for; ask for at least as "
            f"many, or choose an empty folder."
        )


def _shards(out: Path, count: int, form: FormName) -> list[_Shard]:
    suffix = FORMS[form].suffix
    return [
        _Shard(
            path=str(out / f"shard-{number:05d}{suffix}"),
            first_index=start,
            count=min(SHARD_CLIPS, count - start),
            form=form,
        )
        for number, start in enumerate(range(0, count, SHARD_CLIPS))
    ]


def _is_whole(shard: _Shard) -> bool:
    told = told_by(Path(shard.path), shard.form)
    return told is not None and len(told.labels) == shard.count


def _write_shard(options: dict[str, Any], shard: _Shard) -> int:
    """Write a shard, if it is not there; `options` are those of `simulate_series`."""
    if _is_whole(shard):
        return shard.count
    made: dict[str, NDArray[Any]] = {}
    labels, names = [], []
    series = simulate_series(count=shard.count, first_index=shard.first_index, **options)
    for number, clip in enumerate(series):
        # Copied to where the shard is kept: the next clip takes the memory of this one.
        for name, value in _stored(clip).items():
            if number == 0:
                made[name] = np.empty((shard.count, *value.shape), value.dtype)
            made[name][number] = value
        labels.append(clip.label.to_dict())
        names.append(clip.object_name)
    made["object_names"] = np.array(names)
    made["index"] = np.arange(shard.first_index, shard.first_index + shard.count)
    made["labels"] = np.array(json.dumps(labels))
    with uninterrupted_step():  # a worker that is ended here leaves its shard, not a part of it
        _save(shard, made)
    return shard.count


def _save(shard: _Shard, arrays: dict[str, NDArray[Any]]) -> None:
    with replacing(Path(shard.path)) as stream:
        FORMS[shard.form].write(stream, arrays)


def _stored(clip: SimulatedClip) -> dict[str, NDArray[Any]]:
    """Return what a data set keeps of one clip beside its label and its object's name."""
    seen = {}
    if clip.clip is not None:
        seen = {"frames": clip.clip.frames, "backgrounds": clip.clip.background}
    kept = {
        "displacement_px": clip.displacement_px,
        "contact": clip.contact,
        "depth_mm": clip.depth_mm,
        "mm_per_px": np.array(clip.mm_per_px, np.float32),
        "penetration_um": np.array(clip.status.penetration_um, np.float32),
    }
    drift = {} if clip.drift_px is None else {"drift_px": clip.drift_px}
    return seen | kept | drift
