"""How the page looks: its own colours and the system's own letters; nothing is fetched for it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .error_display import gradio

# The toolkit's bundled fonts are incomplete (its semibold holds two letters), others are fetched.
FONT = ("system-ui", "-apple-system", "Segoe UI", "Roboto", "Ubuntu", "Cantarell", "sans-serif")
MONO = ("ui-monospace", "SFMono-Regular", "Menlo", "Consolas", "monospace")

STYLES = [str(Path(__file__).parent / name) for name in ("page.css", "stage.css")]
"""Files of the page's own rules."""

BUTTONS = ["download", "fullscreen"]
"""Beside a picture; the toolkit's third shares it with a site on the network."""


def theme() -> Any:
    """Return the page's theme, light and dark."""
    gr = gradio()
    base = gr.themes.Base(
        primary_hue=gr.themes.colors.teal,
        secondary_hue=gr.themes.colors.teal,
        neutral_hue=gr.themes.colors.slate,
        spacing_size=gr.themes.sizes.spacing_sm,
        radius_size=gr.themes.sizes.radius_md,
        text_size=gr.themes.sizes.text_md,
        font=FONT,
        font_mono=MONO,
    )
    return base.set(
        body_background_fill="*neutral_50",
        body_background_fill_dark="*neutral_950",
        body_text_color_subdued="*neutral_600",
        body_text_color_subdued_dark="*neutral_400",
        block_label_text_color="*neutral_700",
        block_label_text_color_dark="*neutral_300",
        input_placeholder_color="*neutral_500",
        input_placeholder_color_dark="*neutral_400",
        # The toolkit's own links are too pale on white, and followed ones in the dark as well.
        link_text_color="*secondary_700",
        link_text_color_active="*secondary_700",
        link_text_color_visited="*secondary_700",
        link_text_color_visited_dark="*secondary_500",
        # White letters on it have a contrast of 5.5.
        button_primary_background_fill="*primary_700",
        button_primary_background_fill_hover="*primary_800",
        button_primary_background_fill_dark="*primary_700",
        button_primary_background_fill_hover_dark="*primary_600",
        button_primary_text_color="white",
        button_primary_text_color_dark="white",
    )
