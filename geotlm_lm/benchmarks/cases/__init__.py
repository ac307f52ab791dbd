"""Clips with known motions that variants are judged on; knows nothing of the variants."""
