"""A scene as a card in a notebook."""

from __future__ import annotations

import base64
from html import escape

from tabletopgen import models

WIDTH_PX = 640


def card(scene: models.Scene, url: str, image: tuple[bytes, str] | None) -> str:
    """A table of what is known, with an image, which has its media type beside it, where there is one."""
    rows = {"state": scene.verdict or scene.state, "seed": str(scene.seed)}
    if scene.summary and scene.summary.objects is not None:
        rows["objects"] = str(scene.summary.objects)
    if scene.metrics:
        rows |= {name: f"{value:.3f}" for name, value in scene.metrics if isinstance(value, float)}
    if scene.failure:
        rows[scene.failure.code] = scene.failure.message
    rows |= {f"label {name}": value for name, value in scene.labels.items()}
    cells = "".join(f"<tr><th>{escape(name)}</th><td>{escape(value)}</td></tr>" for name, value in rows.items())
    shown = ""
    if image:
        content, media_type = image
        data = f"data:{escape(media_type, quote=True)};base64,{base64.b64encode(content).decode()}"
        shown = f'<img alt="" width="{WIDTH_PX}" src="{data}">'
    link = escape(f"{url}/scenes/{scene.id}", quote=True)
    return f'<div><a href="{link}">scene {scene.id}</a><div>{shown}</div><table>{cells}</table></div>'
