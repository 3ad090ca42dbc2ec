"""What no schema can express, for requests that are meant to be valid: the fuzzer's values are replaced there.

An image is a real PNG; an address of an image is that of one (CONTRACT_IMAGE_URL); a text that is only validated names
one object that stands on tables, a known width is that of the table, and words for tables are known ones; settings have
the values of the document's examples, as ranges of numbers in texts are not expressed; what an edit changes is
something that any scene permits; robots are known ones; few tasks are rehearsed; a dataset has one source, a label, and
its splits share all of it; episodes are few, of one task in words, and seen by usual cameras or by one that is placed
well, points, depths and masks with a camera alone; a sample is of one combination; times are soon; a number such as 7.0
is 7; an idempotency key is used once. Every other request about a scene is about one that is finished
(CONTRACT_SCENE_ID), as the fuzzer does not wait for its own. The key of all requests (CONTRACT_KEY_ID) is not revoked.
Everything else is as the fuzzer draws it from openapi.yaml, and requests that are meant to be refused are left alone.
"""

import base64
import datetime
import itertools
import os
import re
import struct
import uuid
import zlib

import schemathesis
from schemathesis.transport.serialization import Binary

SENTENCES = ("a mug", "A bowl", "there is a red book on the table")
HOURS_FROM_NOW = {"not_before": 1, "deadline": 2}
TABLE_WORDS = {"model": "desk", "material": "oak", "color": "red"}
# The fuzzed server has no chat model, which these settings want.
WITHOUT_CHAT = {"appraise.ratings": "false", "appraise.tasks": "0"}
SUBMISSIONS = ("POST /scenes", "POST /scenes/{scene_id}/edits", "POST /scenes/{scene_id}/variants")
VALIDATION = "/validate"
EDIT = {"operations": [{"op": "tidy"}], "text": "tidy the table"}
EXECUTE = "POST /scenes/{scene_id}/executions"
EPISODES = "POST /scenes/{scene_id}/episodes"
TASKS = "GET /scenes/{scene_id}/tasks"
# Something that an arm can do in the finished scene. It takes seconds, so one request in so many does it.
INSTRUCTION, EXECUTED_ONE_IN = "pick up the mug", 10
# How many targets a predicate has depends on its word.
GOAL = {"predicate": "lifted", "object": "mug_1"}
RECORDED_ONE_IN = 10
MAX_RECORDED_ATTEMPTS = 2
REHEARSED_ONE_IN = 10
MAX_REHEARSED = 2
MAX_SEEDS = 10
LARGEST_FIRST_SEED = 2**52
REVOKE = "DELETE /keys/{key_id}"
SLOT = r"\{([^{}\s]+)\}"
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
    if case.operation.label == REVOKE and case.path_parameters.get("key_id") == os.environ.get("CONTRACT_KEY_ID"):
        case.path_parameters["key_id"] = str(uuid.uuid4())
    # Else a body with a file would count as one that is meant to be refused once it is replaced, as files are no JSON.
    case._sync_validated_hashes()


def about_the_finished_scene(case):
    """Every other request about a scene is about the finished one, but for those that would end it."""
    finished = os.environ.get("CONTRACT_SCENE_ID")
    label, number = case.operation.label, next(count)
    if not finished or "{scene_id}" not in label or label.startswith("DELETE"):
        return
    if label == EXECUTE:
        if isinstance(case.body, dict) and number % EXECUTED_ONE_IN == 0:
            case.path_parameters["scene_id"] = finished
            case.body.pop("task", None)
            case.body["text"] = INSTRUCTION
    elif label == EPISODES:
        if number % RECORDED_ONE_IN == 0:
            case.path_parameters["scene_id"] = finished
    elif number % 2 == 0:
        case.path_parameters["scene_id"] = finished


def about_tasks(case):
    query = case.query or {}
    if "robot" in query:
        query["robot"] = "panda"
    # An instruction in words is read, and is seldom one when it is random.
    query.pop("text", None)
    if query.get("rehearsed", True) in (True, "true"):
        query["rehearsed"] = "true" if next(count) % REHEARSED_ONE_IN == 0 else "false"
        query["count"] = min(int(query.get("count", MAX_REHEARSED)), MAX_REHEARSED)


def of_few_episodes(body: dict):
    """A task in words, few attempts, and cameras that differ, see something and have few pixels."""
    body.pop("tasks", None)
    body["task"] = INSTRUCTION
    body["robot"] = "panda"
    body["count"] = 1
    if body.get("max_attempts") is not None:
        body["max_attempts"] = MAX_RECORDED_ATTEMPTS
    record = body.get("record") or {}
    cameras = record.get("cameras") or []
    own = [one for one in cameras if isinstance(one, dict)][:1]
    for one in own:
        one.update(eye_m=[0, -0.5, 1], target_m=[0, 0, 0], width_px=64, height_px=64)
    if cameras:
        record["cameras"] = own or sorted(set(cameras))
    elif "cameras" in record:
        for name in ("point_cloud", "depth", "instance_ids"):
            record.pop(name, None)
    if any(record.get(name) for name in ("point_cloud", "depth", "instance_ids")):
        # Other formats keep none of them.
        body["formats"] = ["parquet-png"]
    if "size_px" in record:
        record["size_px"] = min(record["size_px"], 64)


def of_a_label(body: dict):
    """One source of three, and the only one that may name what is not there."""
    body.pop("batch", None)
    body.pop("scenes", None)
    if body.get("label") is None:
        body["label"] = "project:demo"
    if body.get("splits") is not None:
        body["splits"] = {"train": 0.8, "test": 0.2}


def proper(template: str) -> str:
    """The text without braces that are not about the name of a slot."""
    parts = re.split(f"({SLOT.replace('(', '').replace(')', '')})", template)
    parts[::2] = [part.replace("{", "").replace("}", "") for part in parts[::2]]
    return "".join(parts) if says_something("".join(parts)) else "a mug"


def says_something(text: str) -> bool:
    """Whether the text has a letter or a digit; marks alone are an empty text."""
    return any(char.isalnum() for char in text)


def of_few_combinations(body: dict):
    """A sample is of the combinations that there are, a recipe of a million or fewer, and each slot is one of a
    template."""
    if (body.get("select") or {}).get("count") is not None:
        body["select"]["count"] = 1
    # Braces are those of slots, and the slots those of the templates.
    templates = [proper(template) for template in body.get("templates") or ()]
    body["templates"] = [one for place, one in enumerate(templates) if one not in templates[:place]]
    slots, used = body.get("slots") or {}, re.findall(SLOT, " ".join(templates))
    if slots or used:
        body["slots"] = {name: slots.get(name) or ["red"] for name in used}
    if isinstance(body.get("seeds"), dict):
        body["seeds"]["count"] = min(body["seeds"].get("count", 1), MAX_SEEDS)
        # The last seed is in the range of seeds, too.
        body["seeds"]["first"] = min(body["seeds"].get("first", 0), LARGEST_FIRST_SEED)


def replace(case):
    if case.meta is None or not case.meta.generation.mode.is_positive:
        return
    about_the_finished_scene(case)
    if "Idempotency-Key" in (case.headers or {}):
        case.headers["Idempotency-Key"] = f"{case.headers['Idempotency-Key'][:200]}-{next(count)}"
    if case.operation.label == TASKS:
        about_tasks(case)
    if isinstance(case.body, dict):
        whole_numbers(case.body)
        if case.operation.label == EXECUTE:
            case.body["robot"] = "panda"
            if case.body.get("task") is not None:
                case.body["task"].update(goal=[GOAL], robot="panda")
            # The scene may be a finished one, whatever its id came from.
            if case.body.get("text") is not None:
                case.body["text"] = INSTRUCTION
            # A video is in the archive alone, and takes seconds.
            case.body["video"] = False
        if case.operation.label == EPISODES:
            of_few_episodes(case.body)
        if case.operation.label == "POST /datasets":
            of_a_label(case.body)
        if case.operation.label == "POST /batches":
            of_few_combinations(case.body)
            options = case.body.get("options") or []
            for one in options if isinstance(options, list) else [options]:
                possible_options(one, settings_of(case))
            if isinstance(options, list):
                # Options with null and without are the same.
                del options[1:]
    if case.operation.label.removesuffix(VALIDATION) in SUBMISSIONS:
        replace_in_submission(case)


def whole_numbers(value):
    """Writes whole numbers as such, wherever they stand."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for place, one in list(items):
        if isinstance(one, float) and one.is_integer():
            value[place] = int(one)
        whole_numbers(one)


def settings_of(case) -> dict:
    return case.operation.schema.raw_schema["components"]["schemas"]["SceneSettings"]["properties"]


def possible_options(options: dict, document: dict):
    """A robot that there is, and settings of the document's examples."""
    if options.get("robot") is not None:
        options["robot"] = "panda"
    settings = options.get("set") or {}
    for name in settings:
        settings[name] = WITHOUT_CHAT.get(name) or document[name].get("examples", [settings[name]])[0]


def replace_in_submission(case):
    if not isinstance(case.body, dict):
        return
    form = case.media_type == "multipart/form-data"
    # What is requested stands in a field of a form.
    request = case.body.get("request") if form else case.body
    request = request if isinstance(request, dict) else {}
    image = case.body.get("image")
    if form and image is not None:
        case.body["image"] = Binary(IMAGES[next(count) % len(IMAGES)])
    elif isinstance(image, dict) and image.get("base64") is not None:
        image["base64"] = base64.b64encode(IMAGES[next(count) % len(IMAGES)]).decode()
    elif isinstance(image, dict) and image.get("url") is not None:
        image["url"] = os.environ["CONTRACT_IMAGE_URL"]
    operation = case.operation.label.removesuffix(VALIDATION)
    if operation.endswith("/variants") and isinstance(request.get("count"), (int, float)):
        request["count"] = min(int(request["count"]), 3)
    if operation.endswith("/edits"):
        for name, value in EDIT.items():
            if request.get(name) is not None:
                request[name] = value
    now = datetime.datetime.now(datetime.UTC)
    for name, hours in HOURS_FROM_NOW.items():
        if request.get(name) is not None:
            request[name] = (now + datetime.timedelta(hours=hours)).isoformat()
    if isinstance(request.get("text"), str) and not says_something(request["text"]):
        request["text"] = SENTENCES[0]
    options = request.get("options") or {}
    possible_options(options, settings_of(case))
    if case.operation.label == "POST /scenes" + VALIDATION:
        if request.get("text") is not None:
            request["text"] = SENTENCES[next(count) % len(SENTENCES)]
        if options.get("metric_anchor"):
            options["metric_anchor"]["object"] = "table"
        for name, word in TABLE_WORDS.items():
            if (options.get("table") or {}).get(name) is not None:
                options["table"][name] = word
