"""The four tables by name: accuracy, error against run time, stability, what is left out."""

from __future__ import annotations

from dataclasses import replace

from geotlm_lm.benchmarks.amounts import AMOUNTS, MIXTURES
from geotlm_lm.benchmarks.clips import CLIPS_SECTION, clip_rows
from geotlm_lm.benchmarks.harness import Bench
from geotlm_lm.benchmarks.omissions import SAVED
from geotlm_lm.benchmarks.pareto import COMMANDS, METHODS, SIMULATOR, STAGES
from geotlm_lm.benchmarks.protocols import PROTOCOLS
from geotlm_lm.benchmarks.questions import QUESTIONS, READING
from geotlm_lm.benchmarks.stability import DAMAGE, EXTREME, NUMERICS, SCENES
from geotlm_lm.benchmarks.tracks import TRACKS

ACCURACY = Bench(
    name="accuracy",
    title="Accuracy",
    about="What is right, how often, and beside what: simulated, real and published numbers apart.",
    sections=(CLIPS_SECTION, TRACKS, MIXTURES, AMOUNTS, READING, QUESTIONS, PROTOCOLS),
)

EVALUATION = Bench(
    name="evaluate",
    title="Answers against truth",
    about="The model's words beside linear probes and optical flow, on clips none has seen.",
    sections=(replace(CLIPS_SECTION, run=clip_rows, shares=None),),
)
"""The accuracy of a user's own recordings, data sets and model: nothing is split."""

PARETO = Bench(
    name="pareto",
    title="Error against run time and memory",
    about="What a smaller error costs in time and memory. Times compare within a table alone.",
    sections=(METHODS, STAGES, COMMANDS, SIMULATOR),
)

STABILITY = Bench(
    name="stability",
    title="Stability",
    about="What becomes of damaged, extreme and stiff inputs, and how firm the numbers are.",
    sections=(DAMAGE, EXTREME, SCENES, NUMERICS),
)

OMISSIONS = Bench(
    name="omissions",
    title="What is left out",
    about="What a question, a command or a scene does not need does not run.",
    sections=(SAVED,),
)

BENCHES = {bench.name: bench for bench in (ACCURACY, PARETO, STABILITY, OMISSIONS)}
