import pytest
from typer.testing import CliRunner

from geotlm_lm.cli.report import app
from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.readme import UnusableReadme

BLOCK = "<!-- begin: accuracy -->\n<!-- end: accuracy -->\n"


@pytest.fixture
def invoke(tmp_path):
    (tmp_path / "README.md").write_text(BLOCK)
    RunRecord("evaluate", "geotlm-lm evaluate", 0, 1.0, {"tables": {}}).save(
        tmp_path / "recorded" / "evaluate.json"
    )
    places = ["--readme", str(tmp_path / "README.md"), "--records", str(tmp_path / "recorded")]
    return lambda *arguments: CliRunner().invoke(app, ["readme", *places, *arguments])


def test_the_readme_is_written_and_then_up_to_date(invoke):
    assert invoke().stdout.endswith("README.md: updated\n")
    assert invoke().stdout.endswith("README.md: already up to date\n")
    assert invoke("--check").exit_code == 0


def test_a_stale_readme_fails_the_check(invoke):
    assert isinstance(invoke("--check").exception, UnusableReadme)
