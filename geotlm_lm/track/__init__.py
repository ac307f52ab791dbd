"""A recording or a stream -> its motion over time: what touched when, how it moved, what happened.

Frames in, one `Track` out; knows no question and no words. Files and cameras take the same way.
"""
