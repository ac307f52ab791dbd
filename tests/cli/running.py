"""A command run as a user types it, in this process."""

import pytest

from geotlm_lm.cli.main import main


def run(capsys, *arguments):
    """Return a command's exit code and what it printed, to stdout and to stderr."""
    with pytest.raises(SystemExit) as stopped:
        main([str(argument) for argument in arguments])
    printed = capsys.readouterr()
    return stopped.value.code, printed.out, printed.err
