"""Damaged files and nonsense questions against every reader and the question path.

Coverage-guided, one process a target; knows what must not happen, not what the right answer is.
"""
