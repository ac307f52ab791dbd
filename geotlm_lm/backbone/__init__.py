"""Clips -> tokens, frozen. The only room that knows how a clip becomes a token sequence."""
