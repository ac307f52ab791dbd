"""A page in the browser: give a clip, ask, read the answer beside what it rests on.

Uses only the package's public names and errors. Run it with `geotlm-lm app`, or with
`python -m app` from a checkout.
"""
