"""The four benches, and what the README and other pages show of them."""

from __future__ import annotations

from collections.abc import Mapping

from geotlm_lm.benchmarks import accuracy, omissions, pareto, stability
from geotlm_lm.benchmarks.rendering import Headline

BENCHES = {
    bench.name: bench
    for bench in (accuracy.ACCURACY, pareto.PARETO, stability.STABILITY, omissions.OMISSIONS)
}

HEADLINES: Mapping[str, Headline] = {
    "accuracy.clips": accuracy.clips_headline,
    **pareto.HEADLINES,
    **stability.HEADLINES,
    **omissions.HEADLINES,
}
"""Block of the README, bench and section -> what it shows of the section's rows."""
