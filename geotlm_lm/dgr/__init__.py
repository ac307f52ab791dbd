"""Patch tokens -> geometric feature: learned shear, contact mask, seven-region pooling (Eqs. 1-8).

Knows nothing of clips, classes or language.
"""
