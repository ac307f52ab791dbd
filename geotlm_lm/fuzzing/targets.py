"""What is fuzzed: every reader of files that others made, and what becomes of a question.

A target is made in the process that runs it; its seeds are lawful inputs, made here.
"""

from __future__ import annotations

import io
import json
import shutil
import zipfile
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from geotlm_lm.core.resources import resource_dir
from geotlm_lm.fuzzing.questions import conversation, question, rules
from geotlm_lm.fuzzing.target import Prepare, Target

FRAMES = 6


def _use(path: Path) -> None:
    """Read a recording and choose its frames, as every command does."""
    from geotlm_lm.answering import four_frames_with_background
    from geotlm_lm.recordings.read import read_clip

    four_frames_with_background(read_clip(path))


def _frames() -> np.ndarray:
    rng = np.random.default_rng(0)
    frames = rng.integers(90, 110, (FRAMES, 24, 32, 3)).astype(np.uint8)
    for number in range(2, FRAMES):
        frames[number, 8:16, 4 + 2 * number : 12 + 2 * number] += 60
    return frames


def _npy(array: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


def _array(home: Path) -> Target:
    path, frames = home / "clip.npy", _frames()
    planes = np.moveaxis(frames, -1, 1)

    def run(data: bytes) -> None:
        path.write_bytes(data)
        _use(path)

    lawful = (frames, frames / np.float32(255), planes, frames[..., :1].astype(np.int32))
    words = (b"'shape': (", b"'descr': '|O'", b"<f8", b">u4", b"True", b"9" * 30, b"-1, ", b"(((((")
    return Target(tuple(map(_npy, lawful)), run, words)


def _archive(home: Path) -> Target:
    path, frames = home / "clip.npz", _frames()

    def run(data: bytes) -> None:
        path.write_bytes(data)
        _use(path)

    seeds = []
    for save in (np.savez, np.savez_compressed):
        stream = io.BytesIO()
        save(stream, frames=frames, fps=25.0, background=frames[0])
        seeds.append(stream.getvalue())
    return Target(
        tuple(seeds), run, (b"frames.npy", b"PK\x01\x02", b"PK\x05\x06", b"../frames.npy")
    )


def _member(home: Path) -> Target:
    """Damage inside a sound archive, which the checksum would otherwise give away."""
    path, frames = home / "clip.npz", _frames()
    sound = {"frames": _npy(frames), "fps": _npy(np.array(25.0)), "background": _npy(frames[0])}

    def run(data: bytes) -> None:
        which, _, stored = data.partition(b"\n")
        name = which.decode() if which.decode("utf-8", "replace") in sound else "frames"
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for member, content in (sound | {name: stored}).items():
                archive.writestr(f"{member}.npy", content)
        _use(path)

    seeds = tuple(name.encode() + b"\n" + stored for name, stored in sound.items())
    return Target(seeds, run, (b"'shape': (", b"|O", b"<f8", b"9" * 30, b"nan"))


def _video(suffix: str, code: str, home: Path) -> Target:
    path = home / f"clip{suffix}"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*code), 25.0, (32, 24))
    for frame in _frames():
        writer.write(frame)
    writer.release()

    def run(data: bytes) -> None:
        path.write_bytes(data)
        _use(path)

    return Target((path.read_bytes(),), run)


def _played(home: Path) -> Target:
    """A recording watched frame by frame, which does not stop at the reader's limits."""
    from geotlm_lm.live.sources import open_source
    from geotlm_lm.live.watcher import Watcher, Window

    path = home / "clip.avi"
    seeds = _video(".avi", "MJPG", home).seeds

    def run(data: bytes) -> None:
        path.write_bytes(data)
        watcher = Watcher(lambda clip, motions: Window(motions[0], 1.0))
        for frame in open_source(str(path)):
            watcher.push(frame.image, frame.time_s)
        watcher.finish()

    return Target(seeds, run)


def _image(home: Path) -> Target:
    from geotlm_lm.recordings.read import read_background

    folder, still = home / "frames", home / "idle.png"
    folder.mkdir()
    codes = [cv2.imencode(".png", frame)[1].tobytes() for frame in _frames()]
    others = [
        cv2.imencode(kind, _frames()[0])[1].tobytes() for kind in (".jpg", ".bmp", ".tif", ".webp")
    ]
    for number, code in enumerate(codes):
        (folder / f"{number}.png").write_bytes(code)

    def run(data: bytes) -> None:
        still.write_bytes(data)
        read_background(still)
        (folder / "3.png").write_bytes(data)
        _use(folder)

    return Target((codes[3], *others), run, (b"IHDR", b"IDAT", b"\xff\xd8\xff", b"acTL"))


def _stack(home: Path) -> Target:
    path = home / "clip.tif"
    cv2.imwritemulti(str(path), [*_frames()])

    def run(data: bytes) -> None:
        path.write_bytes(data)
        _use(path)

    return Target((path.read_bytes(),), run, (b"II*\0", b"MM\0*", b"\0\1", b"\1\1", b"\xff" * 4))


def _height_map(home: Path) -> Target:
    from geotlm_lm.simulation.height_map import read_height_map

    heights = np.outer(np.hanning(24), np.hanning(32))

    def run(data: bytes) -> None:
        path = home / ("map.npy" if data[:1] == b"\x93" else "map.png")
        path.write_bytes(data)
        read_height_map(path, 0.1)

    image = cv2.imencode(".png", (heights * 65535).astype(np.uint16))[1].tobytes()
    words = (b"'shape': (", b"<f8", b"nan", b"9" * 30, b"|O", b"IHDR")
    return Target((_npy(heights), _npy(heights.astype(np.float32)), image), run, words)


def _windows_table(home: Path) -> Target:
    from geotlm_lm.data.labelled_recordings import find_labelled_recordings

    (home / "clips").mkdir()
    np.save(home / "clips" / "a.npy", _frames())

    def run(data: bytes) -> None:
        (home / "windows.csv").write_bytes(data)
        for recordings in find_labelled_recordings(home):
            list(recordings.windows(frames=("four", "pair")))

    seed = (
        b"clip,first_frame,last_frame,direction,object\na.npy,0,5,clockwise,nut\na.npy,1,4,left,\n"
    )
    return Target((seed,), run, (b"clip", b",", b'"', b"\n", b"\0", b"../", b"direction", b"press"))


def _touch_table(home: Path) -> Target:
    from geotlm_lm.data.touch_table import read_touch_table

    def run(data: bytes) -> None:
        (home / "clips.csv").write_bytes(data)
        for row in read_touch_table(home / "clips.csv"):
            row.check_length(FRAMES)

    seed = b"clip,fps,contact_start,contact_end,object\na.npy,25,2,5,nut\nb.npy,10,,,\n"
    return Target(
        (seed,), run, (b"clip", b",", b'"', b"\n", b"\0", b"contact_start", b"\xef\xbb\xbf")
    )


def _record(home: Path) -> Target:
    from geotlm_lm.core.record import RunRecord

    path = home / "run.json"
    RunRecord("run", "command", 0, 1.0, {"a": [1, 2]}).save(path)

    def run(data: bytes) -> None:
        (home / "damaged.json").write_bytes(data)
        RunRecord.load(home / "damaged.json")

    return Target((path.read_bytes(),), run, (b"null", b"[" * 2000, b"{}", b'"format"', b"NaN"))


def _weights(home: Path) -> Target:
    import torch
    from safetensors.torch import save

    from geotlm_lm.backbone.weights import read_tensors

    tensors = {"patch_embed.weight": torch.ones(2, 3), "cls_token": torch.zeros(4)}
    seeds = [save(tensors)]
    for is_zip in (True, False):
        stream = io.BytesIO()
        about = {"model": tensors, "epoch": 3, "args": {"lr": 0.1}}
        torch.save(about, stream, _use_new_zipfile_serialization=is_zip)
        seeds.append(stream.getvalue())

    def run(data: bytes) -> None:
        path = home / "weights.pth"
        path.write_bytes(data)
        read_tensors(path)

    words = (b"cos\nsystem\n", b"F32", b"data_offsets", b"collections\nOrderedDict\n", b"\x80\x02")
    return Target(tuple(seeds), run, words)


def _bundle(home: Path) -> Target:
    """The settings of a model beside its sound weights."""
    from geotlm_lm.checkpoint import load_bundle

    folder = home / "bundle"
    shutil.copytree(resource_dir("bundle"), folder)
    names = ("config.json", "language/config.json", "language/processor_config.json")
    sound = {name: (folder / name).read_bytes() for name in names}
    answers = json.loads((folder / "answers.json").read_text())[:3]
    sound["answers.json"] = json.dumps(answers).encode()

    def run(data: bytes) -> None:
        for name, stored in sound.items():
            (folder / name).write_bytes(stored)
        head, _, text = data.partition(b"\n")
        (folder / names[0] if head not in named else folder / named[head]).write_bytes(text)
        load_bundle(folder)

    named = {str(place).encode(): name for place, name in enumerate(sound)}
    seeds = tuple(head + b"\n" + sound[name] for head, name in named.items())
    words = (b"null", b"{}", b"[]", b'"', b"true", b"-1", b"1e400", b"NaN", b",", b":")
    return Target(seeds, run, words)


TARGETS: dict[str, Prepare] = {
    "array": _array,
    "archive": _archive,
    "archive member": _member,
    "avi": partial(_video, ".avi", "MJPG"),
    "mp4": partial(_video, ".mp4", "mp4v"),
    "mov": partial(_video, ".mov", "mp4v"),
    "mkv": partial(_video, ".mkv", "FFV1"),
    "webm": partial(_video, ".webm", "VP80"),
    "played video": _played,
    "image": _image,
    "stack": _stack,
    "height map": _height_map,
    "table of windows": _windows_table,
    "table of touches": _touch_table,
    "record of a run": _record,
    "weights": _weights,
    "bundle": _bundle,
    "rules on words": rules,
    "question": question,
    "conversation": conversation,
}
"""By name."""
