"""The documentation as a site: the strict build passes, and it fails where a link is broken."""

import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CONFIG = ROOT / ".zensical.toml"
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
FENCED = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)\s]*)?\)")
README_LIMIT = 12_288

pytestmark = pytest.mark.slow


def build(folder):
    """Build a copy of the site; the tool's own cache and output stay in the copy."""
    command = [sys.executable, "-m", "zensical", "build", "--clean", "--strict"]
    return subprocess.run(
        [*command, "-f", str(folder / CONFIG.name)], capture_output=True, text=True, cwd=folder
    )


@pytest.fixture
def copy(tmp_path):
    pytest.importorskip("zensical", reason="building the site needs zensical (extra: dev)")
    shutil.copy(CONFIG, tmp_path)
    shutil.copytree(ROOT / "docs", tmp_path / "docs")
    return tmp_path


def test_the_site_builds_without_a_warning(copy):
    done = build(copy)
    assert done.returncode == 0, done.stdout + done.stderr
    assert (copy / "build/site/index.html").exists()


@pytest.mark.parametrize("link", ["[page](nowhere.md)", "[part](asking.md#nowhere)"])
def test_a_broken_link_fails_the_build(copy, link):
    page = copy / "docs/index.md"
    page.write_text(f"{page.read_text()}\n{link}\n")
    assert build(copy).returncode != 0


# The build passes over pictures, files that are no pages, and pages that the menu names wrongly.


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_whatever_a_page_shows_or_links_is_there(page):
    text = FENCED.sub("", page.read_text())
    missing = [
        target
        for target in LINK.findall(text)
        if "://" not in target and not (page.parent / target).is_file()
    ]
    assert missing == []


def test_the_menu_names_every_page_once():
    def files(entries):
        for entry in entries:
            for target in entry.values():
                yield from [target] if isinstance(target, str) else files(target)

    named = list(files(tomllib.loads(CONFIG.read_text())["project"]["nav"]))
    pages = [str(page.relative_to(ROOT / "docs")) for page in PAGES[1:]]
    assert sorted(named) == sorted(pages)


def test_the_readme_is_short():
    assert len((ROOT / "README.md").read_bytes()) <= README_LIMIT
