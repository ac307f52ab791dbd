"""A stand-in for the process pool: worker processes would not see what a test has patched."""


class InProcess:
    """Runs the jobs one after the other where it stands."""

    def __init__(self, *_, **__):
        pass

    def __enter__(self):
        return self

    def __exit__(self, *_):
        return False

    map = staticmethod(lambda function, jobs: map(function, jobs))
