"""Label a data set on a cluster of two nodes that is killed twice: `python .ci/cluster.py FOLDER`.

First two processes of this machine label it, then a cluster of two nodes of one core each, both
undisturbed: what counts are the seconds of the whole, and those from the first episode done to the
last, in which nothing starts any more. Then the command runs on the cluster and is killed (SIGKILL)
at a third and at two thirds. It has to end with all episodes, none of them done twice, and with the
bytes of the first. Needs the extras lerobot and ray, and an idle machine.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from geotlm_lm import Clip, Touch, simulate_touch
from geotlm_lm.core.record import commit, machine
from geotlm_lm.data_sets.labelling import Labelling, label_data_set
from geotlm_lm.runs.run import Workers
from tests.data_sets.lerobot_files import CAMERA, FPS, write_data_set

ROOT = Path(__file__).resolve().parents[1]

TOUCHES, IDLE, REPEATS, IN_A_FILE = 20, 10, 6, 10
KILLED_AT = (1 / 3, 2 / 3)


def main() -> None:
    """Run it all and print what was found."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--episodes", type=int, default=200)
    asked = parser.parse_args()
    folder, count = asked.folder, asked.episodes
    root = folder / "robot"
    if not root.exists():
        write_data_set(root, episodes(count), in_a_file=IN_A_FILE)
    print(f"commit {commit()}, {machine()['processor']}")
    told = {"two processes": timed(root, folder / "pool", Workers(2))}
    cluster = two_nodes()
    try:
        told["two nodes"] = timed(root, folder / "nodes", Workers(2, cluster.address))
        killed(root, folder / "killed", cluster.address, count)
    finally:
        cluster.shutdown()
    for name, (whole_s, steady_s) in told.items():
        rate = (count - 1) / steady_s
        print(f"{name}: {whole_s:.1f} s, {rate:.2f} episodes a second once begun")
    (pool_s, pool_steady_s), (nodes_s, nodes_steady_s) = told.values()
    print(f"nodes against processes: {pool_s / nodes_s:.2f} with the start counted, ", end="")
    print(f"{pool_steady_s / nodes_steady_s:.2f} without")
    same = files_of(folder / "pool") == files_of(folder / "nodes") == files_of(folder / "killed")
    print("all bytes are equal" if same else "BYTES DIFFER")
    sys.exit(not same)


def episodes(count: int) -> list[Clip]:
    """Return simulated touches, there and back between idle gel, each begun elsewhere."""
    objects, touches = ("key", "coin", "hex_nut"), []
    for seed in range(TOUCHES):
        turn, slide = 10.0 * (-1) ** seed, 0.1 * (seed % 6)
        touch = Touch(objects[seed % 3], twist_deg=turn, slide_x_mm=slide, seed=seed)
        clip = simulate_touch(touch).clip
        idle = np.repeat(clip.background[None], IDLE, axis=0)
        moved = np.tile(np.concatenate([clip.frames, clip.frames[::-1]]), (REPEATS, 1, 1, 1))
        touches.append(np.concatenate([idle, moved, idle]))
    return [Clip(touches[n % TOUCHES][n // TOUCHES % IDLE :], fps=FPS) for n in range(count)]


def two_nodes():
    """Return a cluster of a head and a second node, one core each, on this machine."""
    os.environ |= {"RAY_worker_niceness": "0", "RAY_USAGE_STATS_ENABLED": "0"}
    from ray.cluster_utils import Cluster

    small = {"num_cpus": 1, "object_store_memory": 100 * 2**20}
    made = Cluster(initialize_head=True, head_node_args=small | {"include_dashboard": False})
    made.add_node(**small)
    return made


def timed(root: Path, out: Path, workers: Workers) -> tuple[float, float]:
    """Return the seconds of a whole run, and those from its first episode to its last."""
    at: list[float] = []
    started = time.perf_counter()
    label_data_set(
        Labelling(root, CAMERA),
        out,
        workers=workers,
        progress=lambda what, done, total: at.append(time.perf_counter()),
    )
    return time.perf_counter() - started, at[-1] - at[0]


def killed(root: Path, out: Path, address: str, count: int) -> None:
    """Run the command, kill it twice on its way, and look whether an episode was done again."""
    command = [sys.executable, "-m", "geotlm_lm", "label", str(root), "--camera", CAMERA]
    command += ["--out", str(out), "--cluster", address]
    before: dict[Path, int] = {}
    for share in KILLED_AT:
        with subprocess.Popen(command, cwd=ROOT, stderr=subprocess.DEVNULL) as running:
            while len(kept(out)) < share * count and running.poll() is None:
                time.sleep(0.01)
            running.kill()
        time.sleep(5)  # the cluster ends the actors of a command that is gone
        now = kept(out)
        print(f"killed with {len(now)} of {count} episodes done")
        require(before.items() <= now.items() and len(before) < len(now) < count)
        before = now
    with subprocess.Popen(command, cwd=ROOT, stderr=subprocess.DEVNULL) as running:
        seen = dict(before)
        while running.poll() is None:
            seen |= kept(out)  # one that is written again has another time
            time.sleep(0.01)
    require(running.returncode == 0 and before.items() <= seen.items())


def kept(out: Path) -> dict[Path, int]:
    """Return what a run has of each episode, and when that was written."""
    found = {}
    for path in out.with_name(f"{out.name}.part").glob("episode-*.npz"):
        try:
            found[path] = path.stat().st_mtime_ns
        except FileNotFoundError:  # the run has ended and cleans up
            continue
    return found


def require(holds: bool) -> None:
    """End with an error where something does not hold."""
    if not holds:
        raise SystemExit("an episode was lost, or done twice")


def files_of(folder: Path) -> dict[str, bytes]:
    """Return what every file of a folder holds."""
    paths = [path for path in folder.rglob("*") if path.is_file()]
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


if __name__ == "__main__":
    main()
