"""Fused token and question in, words out; knows nothing of touch, clips or labels' origin.

Answering needs only torch, tokenizers and jinja2 (`generation`, `decoder`, `prompt`). The
transformers classes (`model`, `processor`, `configuration`) read and write the same folder and are
imported only by those who want them, because that import alone takes longer than a cold answer may.
"""
