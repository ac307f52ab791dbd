"""What is wrong with a recording, or with an installation, before anybody asks it anything.

Every finding is measured: what cannot be told from frames and times is said to be unknown.
"""
