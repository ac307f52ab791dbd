"""Simulated clips on disk: shards with truth that survive a kill; same seed, same bytes.

A folder holds `shard-00000.npz` and so on (numpy's archives), or `.parquet` tables that Hugging
Face's `datasets` reads, pictures included; each is written whole and then renamed. Beside them are
`dataset.json` with what was asked for, and a card. Shard k holds clips [k * SHARD_CLIPS,
(k + 1) * SHARD_CLIPS) of the seed's series, whoever wrote it and whenever; a resumed run only
writes the missing ones.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any, Literal, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.errors import MissingDependency, UsageError
from geotlm_lm.core.files import write_text_atomically
from geotlm_lm.core.labels import MotionLabel
from geotlm_lm.core.process import Progress, silent
from geotlm_lm.core.twist import COMPONENTS
from geotlm_lm.runs.run import ALONE, Workers, do_parts
from geotlm_lm.simulation.contact import PresetName, preset_named
from geotlm_lm.simulation.simulate import SERIES_VERSION, SimulatedClip, simulate_series
from geotlm_lm.simulation.truth import READABLE_GREY, components_of

SHARD_CLIPS = 64
"""Clips per shard: about 50 MB of frames, a few seconds of work to lose in a kill."""

CARD_FILE, ASKED_FILE = "README.md", "dataset.json"

DATASET_FORMAT = 2

FormName = Literal["npz", "huggingface"]

SUFFIXES: dict[FormName, str] = {"npz": ".npz", "huggingface": ".parquet"}

Arrays = dict[str, NDArray[Any]]
"""By name, each with a row for every clip; `labels` is one JSON text of all."""


class _Shard(NamedTuple):
    first_index: int
    count: int


def write_dataset(
    out: Path,
    count: int,
    *,
    seed: int,
    objects: Sequence[str],
    workers: Workers = ALONE,
    preset: PresetName = "fast",
    with_drift: bool = False,
    marker_share: float = 0.0,
    mixed_share: float = 0.0,
    with_frames: bool = True,
    form: FormName = "npz",
    progress: Progress = silent,
) -> Path:
    """Write `count` clips of `objects` into the folder `out`, or finish writing them; return it.

    Clip i is the same in every data set of this seed, these objects and these settings, which are
    those of `simulate_series`; who simulates does not matter. Progress is reported after a shard.

    Raises:
        UsageError: If the folder holds another or a larger data set, or the request is empty.
        GeoTLMError: If a worker was killed.
        MissingDependency: If the package that writes the form is not installed.
    """
    if form == "huggingface" and find_spec("pyarrow") is None:
        raise MissingDependency(
            "A data set for Hugging Face's datasets is written with pyarrow, which is not "
            "installed; run `pip install 'geotlm-lm[track]'`."
        )
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
    jobs = [
        (
            _Shard(start, min(SHARD_CLIPS, count - start)),
            out / f"shard-{number:05d}{SUFFIXES[form]}",
        )
        for number, start in enumerate(range(0, count, SHARD_CLIPS))
    ]
    do_parts(
        "simulated",
        partial(_shard_arrays, options),
        jobs,
        _write_npz if form == "npz" else _write_parquet,
        is_kept=_is_whole,
        size=lambda shard: shard.count,
        workers=workers,
        seen=[asked],
        progress=progress,
    )
    write_text_atomically(out / CARD_FILE, _card(out, count, wanted))
    return out


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
        there = json.loads((out / ASKED_FILE).read_text())
        count_there = int(there["count"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UsageError(
            f"{out / ASKED_FILE} does not say what the folder holds; choose an empty folder."
        ) from error
    # A folder that does not say has no mixed clips, in archives.
    there = {"mixed_share": 0.0, "form": "npz"} | there
    if {name: there.get(name) for name in wanted} != wanted:
        raise UsageError(
            f"{out} holds another data set (seed {there.get('seed')}, expected "
            f"{wanted['seed']}, or other objects or settings); choose an empty folder."
        )
    if count_there > count:
        raise UsageError(
            f"{out} was made for {count_there} clips, {count} were asked for; ask for at least as "
            f"many, or choose an empty folder."
        )


def _is_whole(shard: _Shard, path: Path) -> bool:
    """Tell whether the file is there, undamaged, with all its clips."""
    try:
        return len(_labels_of(path)[0]) == shard.count
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return False


def _shard_arrays(options: dict[str, Any], shard: _Shard) -> Arrays:
    """Return the arrays of a shard; `options` are those of `simulate_series`."""
    arrays: Arrays = {}
    labels, names = [], []
    series = simulate_series(count=shard.count, first_index=shard.first_index, **options)
    for number, clip in enumerate(series):
        # Copied to where the shard is kept: the next clip takes the memory of this one.
        for name, value in _fields_of(clip).items():
            if number == 0:
                arrays[name] = np.empty((shard.count, *value.shape), value.dtype)
            arrays[name][number] = value
        labels.append(clip.label.to_dict())
        names.append(clip.object_name)
    arrays["object_names"] = np.array(names)
    arrays["index"] = np.arange(shard.first_index, shard.first_index + shard.count)
    arrays["labels"] = np.array(json.dumps(labels))
    return arrays


def _fields_of(clip: SimulatedClip) -> Arrays:
    """Return what a data set keeps of one clip beside its label and its object's name."""
    pictures = {}
    if clip.clip is not None:
        pictures = {"frames": clip.clip.frames, "backgrounds": clip.clip.background}
    fields = {
        "displacement_px": clip.displacement_px,
        "contact": clip.contact,
        "depth_mm": clip.depth_mm,
        "mm_per_px": np.array(clip.mm_per_px, np.float32),
        "penetration_um": np.array(clip.status.penetration_um, np.float32),
    }
    drift = {} if clip.drift_px is None else {"drift_px": clip.drift_px}
    return pictures | fields | drift


def _write_npz(stream: IO[bytes], arrays: Arrays) -> None:
    """Write an uncompressed archive with a fixed date inside."""
    with zipfile.ZipFile(stream, "w") as archive:
        for name, array in arrays.items():
            entry = zipfile.ZipInfo(f"{name}.npy", date_time=(1980, 1, 1, 0, 0, 0))
            with archive.open(entry, "w", force_zip64=True) as member:
                array = np.asarray(array, order="C")
                header = np.lib.format.header_data_from_array_1_0(array)
                np.lib.format.write_array_header_1_0(member, header)
                # Not numpy's own writer: to anything but a plain file it writes copies.
                member.write(array.reshape(-1).view(np.uint8))


def _write_parquet(stream: IO[bytes], arrays: Arrays) -> None:
    """Write a table with a row for each clip, pictures as `datasets` keeps them."""
    import pyarrow
    from pyarrow import parquet

    def nested(values: NDArray[Any]) -> pyarrow.Array:
        lists = pyarrow.array(np.ascontiguousarray(values).reshape(-1))
        for length in reversed(values.shape[1:]):
            lists = pyarrow.FixedSizeListArray.from_arrays(lists, length)
        return lists

    picture = pyarrow.struct({"bytes": pyarrow.binary(), "path": pyarrow.string()})
    pictures: dict[str, NDArray[np.uint8]] = {}
    if "frames" in arrays:
        frames = np.moveaxis(arrays["frames"], 1, 0)
        pictures = {f"frame_{number}": rows for number, rows in enumerate(frames)}
        pictures["background"] = arrays["backgrounds"]
    labels = json.loads(str(arrays["labels"]))
    columns = {"index": pyarrow.array(arrays["index"].tolist(), pyarrow.int64())}
    for name, rows in pictures.items():
        pngs = [{"bytes": _png(row), "path": None} for row in rows]
        columns[name] = pyarrow.array(pngs, picture)
    columns["object_name"] = pyarrow.array(arrays["object_names"].tolist())
    for name in ("motion", "rotation_deg", "slide_x_mm", "slide_y_mm", "depth_change_mm"):
        columns[name] = pyarrow.array([label[name] for label in labels])
    columns["label"] = pyarrow.array([json.dumps(label) for label in labels])
    columns |= {name: nested(arrays[name]) for name in ("mm_per_px", "penetration_um")}
    columns |= {
        name: nested(arrays[name])
        for name in ("displacement_px", "contact", "depth_mm", "drift_px")
        if name in arrays
    }
    about = {"info": {"features": {name: {"_type": "Image"} for name in pictures}}}
    table = pyarrow.table(columns).replace_schema_metadata({"huggingface": json.dumps(about)})
    parquet.write_table(table, stream)


def _png(picture: NDArray[np.uint8]) -> bytes:
    return cv2.imencode(".png", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))[1].tobytes()


def _labels_of(path: Path) -> tuple[list[dict[str, Any]], list[float]]:
    """Return the labels of a shard's clips, and what the contact solver left of each in um."""
    if path.suffix == ".npz":
        with np.load(path, allow_pickle=False) as stored:
            return json.loads(str(stored["labels"])), stored["penetration_um"].tolist()
    from pyarrow import parquet

    with parquet.ParquetFile(path) as file:
        table = file.read(columns=["label", "penetration_um"])
    labels = [json.loads(text) for text in table["label"].to_pylist()]
    return labels, table["penetration_um"].to_pylist()


def _card(out: Path, count: int, wanted: dict[str, Any]) -> str:
    """Return the data set's card in Markdown, counted from what was written."""
    labels: list[MotionLabel] = []
    worst_um, suffix = 0.0, SUFFIXES[wanted["form"]]
    for path in sorted(out.glob(f"shard-*{suffix}")):
        values, penetration_um = _labels_of(path)
        worst_um = max(worst_um, *penetration_um)
        labels += map(MotionLabel.from_dict, values)
    motions: dict[str, list[bool]] = {}
    for label in labels:
        motions.setdefault(label.motion.value, []).append(label.is_readable)
    is_table = wanted["form"] == "huggingface"
    lines = [
        "---",
        "license: apache-2.0",
        "tags: [tactile, gelsight, simulated]",
        *[f'configs:\n- config_name: default\n  data_files: "shard-*{suffix}"'] * is_table,
        "---",
        "# Simulated touch clips",
        "",
        f"{count} clips of {len(wanted['objects'])} bodies, seed {wanted['seed']}, preset",
        f"{wanted['preset']}, series {wanted['series']}, markers on the gel in a share of",
        f"{wanted['marker_share']:g}, turn, slide and press mixed freely in a share of",
        f"{wanted['mixed_share']:g}, made by",
        "`geotlm_lm.simulation`: a rigid body on a bonded elastic layer, seen by a camera",
        "under three coloured lights. Everything is simulated; nothing was recorded.",
        "",
        "| motion | clips | unreadable share |",
        "|---|---|---|",
        *(
            f"| {name} | {len(readable)} | {1 - sum(readable) / len(readable):.3f} |"
            for name, readable in sorted(motions.items())
        ),
        "",
        *_component_lines(labels),
        "",
        f"Largest penetration the contact solver left: {worst_um:.1f} micrometres.",
        "",
        *[
            "Each row: images `frame_0` to `frame_3` and `background`, the label's numbers and all "
            "of it as JSON\n(`label`), and the fields as nested lists.\n"
        ]
        * is_table,
        "Per shard:\n`frames` uint8 (clips, 4, 224, 224, 3) RGB, `backgrounds` the idle gel,"
        if wanted["with_frames"]
        else "No picture was made: whether a motion is readable is estimated from the surface. Per "
        "shard:",
        "`displacement_px` (clips, 4, 14, 14, 2) travel of the object since frame 0 at each",
        "patch (x right, y down, pixels), `contact` and `depth_mm` (clips, 4, 14, 14),",
        *["`drift_px` (clips, 4, 14, 14, 2) the gel's own displacement from rest in pixels,"]
        * wanted["with_drift"],
        "`mm_per_px`, `object_names`, `index`, and `labels` as JSON. Positive rotation is",
        "clockwise in the image. Directions are the object's relative to the sensor.",
        "",
        "Bodies: " + ", ".join(wanted["objects"]) + ".",
        "",
    ]
    return "\n".join(lines)


def _component_lines(labels: list[MotionLabel]) -> list[str]:
    truths = [components_of(label) for label in labels]
    rows = []
    for component in COMPONENTS:
        of_clips = [truth[component] for truth in truths]
        visible = [of_clip.is_visible for of_clip in of_clips if of_clip.moves]
        share = f"{np.mean(visible):.3f}" if visible else "-"
        moves = [of_clip.moves for of_clip in of_clips]
        numbers = [sum(value is kind for value in moves) for kind in (True, None, False)]
        rows.append(f"| {component} | {' | '.join(map(str, numbers))} | {share} |")
    held = [sum(part.moves is True for part in truth.values()) for truth in truths]
    together = ", ".join(f"{held.count(n)} of {n}" for n in range(len(COMPONENTS) + 1))
    return [
        "Whatever its name, a clip may turn, slide and press at once. A component that moves",
        f"is readable where it alone can have changed the picture by {READABLE_GREY:g} greys.",
        "",
        "| component | moves | too little | does not | readable share of those that move |",
        "|---|---|---|---|---|",
        *rows,
        "",
        f"Clips by the number of components that move: {together}.",
    ]
