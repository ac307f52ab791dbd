"""Read-outs the language model is judged against: a linear probe and a classical flow reference.

Knows nothing of words; arrays and clips in, motions out.
"""
