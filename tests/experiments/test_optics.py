"""Real and simulated images side by side: on a made-up folder, the simulator, and real images."""

import csv
from dataclasses import replace
from pathlib import Path as FilePath

import cv2
import numpy as np
import pytest

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.labels import Motion
from geotlm_lm.experiments.optics import compare_optics, compare_values, measured
from geotlm_lm.experiments.optics_imprint import contact_statistics
from geotlm_lm.experiments.optics_recordings import (
    find_real,
    real_touches,
    simulated_balls,
    simulated_touch,
    simulated_touches,
    squared,
)
from geotlm_lm.experiments.optics_statistics import COLOURS, camera_statistics
from geotlm_lm.reports.optics import optics_report
from geotlm_lm.simulation.optics import LIGHTS
from geotlm_lm.simulation.scene import Body, Optics, Path, Scene, VideoCodec

REAL = FilePath(__file__).resolve().parents[3] / "shared" / "real"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Hold a folder of ball stills and four recordings, the last idle too briefly for halves."""
    root = tmp_path_factory.mktemp("real")
    touches = list(simulated_balls(3, 2, (6.0, 9.0)))
    still = root / "calibration" / "unit"
    still.mkdir(parents=True)
    images = {"background": touches[0].idle, "6.000mm_0": touches[0].touched[0]}
    for name, image in images.items():
        cv2.imwrite(str(still / f"{name}.png"), image.astype(np.uint8)[..., ::-1])
    (root / "physiclear").mkdir()
    rows = [["clip", "fps", "contact_start", "contact_end"], ["untouched.npy", "25.0", "", ""]]
    for number, begins in enumerate((20, 20, 20, 8)):
        noise = np.random.default_rng(number).normal(0, 1.5, (begins + 6, 224, 224, 3))
        frames = touches[1].idle + noise
        frames[begins : begins + 4] += touches[1].touched[0] - touches[1].idle
        np.save(root / "physiclear" / f"{number}.npy", frames.clip(0, 255).round().astype(np.uint8))
        rows.append([f"{number}.npy", "25.0", str(begins), str(begins + 3)])
    with (root / "physiclear" / "clips.csv").open("w", newline="") as stream:
        csv.writer(stream).writerows(rows)
    return root


@pytest.fixture(scope="module")
def record(folder):
    return compare_optics(folder, clips=4, seed=0, objects=("key", "ball_medium"), preset="draft")


def row(rows, key):
    return next(one for one in rows if one["key"] == key)


def test_each_source_weighs_the_same():
    found = compare_values({"many": [1.0] * 90, "few": [5.0] * 3}, [2.0])
    assert (found["real"]["low"], found["real"]["high"]) == (1, 5)
    assert found["real"]["count"] == 93
    assert found["sources"]["few"] == {"median": 5, "low": 5, "high": 5, "count": 3}


@pytest.mark.parametrize(("middle", "outside"), [(5.0, 0.0), (-1.0, -2.0), (12.0, 3.0)])
def test_a_median_is_outside_by_its_distance_from_the_spread(middle, outside):
    real = {"unit": list(range(11))}
    assert compare_values(real, [middle - 20, middle, middle + 20])["outside"] == outside


def test_shares_count_what_is_inside_the_other_spread():
    found = compare_values({"a": [0.0, 1.0], "b": [1.0, 8.0, 8.0, 9.0]}, [0.5, 1.0, 2.0, 30.0])
    assert (found["real"]["low"], found["real"]["high"]) == (0, 9)
    assert found["share_inside"] == 0.75
    # Inside 0.5 to 30: half of a, all of b.
    assert found["share_covered"] == 0.75


def test_what_one_side_lacks_is_not_compared():
    assert compare_values({}, [1.0])["real"] is None
    assert "outside" not in compare_values({"unit": [1.0]}, [])


def test_the_record_counts_what_it_measured(record):
    assert record.numbers["touches"] == {
        "calibration/unit": {"recordings": 1, "touches": 1, "faint": 0},
        "physiclear 25 fps": {"recordings": 4, "touches": 4, "faint": 0},
        "simulated": {"recordings": 4, "touches": 4, "faint": 0},
    }
    assert record.config["balls_mm"] == [6.0]


def test_noise_of_recordings_is_measured_and_stills_have_none(record):
    found = row(record.numbers["rows"], "noise G")
    assert found["sources"].keys() == {"physiclear 25 fps"}
    # Rounding to whole grey levels adds a twelfth to the variance.
    assert found["real"]["median"] == pytest.approx(np.sqrt(1.5**2 + 1 / 12), rel=0.03)


def test_a_pattern_is_measured_where_idle_frames_are_far_enough_apart(record):
    assert row(record.numbers["rows"], "pattern R")["real"]["count"] == 3
    assert row(record.numbers["rows"], "level R")["real"]["count"] == 5


def test_noise_between_frames_is_compared_among_videos_only():
    path = Path((0.6,) * 4, (0.0,) * 4, (0.0,) * 4, (0.0,) * 4)
    plain = Optics(noise_grey=(1.7, 1.24, 2.0))
    scenes = [
        Scene(Body("ball_medium"), path, Motion.STILL, optics=optics)
        for optics in (plain, replace(plain, video=VideoCodec(frames_apart=8)))
    ]
    found = measured(simulated_touch(scene, 0, preset="draft") for scene in scenes)["simulated"]
    assert len(found["noise R"]) == 1
    assert found["noise R"][0] < 0.9
    assert len(found["level R"]) == len(found["pattern R"]) == 2


def test_balls_are_held_against_balls_only(record):
    sources = {name for one in record.numbers["balls"] for name in one["sources"]}
    assert sources == {"calibration/unit"}
    assert row(record.numbers["balls"], "sharpness G")["simulated"]["count"] == 4


def test_the_report_has_a_line_for_every_statistic(record):
    text = optics_report(record)
    for one in record.numbers["rows"] + record.numbers["balls"]:
        assert f"| {one['title']} " in text
    assert "Smooth balls of 6 mm diameter." in text


def test_a_folder_without_real_images_is_refused(tmp_path):
    with pytest.raises(UnreadableClip, match=r"found 0 folders of stills .* and 0 touched rec"):
        find_real(tmp_path)


def test_a_table_without_its_columns_is_refused(folder, tmp_path):
    (tmp_path / "physiclear").mkdir()
    (tmp_path / "physiclear" / "clips.csv").write_text("clip,fps\na.npy,25\n")
    with pytest.raises(
        UnreadableClip, match="columns clip, fps, expected clip, fps, contact_start"
    ):
        find_real(tmp_path)


@pytest.mark.parametrize(
    ("span", "says"),
    [
        ("1,9", "touched from frame '1' to '9', expected two numbers in order, the first above"),
        ("8,six", "touched from frame '8' to 'six', expected two numbers"),
        ("8,14", "the table names frame 14, the recording holds frames 0 to 13"),
    ],
)
def test_a_contact_outside_its_recording_is_refused(folder, tmp_path, span, says):
    (tmp_path / "calibration").symlink_to(folder / "calibration")
    (tmp_path / "physiclear").mkdir()
    (tmp_path / "physiclear" / "3.npy").symlink_to(folder / "physiclear" / "3.npy")
    head = "clip,fps,contact_start,contact_end"
    (tmp_path / "physiclear" / "clips.csv").write_text(f"{head}\n3.npy,25,{span}\n")
    with pytest.raises(UnreadableClip, match=says):
        list(real_touches(tmp_path))


def test_large_frames_are_averaged_and_keep_their_levels():
    wide = np.zeros((1, 240, 320, 3), np.uint8)
    wide[..., :160, 0] = 200
    made = squared(wide)
    assert made.shape == (1, 224, 224, 3)
    assert made.mean(axis=(0, 1, 2)) == pytest.approx([100, 0, 0], abs=0.1)


def test_the_simulators_own_noise_and_lights_are_found_again():
    path = Path((0.6,) * 4, (0.0,) * 4, (0.0,) * 4, (0.0,) * 4)
    optics = Optics(noise_grey=(1.7, 1.24, 2.0), drift_grey=0.0)
    touches = simulated_touch(Scene(Body("ball_medium"), path, Motion.STILL, optics=optics), 0)
    noise = camera_statistics(touches.series)
    # Rounding to whole grey levels adds a twelfth to the variance.
    expected = np.sqrt(np.square(optics.noise_grey) + 1 / 12)
    assert [noise[f"noise {c}"] for c in COLOURS] == pytest.approx(expected, rel=0.03)
    contact = contact_statistics(touches.touched[0], touches.idle)
    degrees = np.degrees(np.arctan2(LIGHTS[:, 1], LIGHTS[:, 0]))
    assert [contact[f"light {c}"] for c in COLOURS] == pytest.approx(degrees, abs=4)


def test_the_same_seed_gives_the_same_images():
    first, second = (next(simulated_touches(5, 1, objects=("key",))) for _ in range(2))
    assert np.array_equal(first.touched, second.touched)
    assert np.array_equal(first.series, second.series)
    # Its noise apart, the lifted gel is the idle one.
    assert np.abs(first.series.mean(axis=0) - first.idle).mean() < 4


@pytest.mark.real
@pytest.mark.skipif(not REAL.is_dir(), reason="needs the real images of ../shared/real")
def test_real_ball_presses_show_the_measured_lights_and_channels():
    found = measured([next(real_touches(REAL))])["calibration/ball_press"]
    assert len(found["area"]) == 67
    assert np.median(found["light R"]) == pytest.approx(-96, abs=5)
    assert np.median(found["light G"]) == pytest.approx(8, abs=8)
    assert -0.86 < np.median(found["contact B-R"]) < -0.74
