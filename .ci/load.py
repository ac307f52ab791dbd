"""Measure how long questions take at a served page that others use: `python .ci/load.py`.

First a recording of five seconds is opened on the stage and asked about, with nobody beside, then
one of two minutes, without and with somebody who asks about a clip meanwhile. Then three recordings
of 250 frames are tracked over and over while one visitor asks; then twenty visitors ask at once,
each about its own example. An answer that differs from the one given to the same question alone is
a mixed one. Every request of visitors goes through the page's own queue, and comes from a process
of its own, as theirs do.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from threading import Event

import cv2
import httpx
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from app import ui
from app.__main__ import own_cache_folder
from app.ask_tab import Opening
from app.conversation import Talking
from app.sources import EXAMPLES, RECORDING_FOLDER
from app.toolkit import report_progress
from app.turns import AnswererInTurns, Turns
from geotlm_lm import Answerer, Touch, read_clip, simulate_touch

QUESTIONS = ("Which way is it turning?", "Is it sliding to the left?", "How far did it go?")
FRAMES, RECORDINGS, VISITORS, ROUNDS = 250, 3, 20, 3
OPENED_S, REPEATS, LONG_S = 5, 10, 120

CLIENT = httpx.Client(timeout=600, limits=httpx.Limits(max_connections=None))


def ask(address: str, **given: object) -> tuple[dict, float]:
    """Return a tool's result, and the seconds until it was there."""
    tool = given.pop("tool", "ask")
    started = time.perf_counter()
    url = f"{address}gradio_api/call"
    call = CLIENT.post(f"{url}/v2/{tool}", json=given).json()
    with CLIENT.stream("GET", f"{url}/{tool}/{call['event_id']}") as told:
        lines = [line for line in told.iter_lines() if line]
    if "event: complete" not in lines:
        raise RuntimeError(f"{tool} {given}: {lines}")
    return json.loads(lines[-1].removeprefix("data: "))[0], time.perf_counter() - started


def write_recordings(folder: Path) -> list[str]:
    """Write recordings of a key that is turned to and fro, and return their names."""
    names = []
    for seed in range(RECORDINGS):
        clip = simulate_touch(Touch("key", twist_deg=12.0, slide_x_mm=0.5, seed=seed)).clip
        touched = np.concatenate([clip.frames, clip.frames[::-1]])
        idle = np.repeat(clip.background[None], 20, axis=0)
        turned = np.tile(touched, (FRAMES // len(touched), 1, 1, 1))
        noise = np.random.default_rng(seed).integers(0, 3, (FRAMES, *clip.background.shape))
        frames = np.concatenate([idle, turned])[:FRAMES] // 2 * 2 + noise[:FRAMES].astype(np.uint8)
        names.append(f"long{seed}.npz")
        np.savez(folder / names[-1], frames=frames, fps=25.0)
    return names


def opened(answerer: Answerer, folder: Path) -> None:
    """Print how long a recording of five seconds takes to its timeline, and a question of it."""
    clip = read_clip(folder / write_recordings(folder)[0])
    path = folder / "dropped.mov"
    size = clip.frames.shape[2], clip.frames.shape[1]
    film = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"mp4v"), 25.0, size)
    for frame in clip.frames[: OPENED_S * 25]:
        film.write(cv2.cvtColor(frame, cv2.COLOR_RGB2BGR))
    film.release()
    shown, told = [], []
    for _ in range(REPEATS):
        opening, started = Opening(answerer), time.perf_counter()
        *_, filled = opening.upload([str(path)], [], None, None)
        shown.append(time.perf_counter() - started)
        if not filled["stage"]["timeline"]:
            raise RuntimeError("no timeline was shown")
        talking, started = Talking(answerer), time.perf_counter()
        list(talking.ask("How far in total?", filled["shown"], [], 0))
        told.append(time.perf_counter() - started)
    tell(f"a .mov of {OPENED_S} s from its upload to its timeline", shown)
    tell("from a question of it to its answer", told)


def opened_long(answerer: Answerer, folder: Path) -> None:
    """Print when the first of two minutes stands on the timeline, and when all, beside an asker."""
    frames = read_clip(RECORDING_FOLDER / "key.mov").frames
    path, size = folder / "long.mov", frames.shape[2:0:-1]
    film = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"mp4v"), 25.0, size)
    for number in range(LONG_S * 25):
        film.write(cv2.cvtColor(frames[number % len(frames)], cv2.COLOR_RGB2BGR))
    film.release()
    shared = AnswererInTurns(answerer, Turns(report_progress))
    *_, clip = Opening(shared).upload([str(next(iter(EXAMPLES.values())))], [], None, None)
    for is_asked in (False, True):
        ended, taken, first = Event(), [], None

        def ask_on(ended: Event = ended, taken: list[float] = taken) -> None:
            while not ended.wait(0.2):
                started = time.perf_counter()
                list(Talking(shared).ask(QUESTIONS[0], clip["shown"], [], None))
                taken.append(time.perf_counter() - started)

        with ThreadPoolExecutor(1) as pool:
            asking = pool.submit(ask_on) if is_asked else None
            started = time.perf_counter()
            for filled in Opening(shared).upload([str(path)], [], None, None):
                timeline = filled.get("stage", {}).get("timeline")
                if first is None and timeline and timeline["x"][-1] >= LONG_S / 2:
                    first = time.perf_counter() - started
            whole = time.perf_counter() - started
            ended.set()
        beside = " beside an asker" * is_asked
        print(f"of {LONG_S} s the first half after {first:.1f} s, all after {whole:.1f} s{beside}")
        if asking is not None:
            asking.result()
            tell("a question meanwhile", taken)


def under_tracking(address: str, folder: Path, names: list[str], seconds: float) -> None:
    """Print how long questions on what is open take while other recordings are tracked."""
    ended = Event()
    for name in EXAMPLES:
        ask(address, recording=name, question=QUESTIONS[0])

    def track(name: str) -> list[float]:
        taken = []
        while not ended.is_set():
            os.utime(folder / name)  # another recording, as far as the server knows
            taken.append(ask(address, tool="track", recording=name)[1])
        return taken

    with ThreadPoolExecutor(len(names)) as pool:
        running = [pool.submit(track, name) for name in names]
        time.sleep(1)
        until, taken = time.monotonic() + seconds, []
        while time.monotonic() < until:
            for name in EXAMPLES:
                given = {"recording": name, "question": QUESTIONS[len(taken) % len(QUESTIONS)]}
                taken.append(ask(address, **given)[1])
        ended.set()
        tracked = [one for each in running for one in each.result()]
    tell(f"a question while {len(names)} recordings of {FRAMES} frames are tracked", taken)
    tell("a recording beside the others and the questions", tracked)


def at_once(address: str) -> int:
    """Print how long questions of twenty visitors take; return how many answers were mixed."""
    examples = list(EXAMPLES)
    asked = [
        [(examples[(visitor + turn) % len(examples)], QUESTIONS[(visitor + turn) % 3])
         for turn in range(ROUNDS)]
        for visitor in range(VISITORS)
    ]  # fmt: skip

    def one(recording: str, question: str) -> tuple[str, float]:
        result, taken = ask(address, recording=recording, question=question)
        return result["text"], taken

    alone = {pair: one(*pair)[0] for pair in sorted({pair for each in asked for pair in each})}
    with ThreadPoolExecutor(VISITORS) as pool:
        told = list(pool.map(lambda pairs: [(pair, *one(*pair)) for pair in pairs], asked))
    tell(f"a question of {VISITORS} visitors at once", [each[2] for some in told for each in some])
    return sum(text != alone[pair] for some in told for pair, text, _ in some)


def tell(what: str, seconds: list[float]) -> None:
    """Print the median and the 95th percentile."""
    half, most = np.percentile(seconds, [50, 95])
    print(f"{what}: median {half:.2f} s, p95 {most:.2f} s, n {len(seconds)}", flush=True)


def main() -> None:
    """Serve the page, measure, and end with 1 if an answer was mixed."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--seconds", type=float, default=30.0, help="to ask beside tracking")
    seconds = options.parse_args().seconds
    with own_cache_folder(), tempfile.TemporaryDirectory() as home:
        folder = Path(home)
        answerer, names = Answerer.load(), write_recordings(folder)
        page = ui.build(answerer, folder)
        address = ui.launch(page)
        try:
            opened(answerer, folder)
            opened_long(answerer, folder)
            with ProcessPoolExecutor(1, get_context("spawn")) as visitors:
                visitors.submit(under_tracking, address, folder, names, seconds).result()
                mixed = visitors.submit(at_once, address).result()
        finally:
            page.close()
    print(f"mixed answers: {mixed}")
    sys.exit(mixed > 0)


if __name__ == "__main__":
    main()
