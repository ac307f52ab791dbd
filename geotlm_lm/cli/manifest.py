"""`geotlm-lm manifest`: list the clips of a data set whose layout is its owner's own."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import typer

from geotlm_lm.cli.options import Force, grouped, option, require_new_file
from geotlm_lm.core.errors import UsageError


@grouped
def manifest(
    root: Path = option("Folder of the data set, pictures anywhere in it."),
    pattern: str = option(
        "Regular expression over paths below --root with the named groups object, action and, "
        "where there are such, sensor, trial and frame.",
    ),
    out: Path = option("The manifest to write, .csv or .jsonl."),
    background_frame: str | None = option(
        "What the frame group says of the untouched gel's picture, if one lies among a clip's "
        "frames.",
        metavar="NAME",
    ),
    action: list[str] | None = option(
        "What a word in the paths means: rotate_cw, rotate_ccw, slide_left, slide_right, slide_up "
        "or slide_down; may be given again.",
        metavar="WORD=ACTION",
    ),
    force: Force = False,
    fps: float | None = option("Frames per second. [default: unknown]", min=0.01),
) -> None:
    """Gather pictures into clips by their names, for `geotlm-lm evaluate --data`.

    Example: geotlm-lm manifest --root ToucHD-Sim --out touchd.csv --pattern
    '(?P<object>[^/]+)/(?P<sensor>[^/]+)/(?P<action>[^/]+)/(?P<trial>[^/]+)/(?P<frame>[0-9]+)[.]png'
    """
    from geotlm_lm.data.manifest import SUFFIXES, make_manifest, write_manifest

    if out.suffix.lower() not in SUFFIXES:
        raise UsageError(f"--out {out} was given, expected a name that ends in .csv or .jsonl.")
    require_new_file(out, "--out", is_forced=force)
    made = make_manifest(
        root,
        pattern,
        relative_to=out.parent,
        background_frame=background_frame,
        actions=_meanings(action or []),
        fps=fps,
    )
    write_manifest(out, made.rows)
    counts = Counter(row.motion for row in made.rows)
    objects = len({row.object_id for row in made.rows})
    sensors = len({row.sensor for row in made.rows})
    motions = ", ".join(f"{count} {motion}" for motion, count in sorted(counts.items()))
    typer.echo(
        f"{out}: clips: {len(made.rows)}, objects: {objects}, sensors: {sensors}; "
        f"{motions or 'none'}"
    )
    passed_over = {
        "pictures that do not fit the pattern": made.unmatched,
        "clips of less than two frames, left out": made.too_short,
    }
    for what, names in passed_over.items():
        if names:
            typer.echo(f"{what}: {len(names)}, the first {names[0]}", err=True)


def _meanings(words: list[str]) -> dict[str, str]:
    meanings = {}
    for word in words:
        token, sign, action = word.rpartition("=")
        if not sign or not token:
            raise UsageError(f"--action '{word}' was given, expected WORD=ACTION.")
        meanings[token] = action
    return meanings
