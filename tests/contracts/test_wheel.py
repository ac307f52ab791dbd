"""A built wheel answers from an empty folder, and puts nothing at the top but geotlm_lm."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not (ROOT / "pyproject.toml").exists(), reason="needs the checkout"),
]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Build the wheel of the checkout, without network and without an isolated environment."""
    pytest.importorskip("hatchling", reason="building a wheel needs hatchling (extra: dev)")
    folder = tmp_path_factory.mktemp("dist")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(folder)]
    done = subprocess.run([*command, str(ROOT)], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return next(folder.glob("*.whl"))


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """Unpack the wheel as an installer would, into a folder of its own."""
    folder = tmp_path_factory.mktemp("site")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder)
    return folder


def run_in_empty_folder(installed, tmp_path, *arguments):
    environment = os.environ | {"PYTHONPATH": str(installed), "OMP_NUM_THREADS": "1"}
    return subprocess.run(
        [sys.executable, *arguments], cwd=tmp_path, env=environment, capture_output=True, text=True
    )


def test_nothing_but_the_package_lands_at_the_top(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    tops = {name.split("/")[0] for name in names}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"geotlm_lm"}
    assert "geotlm_lm/answering/answer.schema.json" in names


@pytest.mark.parametrize("folder", ["prompts", "data_templates", "app", "bundle"])
def test_every_resource_is_found_inside_the_installed_package(installed, tmp_path, folder):
    if folder == "bundle" and not (ROOT / "geotlm_lm" / "bundle").is_dir():
        pytest.skip("this checkout holds no trained bundle")
    program = f"from geotlm_lm.core.files import resource_dir as r; print(r({folder!r}))"
    done = run_in_empty_folder(installed, tmp_path, "-c", program)
    assert done.stdout.strip() == str(installed / "geotlm_lm" / folder), done.stderr


def test_training_data_stays_behind_and_training_says_so(wheel, installed, tmp_path):
    with zipfile.ZipFile(wheel) as archive:
        names = [name for name in archive.namelist() if "/data_templates/" in name]
    assert {Path(name).name for name in names} == {"quantities.toml"}
    command = ["-m", "geotlm_lm", "train", "--preset", "smoke", "--out", "run"]
    done = run_in_empty_folder(installed, tmp_path, *command)
    assert (done.returncode, done.stderr.splitlines()[-1]) == (
        7,
        "The wordings that training reads are part of the repository, not of the installed "
        "package; run this from a checkout.",
    )


@pytest.mark.skipif(not (ROOT / "geotlm_lm" / "bundle").is_dir(), reason="needs the trained bundle")
def test_the_installed_command_answers_in_an_empty_folder(installed, tmp_path):
    question = ["--q", "Which way is it turning?"]
    for command in (["simulate"], ["answer", *question]):
        words = ["-m", "geotlm_lm", *command, "--clip", "clip.npz"]
        done = run_in_empty_folder(installed, tmp_path, *words)
        assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) == 1
