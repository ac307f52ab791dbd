"""What a clip's motion is believed to be: every component at once, with its spread.

Reads patch inputs, tokens and geometry, knows no question; `Belief` is the seam.
"""
