"""Run the command line as `python -m geotlm_lm`."""

from geotlm_lm.cli.main import main

main()
