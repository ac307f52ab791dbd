"""`geotlm-lm bench`: error, run time, stability and what leaving out saves, each one table."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from geotlm_lm.cli.options import (
    AsJson,
    BundleFolder,
    ClusterAddress,
    DataSets,
    Encoder,
    Seed,
    command_line,
    grouped,
    option,
    require_record_file,
    require_writable,
)
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


@dataclass(frozen=True)
class Measuring:
    """Options of every bench."""

    real: Path | None = option("Folder of labelled recordings to add; see `evaluate`.")
    out: Path | None = option(
        "Folder for the record, the page and the pictures. [default: only printed]"
    )
    quick: bool = option(
        "See in under two minutes that everything runs; proves nothing.", "--quick", default=False
    )
    only: list[str] | None = option(
        "Only this section; may be given again. The others are kept as recorded in --out."
    )
    seed: Seed = 0
    model: BundleFolder = None
    as_json: AsJson = False

    def run(self, name: str, **more: object) -> None:
        """Run a bench; print its tables, and write them where that is asked for."""
        from geotlm_lm.benchmarks.benches import BENCHES, run_bench
        from geotlm_lm.benchmarks.harness import Run
        from geotlm_lm.benchmarks.rendering import page, save_results
        from geotlm_lm.cli.progress import progress_on_stderr

        if self.real is not None and not self.real.is_dir():
            raise UsageError(
                f"--real: {self.real} is no folder, expected one of labelled recordings."
            )
        options = {"real": self.real, "is_quick": self.quick, "seed": self.seed}
        run = Run(**options, model=self.model, progress=progress_on_stderr(""), **more)
        bench = BENCHES[name]
        before = None if self.out is None else _earlier(bench, run, self.out)
        record = run_bench(bench, run, only=self.only or (), command=command_line(), before=before)
        if self.out is not None:
            save_results(bench, record, self.out)
        typer.echo(page(bench, record), nl=False)
        if self.as_json:
            typer.echo(json.dumps(asdict(record)))


@app.command(epilog="Example: geotlm-lm bench accuracy --quick")
@grouped
def accuracy(
    *,
    measuring: Measuring,
    data: DataSets = None,
    encoder: Encoder,
    workers: int | None = option(
        "Processes that share the sections. [default: 1, or as many as a cluster's]", min=1
    ),
    cluster: ClusterAddress = None,
) -> None:
    """Hold the words against linear probes and two classical rivals; run the paper's protocols.

    With --weights, a released encoder takes the embedded one's place in the protocols. Workers
    change no number but times.
    """
    encoder.require_alone(measuring.model)
    from geotlm_lm.benchmarks.harness import EncoderFile

    weights = encoder.weights
    given = None if weights is None else EncoderFile(weights, encoder.encoder, encoder.heads)
    by = Workers(1 if workers is None and cluster is None else workers, cluster)
    measuring.run("accuracy", data=tuple(data or ()), encoder=given, workers=by)


def _command(name: str, about: str) -> Callable[..., None]:
    """Return the command of a bench that takes no options of its own."""

    def command(*, measuring: Measuring) -> None:
        measuring.run(name)

    command.__doc__ = about
    return grouped(command)


for bench_name, bench_about in {
    "pareto": "Hold error against run time and memory; times need an idle machine.",
    "stability": "Try damaged and extreme clips, stiff scenes, and contact that vanishes.",
    "loop": "Stop a simulated gripper, and watch recordings, by conditions in words.",
    "omissions": "Tell what each stage that is left out saves, and what it costs.",
}.items():
    example = f"Example: geotlm-lm bench {bench_name} --quick"
    app.command(name=bench_name, epilog=example)(_command(bench_name, bench_about))


@app.command(epilog="Example: geotlm-lm bench render --check")
@grouped
def render(
    check: bool = option(
        "Change nothing; fail if a number is out of date.", "--check", default=False
    ),
    figures: bool = option("Draw the pictures anew too.", "--figures", default=False),
    results: Path = option("Folder of pages, records beside them.", default=Path("docs/results")),
    readme: Path = option("The file to fill.", default=Path("README.md")),
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
