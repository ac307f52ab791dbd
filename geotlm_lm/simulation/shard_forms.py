"""A shard of simulated clips as a file: numpy's archive, a webdataset tar, or a Parquet table.

The table is one that Hugging Face's `datasets` reads, pictures included. Equal clips are equal
bytes in each form.
"""

from __future__ import annotations

import io
import json
import tarfile
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.errors import MissingDependency

Arrays = dict[str, NDArray[Any]]
"""By name, each with a row for every clip; `labels` is one JSON text of all."""

FormName = Literal["npz", "webdataset", "huggingface"]

_PICTURES = ("frames", "backgrounds")
_TOLD = ("labels", "object_names", "index", "mm_per_px", "penetration_um")
_IN_COLUMNS = ("motion", "rotation_deg", "slide_x_mm", "slide_y_mm", "depth_change_mm")


@dataclass(frozen=True)
class Told:
    """What a shard tells of its clips without their arrays.

    Args:
        labels: One for each, as plain values.
        penetration_um: What the contact solver left of each, micrometres.
    """

    labels: list[dict[str, Any]]
    penetration_um: list[float]


@dataclass(frozen=True)
class Form:
    """One form of a shard.

    Args:
        suffix: What its files end in.
        write: Writes the arrays of a shard.
        read: Reads what a file tells.
        about: What the card says of it.
    """

    suffix: str
    write: Callable[[IO[bytes], Arrays], None]
    read: Callable[[Path], Told]
    about: str


def require_packages(form: FormName) -> None:
    """Refuse a form whose package is not installed.

    Raises:
        MissingDependency: If it is not there.
    """
    if form == "huggingface" and find_spec("pyarrow") is None:
        raise MissingDependency(
            "A data set for Hugging Face's datasets is written with pyarrow, which is not "
            "installed; run `pip install 'geotlm-lm[track]'`."
        )


def told_by(path: Path, form: FormName) -> Told | None:
    """Return what a shard tells; None where it is missing or damaged."""
    try:
        return FORMS[form].read(path)
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, tarfile.TarError):
        return None


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


def _read_npz(path: Path) -> Told:
    with np.load(path, allow_pickle=False) as stored:
        return Told(json.loads(str(stored["labels"])), stored["penetration_um"].tolist())


def _write_tar(stream: IO[bytes], arrays: Arrays) -> None:
    """Write a tar in which a clip's members share what stands before the first dot."""
    with tarfile.open(fileobj=stream, mode="w", format=tarfile.USTAR_FORMAT) as archive:
        for place, told in enumerate(_told(arrays)):
            members = {f"{name}.png": png for name, png in _pngs(arrays, place)}
            members |= {f"{name}.npy": _npy(values[place]) for name, values in _fields(arrays)}
            members["json"] = json.dumps(told).encode()
            for name, content in members.items():
                entry = tarfile.TarInfo(f"{told['index']:09d}.{name}")
                entry.size = len(content)  # owner and date stay those of nobody and 1970
                archive.addfile(entry, io.BytesIO(content))


def _read_tar(path: Path) -> Told:
    with tarfile.open(path) as archive:
        told = [json.load(archive.extractfile(m)) for m in archive if m.name.endswith(".json")]
    return Told([one["label"] for one in told], [one["penetration_um"] for one in told])


def _write_parquet(stream: IO[bytes], arrays: Arrays) -> None:
    """Write a table with a row for each clip, pictures as `datasets` keeps them."""
    import pyarrow
    from pyarrow import parquet

    told = list(_told(arrays))
    picture = pyarrow.struct({"bytes": pyarrow.binary(), "path": pyarrow.string()})
    pngs: dict[str, list[dict[str, Any]]] = {}
    for place in range(len(told)):
        for name, png in _pngs(arrays, place):
            pngs.setdefault(name, []).append({"bytes": png, "path": None})
    columns = {"index": pyarrow.array([one["index"] for one in told], pyarrow.int64())}
    columns |= {name: pyarrow.array(values, picture) for name, values in pngs.items()}
    columns["object_name"] = pyarrow.array([one["object_name"] for one in told])
    columns |= {name: pyarrow.array([one["label"][name] for one in told]) for name in _IN_COLUMNS}
    columns["label"] = pyarrow.array([json.dumps(one["label"]) for one in told])
    columns |= {name: _nested(arrays[name]) for name in ("mm_per_px", "penetration_um")}
    columns |= {name: _nested(values) for name, values in _fields(arrays)}
    features = {name: {"_type": "Image"} for name in pngs}
    about = json.dumps({"info": {"features": features}})
    table = pyarrow.table(columns).replace_schema_metadata({"huggingface": about})
    parquet.write_table(table, stream)


def _read_parquet(path: Path) -> Told:
    from pyarrow import parquet

    with parquet.ParquetFile(path) as file:
        table = file.read(columns=["label", "penetration_um"])
    labels = [json.loads(text) for text in table["label"].to_pylist()]
    return Told(labels, table["penetration_um"].to_pylist())


def _told(arrays: Arrays) -> Iterator[dict[str, Any]]:
    """Yield what is told of each clip in plain values."""
    labels = json.loads(str(arrays["labels"]))
    for place, label in enumerate(labels):
        yield {
            "index": int(arrays["index"][place]),
            "object_name": str(arrays["object_names"][place]),
            "label": label,
            "mm_per_px": arrays["mm_per_px"][place].tolist(),
            "penetration_um": float(arrays["penetration_um"][place]),
        }


def _pngs(arrays: Arrays, place: int) -> Iterator[tuple[str, bytes]]:
    if "frames" not in arrays:
        return
    for number, frame in enumerate(arrays["frames"][place]):
        yield f"frame_{number}", _png(frame)
    yield "background", _png(arrays["backgrounds"][place])


def _png(picture: NDArray[np.uint8]) -> bytes:
    return cv2.imencode(".png", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))[1].tobytes()


def _fields(arrays: Arrays) -> Iterator[tuple[str, NDArray[Any]]]:
    yield from ((k, values) for k, values in arrays.items() if k not in (*_PICTURES, *_TOLD))


def _npy(values: NDArray[Any]) -> bytes:
    stream = io.BytesIO()
    np.save(stream, values, allow_pickle=False)
    return stream.getvalue()


def _nested(values: NDArray[Any]) -> Any:
    """Return arrays of one shape as lists in lists."""
    import pyarrow

    nested = pyarrow.array(np.ascontiguousarray(values).reshape(-1))
    for length in reversed(values.shape[1:]):
        nested = pyarrow.FixedSizeListArray.from_arrays(nested, length)
    return nested


FORMS: dict[FormName, Form] = {
    "npz": Form(".npz", _write_npz, _read_npz, ""),
    "webdataset": Form(
        ".tar",
        _write_tar,
        _read_tar,
        "Each clip of a shard: `frame_0.png` to `frame_3.png`, `background.png`, a `.npy` of each "
        "field, and `json`\nwith its label.",
    ),
    "huggingface": Form(
        ".parquet",
        _write_parquet,
        _read_parquet,
        "Each row: images `frame_0` to `frame_3` and `background`, the label's numbers and all of "
        "it as JSON\n(`label`), and the fields as nested lists.",
    ),
}
