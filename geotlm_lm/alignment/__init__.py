"""Lay one picture on the next: the rigid motion between them, with its covariance and residual.

Pictures in, a motion out; knows no clip, no backbone and no label.
"""
