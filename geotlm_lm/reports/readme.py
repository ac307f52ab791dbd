"""README blocks and pages written from run records, so that no number is typed by hand.

A page lies beside the folder of records. A block stands between `<!-- begin: NAME -->` and
`<!-- end: NAME -->`; what is between is replaced.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

from geotlm_lm.core.atomic import write_text_atomically
from geotlm_lm.core.errors import GeoTLMError
from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.backbones import backbones_page
from geotlm_lm.reports.cameras import cameras_headline, cameras_page
from geotlm_lm.reports.confusions import FOLDER, stale_pictures
from geotlm_lm.reports.fuzz import fuzz_page
from geotlm_lm.reports.headline import (
    accuracy_headline,
    difference_headline,
    false_claim_headline,
    time_headline,
)
from geotlm_lm.reports.language import language_headline, language_page
from geotlm_lm.reports.odometry import odometry_page
from geotlm_lm.reports.optics import optics_report
from geotlm_lm.reports.page import page_times
from geotlm_lm.reports.protocols import protocols_headline, protocols_page
from geotlm_lm.reports.runtime import runtime_headline, runtime_page
from geotlm_lm.reports.simulator import (
    closed_forms_page,
    rate_table,
    simulator_page,
    simulator_stability_page,
)
from geotlm_lm.reports.sizes import sizes_page
from geotlm_lm.reports.stability import stability_page
from geotlm_lm.reports.tables import answer_example, evaluation_page, training_overview
from geotlm_lm.reports.transcript import transcript_page

BLOCKS: dict[str, tuple[str, Callable[[RunRecord], str]]] = {
    "accuracy": ("evaluate.json", accuracy_headline),
    "differences": ("evaluate.json", difference_headline),
    "false-claims": ("evaluate.json", false_claim_headline),
    "times": ("evaluate.json", time_headline),
    "example": ("answer.json", answer_example),
    "training": ("train.json", training_overview),
    "page": ("page.json", page_times),
    "simulator": ("simulator.json", rate_table),
    "language": ("language.json", language_headline),
    "protocols": ("protocols.json", protocols_headline),
    "runtime": ("runtime.json", runtime_headline),
    "cameras": ("cameras.json", cameras_headline),
}
"""Block name -> the record it is made from, and how."""

_COMMANDS = dict.fromkeys(BLOCKS, "geotlm-lm evaluate --out reports/recorded/evaluate.json") | {
    "example": "geotlm-lm report answer",
    "page": "geotlm-lm report page",
    "simulator": "geotlm-lm report simulator",
    "language": "geotlm-lm report language",
    "protocols": "geotlm-lm report protocols",
    "runtime": "geotlm-lm report runtime",
    "cameras": "geotlm-lm report cameras",
    "training": "cp geotlm_lm/bundle/scores.json reports/recorded/train.json",
}

PAGES: dict[str, tuple[str, Callable[[RunRecord], str]]] = {
    "evaluation.md": ("evaluate.json", evaluation_page),
    "protocols.md": ("protocols.json", protocols_page),
    "language.md": ("language.json", language_page),
    "runtime.md": ("runtime.json", runtime_page),
    "cameras.md": ("cameras.json", cameras_page),
    "odometry.md": ("odometry.json", odometry_page),
    "sizes.md": ("sizes.json", sizes_page),
    "backbones.md": ("backbones.json", backbones_page),
    "stability.md": ("stability.json", stability_page),
    "transcript.md": ("transcript.json", transcript_page),
    "fuzz.md": ("fuzz.json", fuzz_page),
    "simulator.md": ("simulator.json", simulator_page),
    "simulator_stability.md": ("simulator_stability.json", simulator_stability_page),
    "closed_forms.md": ("closed_forms.json", closed_forms_page),
    "optics.md": ("optics.json", optics_report),
}
"""Page -> the record it is made from, and how; written where there is that record."""

ILLUSTRATED = ("evaluation.md",)
"""Pages that show who is taken for whom in pictures."""

_BEGIN = re.compile(r"^<!-- begin: (\S+) -->$", re.MULTILINE)


class UnusableReadme(GeoTLMError):
    """A README's blocks cannot be written, or do not agree with the records."""


def fill_blocks(text: str, records: Path) -> str:
    """Return `text` with every block rewritten from the records.

    Args:
        text: The README.
        records: The folder of recorded runs.

    Raises:
        UnusableReadme: If a block is unknown or not closed, or its record is missing.
    """
    parts = []
    position = 0
    for begin in _BEGIN.finditer(text):
        name = begin[1]
        closing = f"<!-- end: {name} -->"
        end = text.find(closing, begin.end())
        if end < 0:
            raise UnusableReadme(f"block '{name}' is not closed; add the line {closing} below it.")
        parts += [text[position : begin.end()], "\n\n", _content(name, records), "\n\n"]
        position = end
    return "".join([*parts, text[position:]])


def write_readme(readme: Path, records: Path) -> bool:
    """Rewrite the blocks of a README and the pages; return whether anything changed.

    Raises:
        UnusableReadme: As in `fill_blocks`, or if the README is missing.
    """
    wanted = _wanted(readme, records)
    changed = [path for path, text in wanted.items() if not path.exists() or _read(path) != text]
    for path in changed:
        write_text_atomically(path, wanted[path])
    return bool(changed)


def check_readme(readme: Path, records: Path) -> None:
    """Compare the blocks of a README, the pages and their pictures with the records.

    Raises:
        UnusableReadme: If one says something else than its record.
    """
    for path, text in _wanted(readme, records).items():
        if not path.exists() or _read(path) != text:
            raise UnusableReadme(
                f"{path}: its numbers differ from the records in {records}; run "
                f"`geotlm-lm report readme`."
            )
    for page, (name, _) in PAGES.items():
        if page not in ILLUSTRATED or not (records / name).is_file():
            continue
        for picture in stale_pictures(RunRecord.load(records / name), records.parent / FOLDER):
            raise UnusableReadme(
                f"{picture}: is missing or shows other numbers than {records / name}; run "
                f"`geotlm-lm report confusions`."
            )


def _wanted(readme: Path, records: Path) -> dict[Path, str]:
    wanted = {readme: fill_blocks(_read(readme), records)}
    for page, (name, render) in PAGES.items():
        if (records / name).is_file():
            wanted[records.parent / page] = render(RunRecord.load(records / name))
    return wanted


def _content(name: str, records: Path) -> str:
    if name not in BLOCKS:
        raise UnusableReadme(f"block '{name}' is not known; expected one of {', '.join(BLOCKS)}.")
    file_name, render = BLOCKS[name]
    path = records / file_name
    if not path.is_file():
        raise UnusableReadme(
            f"{path}: the record of block '{name}' is missing; write it with `{_COMMANDS[name]}`."
        )
    return render(RunRecord.load(path)).strip()


def _read(readme: Path) -> str:
    try:
        return readme.read_text(encoding="utf-8")
    except OSError as error:
        raise UnusableReadme(
            f"{readme}: cannot be read ({error.strerror}); run from the checkout or give --readme."
        ) from error
