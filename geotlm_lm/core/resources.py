"""Where prompts, templates and the embedded bundle lie: in the wheel or in a checkout."""

from __future__ import annotations

from pathlib import Path

from geotlm_lm.core.errors import MissingDependency

_PACKAGE = Path(__file__).resolve().parent.parent


def resource_dir(name: str) -> Path:
    """Return the folder `name` (prompts, data_templates, app, bundle).

    A wheel carries the folders inside the package; a checkout keeps the user's layout beside it.

    Raises:
        FileNotFoundError: If the installation is incomplete.
    """
    for parent in (_PACKAGE, _PACKAGE.parent):
        if (parent / name).is_dir():
            return parent / name
    raise FileNotFoundError(f"geotlm_lm was installed without its folder '{name}'")


def training_templates() -> Path:
    """Return the folder of wordings that language models are trained and judged on.

    Raises:
        MissingDependency: If it is an installed package, which holds only what answering reads.
    """
    folder = resource_dir("data_templates")
    if not (folder / "slots.toml").is_file():
        raise MissingDependency(
            "The wordings that training reads are part of the repository, not of the installed "
            "package; run this from a checkout."
        )
    return folder
