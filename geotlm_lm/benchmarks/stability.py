"""The stability bench: damaged, extreme and stiff inputs, and how firm the numbers are."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from geotlm_lm.benchmarks.cases.stiff import RESIDUALS
from geotlm_lm.benchmarks.numerics import numerics_rows
from geotlm_lm.benchmarks.rendering import number, save_figure
from geotlm_lm.benchmarks.rows import Bench, Listing, Pivot, Row, Section, every
from geotlm_lm.benchmarks.stability_files import ENDS, file_rows
from geotlm_lm.benchmarks.stability_rows import (
    CRASHED,
    OUTCOMES,
    damage_rows,
    extreme_rows,
    scene_rows,
)


def failures_headline(rows: Sequence[Row]) -> str:
    """Return what fails, by name: crashes, and answers that are wrong at 0.9 or more."""
    return (
        f"- crashed: {_named(rows, CRASHED)}\n"
        f"- a wrong direction at 0.9 or more: {_named(rows, 'confident_false_directions')}\n"
        f"- a touch or motion overlooked at 0.9 or more: {_named(rows, 'confident_oversights')}"
    )


def _named(rows: Sequence[Row], count: str) -> str:
    """Return the 12 rows with most of what `count` counts, and of how many clips that is."""
    found = [row for row in rows if row.detail.get(count)]
    found.sort(key=lambda row: -row.detail[count] / row.count)
    names = [f"{row.case}, {row.variant} {row.detail[count]}/{row.count}" for row in found]
    return ", ".join(names[:12]) or "none"


OUTCOMES_ABOUT = """\
Every clip is asked which way it moves, and a row counts what became of that. *False directions*
are wrong answers that name a turn or a slide; *wrong* is their share among the answers given, with
its 95 % interval, *probability* the mean stated with them. Quoted is the gravest case."""

DAMAGE_ABOUT = f"""\
Simulated objects kept from training, damaged more and more. A fifth of training's clips were
damaged as well: by JPEG, a dim or drifting camera, or a fainter touch. {OUTCOMES_ABOUT}"""

EXTREME_ABOUT = f"Where nothing can be told, only silence or a refusal is right. {OUTCOMES_ABOUT}"

SCENES_ABOUT = """\
What the contact solver makes of a scene in two number formats, and what the model says of its four
frames. The error is how far single precision drags the surface elsewhere than double, um."""

NUMERICS_ABOUT = """\
As written, Eq. 5 shrinks a unit field under a faint mask; the exposed mass undoes that
(*recovered*). A half without contact reads as a turn would, and *its mass*, 0, says so. By what the
mask is the sigmoid of, which training changes, gradients stay bounded. Formats are held against
float64, the descriptor's error in parts of its largest number; *geometry* is standardisation, DGR
and probes."""

FILES_ABOUT = "Every format that is read, damaged: each must be read or refused in one sentence."

Columns = dict[str, Callable[[Row], str]]


def _details(form: str, *names: str) -> Columns:
    """Return columns of a row's detail, titled by their names; "-" where there is none."""
    return {
        name.replace("_", " "): lambda row, name=name: number(row.detail.get(name), form)
        for name in names
    }


def _plain(row: Row) -> str:
    return " ".join(row.outcome.replace("|", "/").split())  # a bar would end the cell


def _wrong(row: Row) -> str:
    low_high = f" ({row.interval[0]:.2f}-{row.interval[1]:.2f})" if row.interval else ""
    return number(row.error, ".2f") + low_high


def _listing(case: str, variant: str, *columns: Columns) -> Listing:
    shown: Columns = {case: lambda row: row.case, variant: lambda row: row.variant}
    shown["n"] = lambda row: str(row.count)
    return Listing({title: cell for some in (shown, *columns) for title, cell in some.items()})


_COUNTS, _WRONG = _details("d", *OUTCOMES, "false_directions"), {"wrong of answers": _wrong}
_PROBABILITY, _QUOTED = _details(".2f", "probability"), {"says": _plain}
_CONTACT = _details(".1e", "pooled", "recovered", "empty_half", "its_mass", "by_mask", "by_logit")
_ERROR: Columns = {"error": lambda row: number(row.error, ".0e")}
_RESIDUALS = _details(".1e", *RESIDUALS)
_RIGHT = _details("d", "right", "answers_changed")


def draw_damage(rows: Sequence[Row], path: Path) -> None:
    """Draw, for each kind of damage, accuracy, stated probability and refusals over its levels."""
    from matplotlib.figure import Figure

    kinds = {name: [row for row in rows if row.case == name] for name in (r.case for r in rows)}
    kinds = {name: own for name, own in kinds.items() if len(own) > 1}
    lines, nan = -(-len(kinds) // 4), float("nan")
    figure = Figure(figsize=(12.8, 2.4 * lines), layout="constrained")
    panels = list(figure.subplots(lines, 4, squeeze=False).flat)
    for (name, own), axes in zip(kinds.items(), panels, strict=False):
        levels, unit = zip(*(row.variant.partition(" ")[::2] for row in own), strict=True)
        right = [nan if row.right is None else row.right for row in own]
        silent = [(row.detail["refused"] + row.detail["abstained"]) / row.count for row in own]
        axes.plot(levels, right, "o-", label="right, of answers")
        axes.plot(levels, [row.detail["probability"] or nan for row in own], "s--", label="stated")
        axes.plot(levels, silent, "x:", label="refused or abstained")
        axes.set(title=name, xlabel=unit[0], ylim=(-0.05, 1.05))
        axes.grid(alpha=0.3)
    for axes in panels[len(kinds) :]:
        axes.set_axis_off()
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    save_figure(figure, rows, path)


def _has(name: str) -> Callable[[Row], bool]:
    return lambda row: name in row.detail


_ASKED = {"": (_listing("clips", "level", _COUNTS, _WRONG, _PROBABILITY, _QUOTED), every)}
_SCENE_VIEWS = {
    "": (Pivot(_plain, "scene", with_count=False), every),
    "Residuals": (_listing("scene", "format", _RESIDUALS, _ERROR), _has(RESIDUALS[0])),
}
_NUMERICS_VIEWS = {
    "Contact that vanishes": (_listing("mask", "", _CONTACT), _has("pooled")),
    "Number formats": (_listing("parts", "format", _ERROR, _RIGHT), _has("answers_changed")),
}
_FILE_VIEW = {"": (_listing("file", "damage", _details("d", *ENDS), _QUOTED), every)}

STABILITY = Bench(
    "stability",
    "Stability",
    "What becomes of damaged, extreme and stiff inputs, and how firm the numbers are.",
    (
        Section(
            "damage",
            "Damaged clips",
            DAMAGE_ABOUT,
            damage_rows,
            _ASKED,
            draw_damage,
            failures_headline,
        ),
        Section(
            "extreme",
            "Extreme recordings",
            EXTREME_ABOUT,
            extreme_rows,
            _ASKED,
            None,
            failures_headline,
        ),
        Section(
            "scenes",
            "Stiff and extreme scenes",
            SCENES_ABOUT,
            scene_rows,
            _SCENE_VIEWS,
            None,
            failures_headline,
        ),
        Section("numerics", "Numerics", NUMERICS_ABOUT, numerics_rows, _NUMERICS_VIEWS),
        Section("files", "Damaged files", FILES_ABOUT, file_rows, _FILE_VIEW),
    ),
)
