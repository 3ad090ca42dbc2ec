"""What no schema can express, for requests that are meant to be valid: the fuzzer's values are replaced there.

An image is a real PNG; an address of an image is that of one (CONTRACT_IMAGE_URL); a text that is only validated names one
thing that stands on tables, a known width is that of the table, and words for tables are known ones; settings have the values of the document's examples, as ranges of numbers in texts are not
expressed; what an edit changes is something that any scene permits; robots are known ones; times are soon; a seed such as 7.0 is 7; an idempotency key is used once. Everything else is as the fuzzer draws it from
openapi.yaml, and requests that are meant to be refused are left alone.
"""

import base64
import datetime
import itertools
import os
import struct
import zlib

import schemathesis
from schemathesis.transport.serialization import Binary

SENTENCES = ("a mug", "A bowl", "there is a red book on the table")
HOURS_FROM_NOW = {"not_before": 1, "deadline": 2}
TABLE_WORDS = {"model": "desk", "material": "oak", "color": "red"}
# The fuzzed server has no chat model, which these settings want.
WITHOUT_CHAT = {"appraise.ratings": "false", "appraise.tasks": "0"}
SUBMISSIONS = ("POST /scenes", "POST /scenes/{scene_id}/edits", "POST /scenes/{scene_id}/variants")
EDIT = {"operations": [{"op": "tidy"}], "text": "tidy the table"}
count = itertools.count()


def png(width: int, height: int, shade: int) -> bytes:
    """A plain gray image, as PNG."""
    rows = (b"\0" + bytes([shade]) * width) * height
    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    chunks = [(b"IHDR", header), (b"IDAT", zlib.compress(rows)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data)) for name, data in chunks
    )


IMAGES = [png(160, 160, 80), png(200, 160, 160)]


@schemathesis.hook
def before_call(context, case, kwargs):
    replace(case)
    # Else a body with a file would count as one that is meant to be refused once it is replaced, as files are no JSON.
    case._sync_validated_hashes()


def with_a_known_robot(case):
    """No schema lists the robots: they are files."""
    if case.operation.label == "GET /scenes/{scene_id}/tasks" and "robot" in (case.query or {}):
        case.query["robot"] = "panda"
    if case.operation.label == "POST /scenes/{scene_id}/executions" and isinstance(case.body, dict):
        case.body["robot"] = "panda"


def replace(case):
    if case.meta is not None and case.meta.generation.mode.is_positive:
        with_a_known_robot(case)
    if case.operation.label not in SUBMISSIONS or case.meta is None or not case.meta.generation.mode.is_positive:
        return
    if "Idempotency-Key" in (case.headers or {}):
        case.headers["Idempotency-Key"] = f"{case.headers['Idempotency-Key'][:200]}-{next(count)}"
    if not isinstance(case.body, dict):
        return
    form = case.media_type == "multipart/form-data"
    # What is requested stands in a field of a form.
    request = case.body.get("request") if form else case.body
    request = request if isinstance(request, dict) else {}
    image = case.body.get("image")
    if form and image is not None:
        case.body["image"] = Binary(IMAGES[next(count) % len(IMAGES)])
    elif isinstance(image, dict) and "base64" in image:
        image["base64"] = base64.b64encode(IMAGES[next(count) % len(IMAGES)]).decode()
    elif isinstance(image, dict) and "url" in image:
        image["url"] = os.environ["CONTRACT_IMAGE_URL"]
    if case.operation.label.endswith("/variants") and isinstance(request.get("count"), (int, float)):
        request["count"] = min(int(request["count"]), 3)
    if case.operation.label.endswith("/edits"):
        for name, value in EDIT.items():
            if request.get(name) is not None:
                request[name] = value
    now = datetime.datetime.now(datetime.timezone.utc)
    for name, hours in HOURS_FROM_NOW.items():
        if request.get(name) is not None:
            request[name] = (now + datetime.timedelta(hours=hours)).isoformat()
    if isinstance(request.get("seed"), float):
        request["seed"] = int(request["seed"])
    options = request.get("options") or {}
    settings = options.get("set") or {}
    document = case.operation.schema.raw_schema["components"]["schemas"]["SceneSettings"]["properties"]
    for name in settings:
        settings[name] = WITHOUT_CHAT.get(name) or document[name].get("examples", [settings[name]])[0]
    if case.operation.label == "POST /scenes" and (case.query or {}).get("validate_only") in (True, "true"):
        if request.get("text") is not None:
            request["text"] = SENTENCES[next(count) % len(SENTENCES)]
        if options.get("metric_anchor"):
            options["metric_anchor"]["object"] = "table"
        for name, word in TABLE_WORDS.items():
            if (options.get("table") or {}).get(name) is not None:
                options["table"][name] = word
