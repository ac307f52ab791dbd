"""The language model's decoder: ids and embeddings in, hidden states out; knows no text.

Answering needs only NumPy (`sequence`). `decoder` builds, trains and reads the same weights by
transformers, and is imported only where they are trained, because that import alone takes longer
than a cold answer may.
"""
