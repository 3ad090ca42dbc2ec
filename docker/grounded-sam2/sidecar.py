"""The protocol of docs/segmentation-sidecar.yaml over any segmentation model: form in, annotations out.

The model is a function `find(image, labels, box_threshold, text_threshold)` that yields `Detection`; this file knows
no model.
"""

import asyncio
import hmac
import io
import json
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from fastapi import FastAPI, HTTPException, Request
from PIL import Image
from starlette.datastructures import UploadFile

from coco import compressed

MAX_FORM_BYTES = 64 << 20
MAX_SIDE_PX = 4096
MAX_LABELS = 128
MAX_FOUND = 512
LABEL = re.compile(r"[a-z0-9]+( [a-z0-9]+)*")


@dataclass
class Detection:
    """An object in the image."""

    class_name: str
    score: float
    # x0, y0, x1, y1, pixels.
    box: tuple
    # As large as the image, booleans.
    mask: np.ndarray


Find = Callable[[Image.Image, list, float, float], Iterable[Detection]]


def app(find: Find, key: str | None = None) -> FastAPI:
    """The server; with a key, requests without it are refused. Images are segmented one after the other."""
    server = FastAPI(title="Segmentation sidecar", docs_url=None, redoc_url=None, openapi_url=None)
    one_at_a_time = asyncio.Lock()

    @server.get("/healthz")
    async def healthz():
        return {"status": "ok"}

    @server.post("/v1/segment")
    async def segment(request: Request):
        if key and not hmac.compare_digest(request.headers.get("authorization", "").encode(), f"Bearer {key}".encode()):
            raise HTTPException(401, "the key is missing or another")
        if int(request.headers.get("content-length", 0) or 0) > MAX_FORM_BYTES:
            raise HTTPException(413, f"at most {MAX_FORM_BYTES} bytes are taken")
        async with request.form(max_files=1, max_fields=1, max_part_size=1 << 20) as form:
            image = await image_of(form.get("image"))
            asked = question_of(form.get("request"))
        async with one_at_a_time:
            found = await asyncio.to_thread(lambda: list(find(image, *asked)))
        return answer(image, found)

    return server


async def image_of(file) -> Image.Image:
    if not isinstance(file, UploadFile):
        raise HTTPException(422, "image: a file is wanted")
    try:
        # Its size is known before anything is decoded.
        image = Image.open(io.BytesIO(await file.read()), formats=["PNG"])
        if max(image.size) > MAX_SIDE_PX:
            raise HTTPException(422, f"image: {image.size[0]} x {image.size[1]} pixels, at most {MAX_SIDE_PX} a side")
        return image.convert("RGB")
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise HTTPException(422, f"image: no PNG file that can be read ({type(error).__name__})") from error


def question_of(text) -> tuple:
    """Labels and thresholds."""
    try:
        asked = json.loads(text)
        labels = asked["labels"]
        thresholds = [asked["box_threshold"], asked["text_threshold"]]
    except (TypeError, ValueError, KeyError) as error:
        raise HTTPException(422, "request: labels, box_threshold and text_threshold are wanted, as JSON") from error
    if not isinstance(labels, list) or not 1 <= len(labels) <= MAX_LABELS:
        raise HTTPException(422, f"labels: a list of 1 to {MAX_LABELS} is wanted")
    for label in labels:
        if not isinstance(label, str) or len(label) > 200 or not LABEL.fullmatch(label):
            raise HTTPException(422, f"labels: {str(label)[:40]!r} is no lower-case words of letters and digits")
    for threshold in thresholds:
        if isinstance(threshold, bool) or not isinstance(threshold, (int, float)) or not 0 <= threshold <= 1:
            raise HTTPException(422, "thresholds are numbers from 0 to 1")
    return labels, float(thresholds[0]), float(thresholds[1])


def answer(image: Image.Image, found: list) -> dict:
    """The annotations with the highest scores, of objects with visible pixels."""
    width, height = image.size
    shown = sorted((annotation for annotation in found if annotation.mask.any()), key=lambda annotation: -annotation.score)[:MAX_FOUND]
    return {
        "img_width": width,
        "img_height": height,
        "annotations": [
            {
                "class_name": annotation.class_name,
                "score": round(float(annotation.score), 6),
                "bbox": [round(float(side), 3) for side in annotation.box],
                "segmentation": compressed(annotation.mask),
            }
            for annotation in shown
        ],
    }
