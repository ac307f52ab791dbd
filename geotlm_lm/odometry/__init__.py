"""Tactile odometry: how far the imprint turned or slid, measured rather than said.

Reads patch inputs and geometry, knows no question; `Odometer` is the seam.
"""
