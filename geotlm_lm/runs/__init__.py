"""Long runs: parts done by processes or a cluster, each result kept, a stopped run continued.

Knows nothing of what the parts are.
"""
