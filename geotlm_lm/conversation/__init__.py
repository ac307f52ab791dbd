"""Rules on words, motions and frames that a conversation needs beside a model.

Knows no model and no clip. The division of labour: the language model says what is asked and which
motion it felt, always in the camera image; whatever follows exactly from a motion, a frame of
reference, a time or a probability is derived here, so that no weight ever guesses a mirror.
"""
