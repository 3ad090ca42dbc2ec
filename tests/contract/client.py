"""The client that openapi-python-client generates, used as it is: a text and an image become scenes and are downloaded.

    python client.py URL IMAGE

`tabletopgen_client` must be importable. Prints what was done as JSON; anything unexpected ends it with an exception.
"""

import hashlib
import io
import json
import sys
import time
import uuid
import zipfile
from pathlib import Path

from tabletopgen_client import Client
from tabletopgen_client.api.jobs import cancel_job, get_job, list_events, list_jobs, list_stages
from tabletopgen_client.api.scenes import (
    delete_scene,
    get_artifact,
    get_bundle,
    get_scene,
    list_artifacts,
    list_scenes,
    submit_scene,
    validate_scene,
)
from tabletopgen_client.api.service import healthz, readyz, version
from tabletopgen_client.models import (
    BundleFormat,
    FormRequest,
    ImageBytes,
    ImageSubmission,
    JobKind,
    JobState,
    Labels,
    Options,
    Problem,
    ProblemType,
    Scene,
    SceneForm,
    SceneState,
    TextSubmission,
    Validated,
)
from tabletopgen_client.types import File

ENDED = (JobState.SUCCEEDED, JobState.FAILED, JobState.CANCELLED)
WAIT_SECONDS = 300


def main(url: str, image_path: str):
    client = Client(base_url=url, timeout=60, raise_on_unexpected_status=True)
    assert healthz.sync(client=client).status.value == "ok" and readyz.sync(client=client).status.value == "ready"
    image = Path(image_path).read_bytes()
    labels = Labels.from_dict({"client": "generated"})
    text = TextSubmission(text="a mug and a book", seed=7, labels=labels, options=Options(max_objects=4))
    form = SceneForm(
        image=File(payload=io.BytesIO(image), file_name="table.png", mime_type="image/png"),
        request=FormRequest(seed=7, labels=labels),
    )
    done = {
        "version": version.sync(client=client).version,
        "text": make(client, text),
        "image as a file": make(client, form),
        "image in JSON": validate(client, ImageSubmission(image=ImageBytes(base64=base64_of(image)), seed=7)),
        "lists": lists(client),
        "cancel and delete": cancel_and_delete(client),
        "refusals": refusals(client),
    }
    print(json.dumps(done))


def base64_of(data: bytes) -> str:
    import base64

    return base64.b64encode(data).decode()


def make(client: Client, body) -> dict:
    """Submits, polls, downloads the bundle, one of its formats, and an artifact."""
    scene = submit_scene.sync(client=client, body=body)
    assert isinstance(scene, Scene), scene
    deadline = time.monotonic() + WAIT_SECONDS
    polls = 0
    while (job := get_job.sync(scene.job.id, client=client)).state not in ENDED:
        assert time.monotonic() < deadline, job
        polls += 1
        time.sleep(0.2)
    assert job.state == JobState.SUCCEEDED, job
    scene = get_scene.sync(scene.id, client=client)
    assert scene.state == SceneState.READY and scene.stages and scene.artifacts, scene
    whole = get_bundle.sync(scene.id, client=client)
    part = get_bundle.sync(scene.id, client=client, format_=BundleFormat.MJCF)
    names = [zipfile.ZipFile(archive.payload).namelist() for archive in (whole, part)]
    assert len(names[0]) > len(names[1]) > 0 and all("/mjcf/" in name or "/" in name for name in names[1])
    artifact = next(a for a in list_artifacts.sync(scene.id, client=client).artifacts if a.name.endswith(".png"))
    content = get_artifact.sync(scene.id, artifact.name, client=client).payload.getvalue()
    assert hashlib.sha256(content).hexdigest() == artifact.sha256 and len(content) == artifact.size
    # Events say the same as the job does.
    events = list_events.sync(job.id, client=client, page_size=200).events
    assert events[0].kind.value == "job_queued" and str(events[0].data.scene_id) == str(scene.id)
    assert list_stages.sync(job.id, client=client).stages
    return {"polls": polls, "files": len(names[0]), "artifact": artifact.name, "artifact_bytes": artifact.size}


def validate(client: Client, body) -> str:
    answer = validate_scene.sync(client=client, body=body)
    assert isinstance(answer, Validated) and answer.request.input_.kind.value == "image", answer
    return "validated"


def lists(client: Client) -> dict:
    """Every scene and every job once, page by page."""
    counts = {}
    for name, operation in (("scenes", list_scenes), ("jobs", list_jobs)):
        seen, token = [], None
        while True:
            more = {"page_token": token} if token else {}
            page = operation.sync(client=client, page_size=1, **more)
            seen += [item.id for item in getattr(page, name)]
            token = page.next_page_token
            if not token:
                break
        assert len(seen) == len(set(seen)) and len(seen) >= 2, seen
        counts[name] = len(seen)
    succeeded = list_jobs.sync(client=client, state=JobState.SUCCEEDED, kind=JobKind.GENERATE).jobs
    assert len(succeeded) >= 2 and all(job.state == JobState.SUCCEEDED for job in succeeded)
    labeled = list_scenes.sync(client=client, label="client:generated", state=SceneState.READY).scenes
    assert len(labeled) == 2
    return counts


def cancel_and_delete(client: Client) -> str:
    key = str(uuid.uuid4())
    first, again = (submit_scene.sync(client=client, body=TextSubmission(text="a vase", seed=1), idempotency_key=key)
                    for _ in range(2))
    assert first.id == again.id
    cancelled = cancel_job.sync(first.job.id, client=client)
    assert cancelled.state in (JobState.CANCELLING, JobState.CANCELLED) or isinstance(cancelled, Problem), cancelled
    assert delete_scene.sync_detailed(first.id, client=client).status_code == 204
    gone = get_scene.sync(first.id, client=client)
    assert isinstance(gone, Problem) and gone.type_ == ProblemType.URNTABLETOPGENPROBLEMGONE, gone
    return "done"


def refusals(client: Client) -> str:
    refused = submit_scene.sync(client=client, body=TextSubmission(text=" ", seed=1))
    assert isinstance(refused, Problem) and refused.status == 422 and refused.errors[0].pointer == "/text", refused
    unknown = get_job.sync(uuid.uuid4(), client=client)
    assert isinstance(unknown, Problem) and unknown.status == 404, unknown
    return "understood"


if __name__ == "__main__":
    main(*sys.argv[1:])
