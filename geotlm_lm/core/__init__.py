"""Words every room shares: clips, labels and signs, frames of reference, errors, seeds, records.

Numpy only: no torch, no OpenCV, no model.
"""
