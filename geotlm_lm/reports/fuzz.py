"""What fuzzing ran and found, as a page."""

from __future__ import annotations

from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.tables import markdown, provenance

COLUMNS = ("target", "inputs", "read", "refused", "kept", "pairs of lines", "slowest, ms", "MiB")


def fuzz_page(record: RunRecord) -> str:
    """Return the report under its title."""
    return f"# Damaged files and nonsense questions\n\n{fuzz_report(record)}\n"


def fuzz_report(record: RunRecord) -> str:
    """Return the counts of every target, and what was found, as Markdown."""
    rows = [
        [
            name,
            f"{one.get('runs', 0):,}",
            f"{one.get('read', 0):,}",
            f"{one.get('refused', 0):,}",
            f"{one.get('kept', 0)}",
            f"{one.get('pairs', 0):,}",
            f"{one.get('slowest_ms', 0.0):.0f}",
            f"{one.get('memory_mib', 0.0):.0f}",
        ]
        for name, one in record.numbers["targets"].items()
    ]
    return "\n\n".join(
        [
            "*Read* inputs gave a result, *refused* ones one sentence. *Kept* are those that "
            "reached a new line after another and were damaged further, *pairs of lines* what was "
            "reached; native decoders are not seen into. *Slowest* is of one input, in processor "
            "time under the tracing that sees lines; *MiB* the most that one added to the process.",
            markdown(COLUMNS, rows),
            verdict(record),
            *(f"- {one['target']}: {one['kind']}: `{one['said']}`" for one in _findings(record)),
            provenance(record),
        ]
    )


def verdict(record: RunRecord) -> str:
    """Return in one sentence how many inputs ran and how many did what none must."""
    runs = sum(one.get("runs", 0) for one in record.numbers["targets"].values())
    found = len(_findings(record))
    return (
        f"{runs:,} inputs: {found or 'none'} crashed, hung, took over 1 GiB or 5 s, ended in "
        f"anything but a result or a refusal, or was refused in more than one sentence."
    )


def _findings(record: RunRecord) -> list[dict[str, str]]:
    return record.numbers["findings"]
