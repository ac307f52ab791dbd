"""Folds and scores: arrays in, numbers out.

Numpy only; knows nothing of models, clips or words.
"""
