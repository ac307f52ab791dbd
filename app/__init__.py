"""A page in the browser: give a clip, ask, read the answer beside what it rests on.

Uses only the package's public names and errors. Run it with `python -m app` from a checkout, or
with `python -m geotlm_lm.app` from an installation.
"""
