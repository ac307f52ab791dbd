"""Data sets in LeRobot's layout (v3), written from recordings of our own; no LeRobot is needed."""

import json
from fractions import Fraction

import numpy as np

from tests.track.recordings import recording

CAMERA, OTHER, FPS = "observation.images.tactile", "observation.images.front", 25

KINDS = ("min", "max", "mean", "std", "count", "q01", "q10", "q50", "q90", "q99")


def turned(degrees, count=24, idle=7):
    """Return a drawn disc that is pressed on, turned by so much, and lifted again."""
    held = count - idle
    depths = [0.0] * idle + [0.5] + [1.0] * (held - 5) + [0.5] + [0.0] * 3
    return recording(np.interp(np.arange(count), [idle + 2, count - 6], [0, degrees]), depths)


def write_data_set(root, clips, *, in_a_file=2, as_images=False):
    """Write an episode for each clip, `in_a_file` of them in each table and video."""
    ends = np.cumsum([0, *map(len, clips)])
    (root / "meta").mkdir(parents=True)
    features = _features(clips[0].frames.shape[1:], "image" if as_images else "video")
    info = {
        "codebase_version": "v3.0",
        "robot_type": "drawn",
        "total_episodes": len(clips),
        "total_frames": int(ends[-1]),
        "total_tasks": 1,
        "chunks_size": 1000,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "fps": FPS,
        "splits": {"train": f"0:{len(clips)}"},
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "video_path": "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4",
        "features": features,
    }
    (root / "meta/info.json").write_text(json.dumps(info, indent=4))
    _write_tasks(root)
    rows = []
    for file, first in enumerate(range(0, len(clips), in_a_file)):
        numbers = range(first, min(first + in_a_file, len(clips)))
        inside = [clips[number] for number in numbers]
        _write_data(root, file, numbers, inside, ends, as_images)
        rows += _episode_rows(file, numbers, inside, ends, as_images)
        for camera in (CAMERA, OTHER) if not as_images else ():
            pictures = np.concatenate([one.frames for one in inside])
            pictures = pictures if camera == CAMERA else pictures[:, ::-1]
            write_video(root / f"videos/{camera}/chunk-000/file-{file:03d}.mp4", pictures)
    write_table(root / "meta/episodes/chunk-000/file-000.parquet", rows)
    told = {name: _statistics(np.arange(ends[-1])) for name in ("index", "timestamp")}
    (root / "meta/stats.json").write_text(json.dumps(told, indent=4))
    (root / "README.md").write_text("---\ntags: [LeRobot]\n---\nDrawn.\n")
    return root


def write_video(path, pictures, fps=FPS):
    """Write RGB pictures as H.264 in an .mp4, nearly without loss."""
    import av

    path.parent.mkdir(parents=True, exist_ok=True)
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=fps, options={"crf": "8", "g": "10"})
        stream.height, stream.width = pictures.shape[1:3]
        stream.pix_fmt, stream.time_base = "yuv420p", Fraction(1, fps)
        for picture in pictures:
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")
            container.mux(stream.encode(frame))
        container.mux(stream.encode())


def write_table(path, rows, types=None):
    import pyarrow
    from pyarrow import parquet

    path.parent.mkdir(parents=True, exist_ok=True)
    parquet.write_table(pyarrow.Table.from_pylist(rows, types), path)


def _features(shape, kind):
    rows, columns, _ = shape
    picture = {
        "dtype": kind,
        "shape": [rows, columns, 3],
        "names": ["height", "width", "channels"],
        "info": {"video.fps": FPS, "video.codec": "h264", "is_depth_map": False},
    }
    cameras = [CAMERA, OTHER] if kind == "video" else [CAMERA]
    numbers = {"timestamp": "float32"}
    numbers |= dict.fromkeys(("frame_index", "episode_index", "index", "task_index"), "int64")
    return {
        "observation.state": {"dtype": "float32", "shape": [2], "names": ["x", "y"]},
        **{camera: picture for camera in cameras},
        **{name: {"dtype": k, "shape": [1], "names": None} for name, k in numbers.items()},
    }


def _write_data(root, file, numbers, clips, ends, as_images):
    """Write the frames' rows, a group of rows for each episode."""
    import pyarrow
    from pyarrow import parquet

    types = {
        "observation.state": pyarrow.list_(pyarrow.float32(), 2),
        "timestamp": pyarrow.float32(),
        **dict.fromkeys(("frame_index", "episode_index", "index", "task_index"), pyarrow.int64()),
    }
    if as_images:
        types[CAMERA] = pyarrow.struct({"bytes": pyarrow.binary(), "path": pyarrow.string()})
    path = root / f"data/chunk-000/file-{file:03d}.parquet"
    path.parent.mkdir(parents=True, exist_ok=True)
    schema = pyarrow.schema(list(types.items()), {"written_by": "tests"})
    with parquet.ParquetWriter(path, schema) as writer:
        for number, clip in zip(numbers, clips, strict=True):
            rows = [
                {
                    "observation.state": [0.1 * frame, float(number)],
                    "timestamp": frame / FPS,
                    "frame_index": frame,
                    "episode_index": number,
                    "index": int(ends[number]) + frame,
                    "task_index": 0,
                }
                | ({CAMERA: {"bytes": _png(clip.frames[frame]), "path": None}} if as_images else {})
                for frame in range(len(clip))
            ]
            writer.write_table(pyarrow.Table.from_pylist(rows, schema))


def _png(picture):
    import cv2

    return cv2.imencode(".png", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))[1].tobytes()


def _episode_rows(file, numbers, clips, ends, as_images):
    since = 0.0
    for number, clip in zip(numbers, clips, strict=True):
        row = {
            "episode_index": number,
            "tasks": ["turn it"],
            "length": len(clip),
            "data/chunk_index": 0,
            "data/file_index": file,
            "dataset_from_index": int(ends[number]),
            "dataset_to_index": int(ends[number + 1]),
            "meta/episodes/chunk_index": 0,
            "meta/episodes/file_index": 0,
        }
        until = since + len(clip) / FPS
        for camera in (CAMERA, OTHER) if not as_images else ():
            row |= {f"videos/{camera}/chunk_index": 0, f"videos/{camera}/file_index": file}
            row |= {f"videos/{camera}/from_timestamp": since}
            row |= {f"videos/{camera}/to_timestamp": until}
        told = _statistics(np.arange(len(clip)) / FPS)
        yield row | {f"stats/timestamp/{kind}": value for kind, value in told.items()}
        since = until


def _statistics(values):
    told = [values.min(), values.max(), values.mean(), values.std(), len(values)]
    told += [np.quantile(values, q) for q in (0.01, 0.1, 0.5, 0.9, 0.99)]
    made = {kind: [float(value)] for kind, value in zip(KINDS, told, strict=True)}
    return made | {"count": [len(values)]}


def _write_tasks(root):
    """Write the tasks as pandas does: the text is the index of its number."""
    import pyarrow
    from pyarrow import parquet

    table = pyarrow.table({"task_index": [0], "task": ["turn it"]})
    kinds = {"task_index": ("int64", "int64"), "task": ("unicode", "object")}
    columns = [
        {"name": name, "field_name": name, "pandas_type": kind, "numpy_type": stored}
        for name, (kind, stored) in kinds.items()
    ]
    pandas = {"index_columns": ["task"], "columns": columns, "pandas_version": "2.0.0"}
    about = {"pandas": json.dumps(pandas)}
    parquet.write_table(table.replace_schema_metadata(about), root / "meta/tasks.parquet")
