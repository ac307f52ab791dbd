"""A page in the browser: give a clip, ask, read the answer beside what it rests on.

Uses only the package's errors and public names, which load on first use (`lm.Answerer`). Run it
with `geotlm-lm app`, or with `python -m app` from a checkout.
"""
