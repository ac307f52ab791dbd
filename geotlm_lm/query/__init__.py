"""A question as a value: its types, what follows from it and a belief, and how that is told.

Reads no picture and runs no model: text, a `Query`, a `Belief` or a `Track` in, words out.
"""
