"""`geotlm-lm bench`: error, run time, stability and what leaving out saves, each one table."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from geotlm_lm.cli.options import (
    AsJson,
    BundleFolder,
    ClusterAddress,
    DataSets,
    EncoderHeads,
    EncoderName,
    EncoderWeights,
    RealFolder,
    Seed,
    path_option,
    require_one_model,
    require_writable,
)
from geotlm_lm.cli.recorded import command_line, require_record_file
from geotlm_lm.core.errors import UsageError
from geotlm_lm.runs.run import Workers

if TYPE_CHECKING:
    from geotlm_lm.benchmarks.harness import Bench, Run
    from geotlm_lm.core.record import RunRecord

app = typer.Typer(
    help="Measure accuracy, error against run time, stability, and what leaving out saves.",
    no_args_is_help=True,
    rich_markup_mode=None,
)

Out = Annotated[
    Path | None,
    path_option(
        "--out", help="Folder for the record, the page and the pictures. [default: only printed]"
    ),
]
Quick = Annotated[
    bool,
    typer.Option("--quick", help="See in under two minutes that everything runs; proves nothing."),
]
Only = Annotated[
    list[str] | None,
    typer.Option(
        "--only",
        help="Only this section; may be given again. The others are kept as recorded in --out.",
    ),
]
Results = Annotated[Path, path_option(help="Folder of pages, records beside them.")]
Readme = Annotated[Path, path_option("--readme", help="The file to fill.")]


@app.command(epilog="Example: geotlm-lm bench accuracy --quick")
def accuracy(
    real: RealFolder = None,
    out: Out = None,
    quick: Quick = False,
    only: Only = None,
    data: DataSets = None,
    weights: EncoderWeights = None,
    encoder: EncoderName = None,
    heads: EncoderHeads = None,
    workers: Annotated[
        int | None,
        typer.Option(
            min=1, help="Processes that share the sections. [default: 1, or as many as a cluster's]"
        ),
    ] = None,
    cluster: ClusterAddress = None,
    seed: Seed = 0,
    model: BundleFolder = None,
    as_json: AsJson = False,
) -> None:
    """Hold the words against linear probes and two classical rivals; run the paper's protocols.

    With --weights, a released encoder takes the embedded one's place in the protocols. Workers
    change no number but times.
    """
    require_one_model(model, weights, encoder, heads)
    from geotlm_lm.benchmarks.harness import EncoderFile

    given = None if weights is None else EncoderFile(weights, encoder, heads)
    by = Workers(1 if workers is None and cluster is None else workers, cluster)
    run = _run(real, quick, seed, model, data=tuple(data or ()), encoder=given, workers=by)
    _measure("accuracy", run, only, out, as_json=as_json)


def _command(name: str, about: str) -> Callable[..., None]:
    """Return the command of a bench that takes no options of its own."""

    def command(
        real: RealFolder = None,
        out: Out = None,
        quick: Quick = False,
        only: Only = None,
        seed: Seed = 0,
        model: BundleFolder = None,
        as_json: AsJson = False,
    ) -> None:
        _measure(name, _run(real, quick, seed, model), only, out, as_json=as_json)

    command.__doc__ = about
    return command


for bench_name, bench_about in {
    "pareto": "Hold error against run time and memory; times need an idle machine.",
    "stability": "Try damaged and extreme clips, stiff scenes, and contact that vanishes.",
    "loop": "Stop a simulated gripper, and watch recordings, by conditions in words.",
    "omissions": "Tell what each stage that is left out saves, and what it costs.",
}.items():
    example = f"Example: geotlm-lm bench {bench_name} --quick"
    app.command(name=bench_name, epilog=example)(_command(bench_name, bench_about))


@app.command(epilog="Example: geotlm-lm bench render --check")
def render(
    check: Annotated[
        bool, typer.Option("--check", help="Change nothing; fail if a number is out of date.")
    ] = False,
    figures: Annotated[bool, typer.Option("--figures", help="Draw the pictures anew too.")] = False,
    results: Results = Path("docs/results"),
    readme: Readme = Path("README.md"),
) -> None:
    """Write pages and the README's numbers from the recorded runs."""
    from geotlm_lm.benchmarks import rendering
    from geotlm_lm.benchmarks.benches import BENCHES

    benches = list(BENCHES.values())
    if check:
        rendering.check_results(benches, results, readme)
        typer.echo("Pages, pictures and README agree with the records.")
        return
    if figures:
        rendering.redraw_figures(benches, results)
    changed = rendering.render_results(benches, results, readme)
    typer.echo(f"{len(changed)} files changed.")


def _run(real: Path | None, quick: bool, seed: int, model: Path | None, **more: object) -> Run:
    from geotlm_lm.benchmarks.harness import Run
    from geotlm_lm.cli.progress import progress_on_stderr

    if real is not None and not real.is_dir():
        raise UsageError(f"--real: {real} is no folder, expected one of labelled recordings.")
    options = {"real": real, "is_quick": quick, "seed": seed, "model": model}
    return Run(**options, progress=progress_on_stderr(""), **more)


def _measure(
    name: str, run: Run, only: list[str] | None, out: Path | None, *, as_json: bool
) -> None:
    """Run a bench; print its tables, and write them where that is asked for."""
    from geotlm_lm.benchmarks.benches import BENCHES, run_bench
    from geotlm_lm.benchmarks.rendering import page, save_results

    bench = BENCHES[name]
    before = None if out is None else _earlier(bench, run, out)
    record = run_bench(bench, run, only=only or (), command=command_line(), before=before)
    if out is not None:
        save_results(bench, record, out)
    typer.echo(page(bench, record), nl=False)
    if as_json:
        typer.echo(json.dumps(asdict(record)))


def _earlier(bench: Bench, run: Run, out: Path) -> RunRecord | None:
    """Return the record that lies in `out`; refuse to replace a whole run's by a quick one's."""
    from geotlm_lm.benchmarks.harness import WHOLE
    from geotlm_lm.benchmarks.rendering import RECORDS
    from geotlm_lm.core.record import RunRecord

    path = out / RECORDS / f"{bench.name}.json"
    require_writable(out, "--out")
    require_record_file(path, "--out")
    before = RunRecord.load(path) if path.exists() and path.stat().st_size else None
    if before is not None and run.is_quick and before.config.get("size") == WHOLE:
        raise UsageError(
            f"--out: {path} is the record of a whole run and would be replaced by a quick "
            f"one; give another folder."
        )
    return before
