"""Fused token and question in, words out; knows nothing of touch, clips or labels' origin.

Answering needs only torch, tokenizers and jinja2 (`speak`, `decoder`, `prompt`); the transformers
classes (`model`, `processor`, `configuration`) read and write the same folder and are imported only
by those who want them, because that import alone takes longer than a cold answer may.
"""
