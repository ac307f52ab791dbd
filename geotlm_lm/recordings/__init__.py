"""Files to clips: reading arrays, videos and folders, the idle gel, and the frames that tell.

Knows nothing of models, questions or labels.
"""
