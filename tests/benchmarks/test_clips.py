from collections import Counter

import numpy as np
import pytest

from geotlm_lm.benchmarks import variants
from geotlm_lm.benchmarks.cases import HALVES, half_of, is_reported
from geotlm_lm.benchmarks.clips import clip_rows, left_out
from geotlm_lm.benchmarks.harness import Run
from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.labels import Motion
from tests.benchmarks.fakes import ALL, FakeAnswerer


@pytest.fixture
def folder(tmp_path):
    """Two recordings whose last pixel names the motion that is shown, at every frame."""
    rng = np.random.default_rng(0)
    (tmp_path / "clips").mkdir()
    rows = ["clip,first_frame,last_frame,direction"]
    for direction in ("clockwise", "counterclockwise"):
        frames = rng.integers(100, 120, (12, 32, 32, 3)).astype(np.uint8)
        frames[:, -1, -1] = ALL.index(Motion(direction))
        np.save(tmp_path / "clips" / f"{direction}.npy", frames)
        rows.append(f"{direction}.npy,2,9,{direction}")
    rows.append("clockwise.npy,2,9,up-left")
    (tmp_path / "windows.csv").write_text("\n".join(rows) + "\n")
    return tmp_path


def judged(folder=None, count=0, **options):
    """Rows by set of clips and variant."""
    run = Run(seed=1, clips=count, real=folder, answerer_given=FakeAnswerer(), **options)
    found = {}
    for row in clip_rows(run):
        found.setdefault(row.case, {})[row.variant] = row
    return found


def test_real_recordings_are_judged_both_ways_and_both_cuts(folder):
    found, name = judged(folder), folder.name
    # The fake reads the forward label off every frame, so it is right forwards and wrong backwards;
    # it does not see that a clip was turned.
    assert {case: own[variants.GENERATED].right for case, own in found.items()} == {
        f"real {name}, four frames": 0.5,
        f"real {name}, pairs": 0.5,
        f"real {name}, no idle frame": 0.5,
        f"real {name}, turned by a quarter": 0.0,
    }
    first = found[f"real {name}, four frames"]
    assert left_out(next(iter(first.values()))) == "1 labelled up-left"
    assert first[variants.LEANING].detail["rival"]["name"] in variants.RIVALS


def test_halves_are_judged_apart_and_never_in_one_row(folder):
    with (folder / "windows.csv").open("a") as table:
        table.write("clockwise.npy,1,8,clockwise\n")
    run = Run(seed=1, clips=0, real=folder, answerer_given=FakeAnswerer())
    own = [row for row in clip_rows(run, HALVES) if row.variant == variants.FLOW]
    four = {row.case: row.count for row in own if "four frames" in row.case}
    families = Counter({"clockwise": 2, "counterclockwise": 1})
    expected = {half: 0 for half in HALVES}
    for family, count in families.items():
        expected[half_of(family)] += 2 * count
    name = folder.name
    assert four == {f"real {name}, four frames, {h}": n for h, n in expected.items() if n}
    assert [row.case for row in own if is_reported(row)] == [
        row.case for row in own if row.case.endswith(", report")
    ]


def test_turns_and_slides_of_one_folder_are_asked_as_tasks(folder):
    frames = np.load(folder / "clips" / "clockwise.npy")
    frames[:, -1, -1] = ALL.index(Motion.LEFT)
    np.save(folder / "clips" / "left.npy", frames)
    with (folder / "windows.csv").open("a") as table:
        table.write("left.npy,2,9,left\n")
    found = judged(folder)
    turns = found[f"real {folder.name} rotation, four frames"][variants.PROBE]
    slides = found[f"real {folder.name} sliding, four frames"][variants.PROBE]
    assert set(turns.detail["recall"]) == {"clockwise", "counterclockwise"}
    assert (set(slides.detail["recall"]), slides.count) == ({"left", "right"}, 2)


def test_imprints_of_a_touch_are_moved(folder):
    frames = np.full((30, 32, 32, 3), 100, np.uint8)
    frames[8:, 8:20, 8:20] += 40
    np.save(folder / "clips" / "cap.npy", frames)
    (folder / "clips.csv").write_text(
        "clip,object,fps,contact_start,contact_end\nclips/cap.npy,cap,10,8,28\n"
    )
    found, name = judged(folder), f"semi-real {folder.name}"
    parts = {case: set(own[variants.FLOW].detail["recall"]) for case, own in found.items()}
    assert {case: parts[case] for case in parts if case.startswith(name)} == {
        f"{name}, sliding": {"left", "right"},
    }


def test_a_run_without_a_single_clip_is_refused_with_the_first_reason(tmp_path):
    listed = tmp_path / "listed.csv"
    listed.write_text("clip_id,object_id,action,frames\n1,cap,rotate_cw,gone.npy\n")
    with pytest.raises(UnreadableClip) as caught:
        judged(data=[listed])
    assert str(caught.value) == (
        f"no clip could be judged ({tmp_path / 'gone.npy'}: no such file or folder; check the "
        f"path.); give other data."
    )
