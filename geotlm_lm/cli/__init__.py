"""The command line: parse, call a seam, print. Nothing heavy is imported before a command runs."""
