"""Contact mechanics to frames: a scene becomes a clip with its truth; nothing here knows a model."""
