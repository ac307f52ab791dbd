"""The four benches by name."""

from __future__ import annotations

from geotlm_lm.benchmarks import accuracy, omissions, pareto, stability

BENCHES = {
    bench.name: bench
    for bench in (accuracy.ACCURACY, pareto.PARETO, stability.STABILITY, omissions.OMISSIONS)
}
