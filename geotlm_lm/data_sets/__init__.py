"""Data sets of robots in LeRobot's layout: episodes read as recordings, labels written beside them.

Knows nothing of questions; a model is what tracks an episode.
"""
