"""Contact mechanics to frames: a scene becomes a clip with its truth; knows no model."""
