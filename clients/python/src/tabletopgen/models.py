"""The schemas of `openapi.yaml` as classes. Written by generate.py."""

from __future__ import annotations

from typing import Any, Literal
from uuid import UUID

from pydantic import AnyUrl, AwareDatetime, Field, RootModel

from tabletopgen._model import Model


class Appearance(Model):
    """
    Image similarity by a feature extractor. Scores of different extractors are not comparable.
    """

    extractor: str
    """
    Name of the feature extractor's adapter.
    """
    model: str
    """
    Version of the extractor, with the digest of its weights if it has any.
    """
    similarity: float
    """
    Dot product of the two images' feature vectors, -1..1.
    """


class Artifact(Model):
    """
    A file that a stage put aside.
    """

    name: str
    stage: str
    media_type: str
    size: int
    """
    Bytes.
    """
    sha256: str
    url: str


class ArtifactList(Model):
    """
    The artifacts of a scene by name.
    """

    artifacts: list[Artifact]


class AuditEntry(Model):
    """
    A change, or an attempt at one.
    """

    id: UUID
    at: AwareDatetime
    """
    RFC 3339 in UTC with milliseconds.
    """
    tenant: str
    principal: str
    """
    `key:` or `session:` with the id of a key, `user:` with the name that a proxy gave, `anonymous`, or `command line`.
    """
    address: str
    """
    Address of the client; empty for the command line.
    """
    action: str
    """
    Id of the operation in this document.
    """
    subject: str
    """
    Path of the request.
    """
    status: int
    """
    Status of the answer; 499 where the client went before it.
    """


class AuditPage(Model):
    """
    A page of the record.
    """

    entries: list[AuditEntry]
    next_page_token: str | None
    """
    Null on the last page.
    """


class BasePlace(Model):
    """
    In the frame of the scene; z is above the top of the table. The base faces x, turned by `yaw_rad` about the
    vertical. A place where the arm touches something is refused with `base_not_free`, one without a table near it with
    `table_out_of_reach`.
    """

    x_m: float
    y_m: float
    z_m: float
    """
    Above the top of the table.
    """
    yaw_rad: float


class BatchEstimate(Model):
    """
    By the pace of the requests that ended last.
    """

    scenes_per_hour: float
    time_left_s: float
    finish_at: AwareDatetime
    """
    RFC 3339 in UTC with milliseconds.
    """


class BatchLinks(Model):
    """
    Paths of what belongs to a batch.
    """

    self: str
    output: str
    errors: str
    jobs: str


class BatchName(RootModel[str]):
    root: str
    """
    Name of a batch, for people.
    """


class BatchResultError(Model):
    """
    Reason why a request has no scene.
    """

    code: str
    """
    Stable, `[a-z0-9_]+`.
    """
    message: str
    """
    A sentence with advice.
    """
    line: int | None = None
    """
    Line of the body, or number of the request of a recipe, from 1.
    """
    column: int | None = None
    """
    Column of the line in bytes, from 1.
    """
    pointer: str | None = None
    """
    JSON pointer into the request.
    """


class BatchRetry(Model):
    """
    The optional body of a retry.
    """

    budget_usd: float | None = None
    """
    The new budget of the batch, with what is spent already.
    """


class BatchSpending(Model):
    """
    Calls of remote models for all requests, US dollars.
    """

    budget_usd: float | None
    spent_usd: float
    reserved_usd: float


class BundleFile(Model):
    """
    A file of a bundle.
    """

    name: str
    """
    Path below the folder of the bundle.
    """
    size_bytes: int
    sha256: str
    media_type: str
    link: str


class BundleFileList(Model):
    """
    The files of a bundle by name.
    """

    files: list[BundleFile]


class BundleFormat(RootModel[Literal["usd", "urdf", "mjcf", "sdf", "glb", "all"]]):
    root: Literal["usd", "urdf", "mjcf", "sdf", "glb", "all"]
    """
    Format of a scene, or all.
    """


class Bytes(RootModel[bytes]):
    root: bytes
    """
    A file, byte for byte.
    """


class Clutter(Model):
    """
    Clutter: objects without a stated place are dropped onto each other until they rest.
    """

    density: float
    """
    Share of the area under the heap that objects are to cover. 0 spreads them over the table at random, 1 drops them as
    close to each other as they can lie.
    """


class ClutterOperation(Model):
    """
    More objects of the scene's theme, or of the one that is given.
    """

    op: Literal["clutter"]
    count: int
    theme: str | None = None


class DatasetFailure(Model):
    """
    Reason why a freeze failed.
    """

    code: str
    message: str


class DatasetFault(Model):
    """
    A fault of a file of a dataset.
    """

    path: str
    """
    The file, with the member or the file of the bundle behind it.
    """
    reason: str


class DatasetFile(Model):
    """
    A file of a version.
    """

    path: str
    media_type: str
    size: int
    sha256: str
    url: str


class DatasetFiles(Model):
    """
    The files of a version.
    """

    files: list[DatasetFile]


class DatasetLinks(Model):
    """
    Paths of what belongs to a dataset.
    """

    self: str
    files: str
    archive: str
    manifest: str
    licenses: str
    statistics: str
    statistics_page: str


class DatasetProgress(Model):
    """
    Steps of the work in progress; each phase counts anew.
    """

    done: int
    all: int


class DeliveryAttempt(Model):
    """
    The last attempt that has ended.
    """

    ended_at: AwareDatetime
    """
    RFC 3339 in UTC with milliseconds.
    """
    status: int | None
    """
    Status of the answer; null without one.
    """
    error: str | None
    """
    Reason why it failed; null for one that was accepted.
    """
    duration_ms: int


class DepthAccount(Model):
    """
    Use of the depth image beside the image.
    """

    is_used: bool
    """
    Whether camera, scale and heights are from the depth; else they are from the image alone.
    """
    note: str
    """
    The same in words, with the reason where the depth was not used.
    """


class Difficulty(Model):
    """
    Difficulty of a task and its causes. `overall` is the mean of five terms, each from 0 to 1: `(objects - 1) / 3` and
    `(steps - 1) / 3` up to 1, `clutter / 6` up to 1, `occlusion`, and `0.03 m / (0.03 m + precision_m)`.
    """

    objects: int
    """
    Objects that the goal names.
    """
    clutter: int
    """
    Other objects within 6 cm of one of these.
    """
    occlusion: float
    """
    Share of these that is hidden to a viewer at the front edge, 0 to 1.
    """
    precision_m: float
    """
    Tolerance of placements, meters: the smallest of the steps.
    """
    steps: int
    """
    Objects picked up and put down; a swap takes three.
    """
    overall: float
    """
    0 (easy) to 1.
    """


class Disturbance(Model):
    """
    An object that moved farther than the limits of the task permit.
    """

    object: str
    displacement_m: float
    """
    Of its origin, meters.
    """
    rotation_rad: float
    """
    Of its orientation, about any axis, radians.
    """


class EpisodeCamera(Model):
    """
    A camera: its place and direction in the frame of what it is fixed to, and its size.
    """

    name: str
    mount: Literal["world", "tool"]
    """
    Frame that a camera is fixed to. The table's top is at z = 0 in the world; +z of the tool points out of the hand.
    """
    eye_m: list[float]
    """
    Meters.
    """
    target_m: list[float]
    """
    The point in the center of its image; up in the image is the mount's +z, or its +y if it is directed along z.
    """
    fov_x_rad: float
    """
    Horizontal field of view, radians.
    """
    width_px: int
    height_px: int


class EventName(Model):
    """
    An event by its number and kind.
    """

    seq: int
    kind: Literal[
        "job_queued",
        "job_started",
        "stage_started",
        "stage_progress",
        "stage_finished",
        "job_retrying",
        "job_orphaned",
        "job_released",
        "job_cancelling",
        "job_cancelled",
        "job_failed",
        "job_succeeded",
    ]
    """
    Kind of an event of a job.
    """


class ExecutionFormat(RootModel[Literal["json", "zip"]]):
    root: Literal["json", "zip"] = "json"
    """
    The form of the answer: verdict, task and motion as one document, or the files that `tabletopgen execute --out`
    writes.
    """


class FieldError(Model):
    """
    Place in a request, and the fault there.
    """

    pointer: str
    """
    A JSON pointer into the body.
    """
    detail: str


class Gripper(Model):
    """
    A parallel gripper.
    """

    max_opening_m: float
    """
    Greatest distance of the pads, meters.
    """
    grip_force_n: float
    """
    Force of a grip, newtons.
    """
    max_force_n: float
    """
    Force that it can hold continuously, newtons.
    """


class ImageBytes(Model):
    """
    An image in the body.
    """

    base64: str = Field(..., json_schema_extra={"contentEncoding": "base64"})
    """
    A complete PNG, JPEG or WebP file of one still image, at most 20 MB and 64 megapixels, at least 160 pixels a side;
    alone or as a data URI (`data:image/png;base64,...`), whose media type must be that of the bytes.
    """
    url: None = Field(None)


class ImageUrl(Model):
    """
    An image elsewhere.
    """

    base64: None = Field(None)
    url: AnyUrl
    """
    URL of such a file: https, at a public address. The file is fetched before the request is answered.
    """


class IndexLinks(Model):
    """
    Paths that a client begins with.
    """

    contract: str
    page: str
    """
    The page for people.
    """
    scenes: str
    jobs: str
    batches: str
    datasets: str
    episodes: str
    events: str
    session: str
    version: str


class JobLinks(Model):
    """
    Paths of what belongs to a job.
    """

    self: str
    events: str
    stages: str
    scene: str | None
    dataset: str | None
    recording: str | None
    execution: str | None
    """
    The answer of an execution.
    """


class LimitShares(Model):
    """
    The largest shares of the limits of one joint of the arm, or of the gripper's opening.
    """

    name: str
    """
    The name of the number with its unit.
    """
    position: float
    """
    Distance from the center of the range, over half of the range; 1 is at the end.
    """
    velocity: float
    acceleration: float
    jerk: float


class LimitUse(Model):
    """
    A limit, and what is used of it.
    """

    name: str
    """
    The setting of the server, such as `store.limits.waiting_jobs`.
    """
    max: float
    """
    Value of the limit for this tenant: bytes, jobs, submissions, requests or US dollars, as the setting has it.
    """
    used: float
    """
    Amount that is used of it, without what was asked for.
    """


class ListOrder(RootModel[Literal["newest", "oldest"]]):
    root: Literal["newest", "oldest"]
    """
    Order of a list of scenes; a page token belongs to the order that it came with.
    """


class Login(Model):
    """
    The key of one who logs in.
    """

    key: str


class MetricAnchor(Model):
    """
    A known width in the scene.
    """

    object: str
    """
    A label of an object, or `table`.
    """
    width_m: float
    """
    Width of the object (x extent as placed in the image), meters.
    """


class Metrics(Model):
    """
    Measurements of a finished scene; `docs/formats.md` defines them.
    """

    col_o: float | None = None
    """
    A share.
    """
    col_s: float | None = None
    """
    A share.
    """
    ss: float | None = None
    """
    A share.
    """
    dss_aligned: float | None = None
    """
    A share.
    """
    dss_shipped: float | None = None
    """
    A share.
    """


class MovedObject(Model):
    """
    A movement that no operation asked for.
    """

    name: str
    distance_m: float
    """
    Of its origin.
    """
    angle_rad: float
    cause: str
    """
    Reason why the object had to move.
    """


class OperationResult(Model):
    """
    The result of one operation.
    """

    op: str
    """
    Word of the operation, such as `add`.
    """
    objects: list[str]
    """
    The objects it acted on, by their names in the new scene; removed ones by their names in the parent.
    """
    sentence: str
    """
    Change made by the operation, in one sentence.
    """
    words: str | None = None
    """
    The words of the instruction that ask for it, where the edit was given in words.
    """


class Pose(Model):
    """
    A position and an orientation; meters, and a unit quaternion with the real part last.
    """

    translation_m: list[float]
    """
    Origin of the child frame in the parent frame, meters.
    """
    rotation_xyzw: list[float]
    """
    Unit quaternion, stored x, y, z, w.
    """


class PreviewWidth(RootModel[Literal[160, 320, 640]]):
    root: Literal[160, 320, 640] = 320
    """
    Width of an image, pixels; the height follows.
    """


class QueueKind(Model):
    """
    Jobs of a kind.
    """

    kind: Literal["generate", "retry", "freeze_dataset", "verify_dataset", "record_attempt", "assemble_recording", "execute_task"]
    """
    The operation: `generate` and `retry` build a scene, `freeze_dataset` makes a version of a dataset and
    `verify_dataset` reads one, `record_attempt` makes one attempt of a recording and `assemble_recording` writes its
    dataset, `execute_task` has a simulated robot do a task.
    """
    waiting: int
    """
    Also those for a later time.
    """
    running: int


class QueuePause(Model):
    """
    A pause of claiming.
    """

    reason: str
    since: AwareDatetime
    """
    RFC 3339 in UTC with milliseconds.
    """


class RandomizationAmplitudes(Model):
    """
    Numbers are drawn evenly from -x to x, factors from 1 - x to 1 + x; what is absent does not vary.
    """

    position_m: float | None = 0.0
    """
    Positions of objects on the table, along each axis, meters, with all that they carry.
    """
    yaw_rad: float | None = 0.0
    """
    Yaws of objects, radians.
    """
    absent_distractors: float | None = 0.0
    """
    The probability that an object is absent which the task does not name.
    """
    added_distractors: int | None = 0
    """
    Maximum number of other objects of the catalog; the number is drawn evenly from none on.
    """
    object_color: float | None = 0.0
    """
    Factor of the colors of objects, each channel.
    """
    table_color: float | None = 0.0
    """
    Factor of the color of the table, each channel.
    """
    object_material: float | None = 0.0
    """
    The probability that an object has another material of the same color.
    """
    table_material: float | None = 0.0
    """
    The probability that the top of the table has another material of the catalog.
    """
    light_direction_rad: float | None = 0.0
    """
    Azimuth of the light, radians; half of it for the elevation.
    """
    light_brightness: float | None = 0.0
    """
    Factor of the light's brightness.
    """
    backdrop_color: float | None = 0.0
    """
    Factor of the color of the backdrop, each channel.
    """
    start_rad: float | None = 0.0
    """
    The joints of the arm at the start, radians.
    """
    camera_position_m: float | None = 0.0
    """
    Cameras along each of their axes, meters.
    """
    camera_angle_rad: float | None = 0.0
    """
    Cameras about each of their axes, radians.
    """
    focal_length: float | None = 0.0
    """
    Factor of the focal length.
    """
    mass: float | None = 0.0
    """
    Factor of each object's mass.
    """
    friction: float | None = 0.0
    """
    Factor of each object's friction.
    """


class Randomize(Model):
    """
    The axes along which variants differ.
    """

    layout: bool | None = False
    """
    Places on the table, within the stated relations.
    """
    meshes: bool | None = False
    """
    Other meshes of the same category.
    """
    sizes: float | None = 0.0
    """
    Sizes by a factor from 1 - x to 1 + x, 0..=0.3.
    """
    colors: bool | None = False
    """
    Colors of objects.
    """
    materials: bool | None = False
    """
    Materials of vessels and dishes, which change mass and friction.
    """
    table: bool | None = False
    """
    Color or material of the table.
    """
    light: bool | None = False
    """
    Direction and brightness of the light.
    """
    camera: bool | None = False
    """
    Azimuth, elevation, distance and focal length of the reference camera.
    """
    mass: float | None = 0.0
    """
    Masses by a factor from 1 - x to 1 + x, 0..=0.5.
    """
    friction: float | None = 0.0
    """
    Friction by a factor from 1 - x to 1 + x, 0..=0.5.
    """


class RearrangeOperation(Model):
    """
    New places for what stands on the table. Relations that a text states still hold, and what rests on or in an object
    moves with it.
    """

    op: Literal["rearrange"]


class RecipeProduct(Model):
    """
    All combinations, as when absent.
    """

    mode: Literal["product"]


class RecipeSample(Model):
    """
    So many different combinations, drawn with a seed.
    """

    mode: Literal["sample"]
    count: int
    seed: int


class RecordedFormat(Model):
    """
    The dataset in one format.
    """

    format: Literal["lerobot-v3.0", "lerobot-v3.0-images", "lerobot-v2.1", "lerobot-v2.1-images", "robomimic", "parquet-png"]
    """
    Format of a dataset of episodes.
    """
    files: int
    archive: str
    """
    All files as one tar archive.
    """
    size: int
    """
    Of the archive, bytes.
    """
    sha256: str | None
    """
    Of the archive.
    """


class RecordingFailure(Model):
    """
    Reason why a recording failed.
    """

    code: str
    message: str


class RecordingFilePage(Model):
    """
    A page of the files of a recording.
    """

    files: list[DatasetFile]
    next_page_token: str | None
    """
    Null on the last page.
    """


class RecordingLinks(Model):
    """
    Paths of what belongs to a recording.
    """

    self: str
    scene: str
    events: str
    files: str
    cancel: str


class RecordingProgress(Model):
    """
    Progress of a recording.
    """

    attempts: int
    """
    Attempts that have an outcome.
    """
    max_attempts: int
    successes: int
    """
    Also those beyond what is wanted, which are no part of the dataset.
    """
    wanted: int
    success_rate: float | None
    """
    Of the attempts so far.
    """
    seconds_left: float | None
    """
    By the pace of the last attempts, without assembling; null before the first success and after the end.
    """


class Region(Model):
    """
    A connected region.
    """

    body: str
    """
    The object with most of its pixels; the table for what was not recognized.
    """
    bbox_px: list[int]
    """
    x0, y0 inclusive; x1, y1 exclusive.
    """
    image_share: float
    """
    Share of all pixels of the image, 0..1.
    """


class Regions(Model):
    """
    Pixels with objects in only one of the two images.
    """

    share: float
    """
    Share of all object pixels of that image, 0..1.
    """
    largest: list[Region]
    """
    The largest connected regions.
    """


class RelabelOperation(Model):
    """
    Another label; the mesh stays.
    """

    op: Literal["relabel"]
    target: str
    """
    An object of the scene: its name (`mug_1`) or a phrase ("the red mug", "the second book from the left", "all
    spoons"). A phrase that fits several objects where one is meant fails the job, which names them.
    """
    label: str
    """
    Words for a new object, or a label.
    """


class RelightOperation(Model):
    """
    A key light at another place. Azimuth 0 is at the front edge, pi/2 at the right.
    """

    op: Literal["relight"]
    azimuth_rad: float
    elevation_rad: float
    intensity: float
    """
    Of the usual brightness.
    """


class RemakeOperation(Model):
    """
    Another mesh of the same kind, with the same name, in the same place.
    """

    op: Literal["remake"]
    target: str
    """
    An object of the scene: its name (`mug_1`) or a phrase ("the red mug", "the second book from the left", "all
    spoons"). A phrase that fits several objects where one is meant fails the job, which names them.
    """


class RemoveOperation(Model):
    """
    Removes objects.
    """

    op: Literal["remove"]
    target: str
    """
    An object of the scene: its name (`mug_1`) or a phrase ("the red mug", "the second book from the left", "all
    spoons"). A phrase that fits several objects where one is meant fails the job, which names them.
    """
    with_contents: bool | None = False
    """
    Remove also what stands on or in them; otherwise it comes to rest below.
    """


class ReplaceOperation(Model):
    """
    Another object at the same place, on or in the same supporter.
    """

    op: Literal["replace"]
    target: str
    """
    An object of the scene: its name (`mug_1`) or a phrase ("the red mug", "the second book from the left", "all
    spoons"). A phrase that fits several objects where one is meant fails the job, which names them.
    """
    object: str
    """
    Words for a new object, or a label.
    """


class RequestCounts(Model):
    """
    Number of requests in each state; `total` is their sum.
    """

    total: int
    pending: int
    running: int
    succeeded: int
    failed: int
    quarantined: int
    cancelled: int
    duplicate: int
    invalid: int


class RequestLimits(Model):
    """
    Sizes of what this server accepts.
    """

    max_body_bytes: int
    max_image_bytes: int
    max_image_pixels: int
    max_text_chars: int


class ResizeOperation(Model):
    """
    Another size.
    """

    op: Literal["resize"]
    target: str
    """
    An object of the scene: its name (`mug_1`) or a phrase ("the red mug", "the second book from the left", "all
    spoons"). A phrase that fits several objects where one is meant fails the job, which names them.
    """
    factor: float
    """
    On all three extents.
    """


class RestyleTableOperation(Model):
    """
    Another appearance of the table, by material, color, or both; at least one of them. Its shape and size stay.
    """

    op: Literal["restyle_table"]
    material: str | None = None
    color: str | None = None


class Retry(Model):
    """
    Options of a repeated job.
    """

    from_stage: str | None = None
    """
    Repeat this stage of the job and everything after it all the same.
    """


class Robot(Model):
    """
    A robot.
    """

    name: str
    title: str
    """
    In words.
    """
    dof: int
    """
    Number of joints of the arm.
    """
    gripper: Gripper


class RobotList(Model):
    """
    The robots that tasks are done with.
    """

    robots: list[Robot]


class RotateOperation(Model):
    """
    A turn about the vertical axis, counter-clockwise from above: exactly one of `by_rad`, `to_rad` and `facing`.
    """

    op: Literal["rotate"]
    target: str
    """
    An object of the scene: its name (`mug_1`) or a phrase ("the red mug", "the second book from the left", "all
    spoons"). A phrase that fits several objects where one is meant fails the job, which names them.
    """
    by_rad: float | None = None
    to_rad: float | None = None
    """
    0 faces the front edge.
    """
    facing: str | None = None


class SceneFacets(Model):
    """
    Numbers of scenes by their properties; of more than 100,000, the newest ones are counted.
    """

    total: int
    state: dict[str, int]
    verdict: dict[str, int]
    """
    Scenes that are not certified are in none.
    """
    kind: dict[str, int]
    category: dict[str, int]
    """
    The 50 categories that the most scenes have.
    """
    label: dict[str, int]
    """
    The 50 labels that the most scenes have, as `key=value`.
    """


class SceneLinks(Model):
    """
    Paths of what belongs to a scene.
    """

    self: str
    bundle: str
    files: str
    preview: str
    artifacts: str
    events: str | None


class ScenePatch(Model):
    """
    The body of a change.
    """

    labels: dict[str, str | None] | None = None
    """
    Labels to set, and with null labels to remove; null in place of all removes all.
    """


class ScenesOfBatch(RootModel[Literal["keep", "delete"]]):
    root: Literal["keep", "delete"]
    """
    Fate of the scenes of a batch that is deleted.
    """


class SeedRange(Model):
    """
    Consecutive seeds.
    """

    first: int
    count: int


class Session(Model):
    """
    The principal of a request, and what this server accepts.
    """

    kind: Literal["anonymous", "key", "session", "user"]
    """
    Credential of a principal: none, a key, a session, or the name that a proxy gives.
    """
    principal: str
    """
    Name in the log and in the record of changes.
    """
    tenant: str
    scopes: list[Literal["read", "submit", "delete", "operate", "admin"]]
    expires_at: AwareDatetime | None
    """
    Null where it does not expire.
    """
    authentication: Literal["none", "keys"]
    """
    Whether clients need a credential: with `none`, everyone is the tenant `default` with all scopes.
    """
    limits: RequestLimits


class SetPhysicsOperation1(Model):
    """
    Another mass or friction, by factors; one of them or both.
    """

    op: Literal["set_physics"]
    target: str
    """
    An object of the scene: its name (`mug_1`) or a phrase ("the red mug", "the second book from the left", "all
    spoons"). A phrase that fits several objects where one is meant fails the job, which names them.
    """
    mass_factor: float | None
    """
    A factor.
    """
    friction_factor: float | None = None
    """
    A factor.
    """


class SetPhysicsOperation2(Model):
    """
    Another mass or friction, by factors; one of them or both.
    """

    op: Literal["set_physics"]
    target: str
    """
    An object of the scene: its name (`mug_1`) or a phrase ("the red mug", "the second book from the left", "all
    spoons"). A phrase that fits several objects where one is meant fails the job, which names them.
    """
    mass_factor: float | None = None
    """
    A factor.
    """
    friction_factor: float | None
    """
    A factor.
    """


class SharesOfLimits(Model):
    """
    Shares of the robot's limits that the motion uses, by differences of its numbers at the rate of the trajectory. A
    share above 1 is beyond a limit.
    """

    motion: list[LimitShares]
    """
    Of the planned motion.
    """
    servo_command: list[LimitShares]
    """
    Shares of the servo targets.
    """


class SizeView(Model):
    """
    Extents of an object as it stands: width, depth, height; meters.
    """

    low_m: list[float]
    high_m: list[float]


class StackOperation(Model):
    """
    One object on the other, the first at the bottom. One phrase for several stacks the largest first.
    """

    op: Literal["stack"]
    targets: list[str]


class StageInProgress(Model):
    """
    A stage that a job had begun and not finished.
    """

    stage: str
    instance: str
    """
    Empty when the stage works on the whole scene.
    """
    runs: int
    """
    Number of times that the job began it.
    """


class Status(Model):
    """
    State of the process.
    """

    status: Literal["ok", "ready"]
    """
    Result of a probe.
    """


class SwapOperation(Model):
    """
    Two objects change places: two phrases, or one that means two.
    """

    op: Literal["swap"]
    targets: list[str]


class TableSpec(Model):
    """
    Properties of the table; the catalog chooses those that are absent.
    """

    shape: Literal["rectangular", "square", "round", "oval", "triangular", "irregular"] | None = None
    size_m: list[Any] | None = None
    """
    Width (x), depth (y) of the top and height above the floor (z), meters.
    """
    model: str | None = None
    """
    Name of a table model of the catalog.
    """
    material: str | None = None
    """
    Name of a material, such as `oak`.
    """
    color: str | None = None
    """
    A color name of the text.
    """


class TaskLimits(Model):
    """
    Limits that a successful execution keeps, beside the goal.
    """

    max_duration_s: float
    """
    Longest execution, seconds.
    """
    max_displacement_of_others_m: float
    """
    Farthest that objects outside the goal may move, meters.
    """
    max_rotation_of_others_rad: float
    """
    Farthest that objects outside the goal may turn, radians.
    """
    min_gripper_distance_m: float
    """
    Least distance of the opened gripper from every object at the end, meters; not for goals that end in the hand.
    """
    min_rest_s: float
    """
    Time that the objects must be at rest at the end, seconds.
    """


class TextSpan(Model):
    """
    A part of the text; byte offsets and its words.
    """

    start: int
    """
    Byte offset of the first byte in the text.
    """
    end: int
    """
    Byte offset after the last byte in the text.
    """
    text: str
    """
    The words as the text has them.
    """


class TidyOperation(Model):
    """
    Objects that stand on the table are aligned with its edges and moved apart.
    """

    op: Literal["tidy"]


class TriedTask(Model):
    """
    A proposed task, and what became of it.
    """

    instruction: str
    """
    In words.
    """
    outcome: str
    """
    `done`, the code of its failure (`no_path`), or the code of its refusal.
    """


class Understood(Model):
    """
    A part of the text and its meaning.
    """

    span: TextSpan
    kind: Literal["object", "property", "relation", "arrangement", "exclusion", "goal", "table", "theme", "completion", "correction"]
    """
    Meaning of a part of the text.
    """
    category: str | None = None
    """
    Category of the objects.
    """
    objects: list[str] | None = None
    """
    Names of objects.
    """
    property: str | None = None
    """
    The property, such as `color`.
    """
    value: str | None = None
    """
    The value of the property in words.
    """
    relation: str | None = None
    """
    The relation, such as `left_of`.
    """
    targets: list[str] | None = None
    """
    Names of objects.
    """
    index: int | None = None
    """
    Index of the arrangement, or of the predicate of the goal.
    """
    categories: list[str] | None = None
    """
    Categories that are absent.
    """
    theme: str | None = None
    """
    The theme that supplies fillings.
    """
    complete: bool | None = None
    """
    Whether the theme completes the scene.
    """
    corrected: str | None = None
    """
    The word that a misspelled one is read as.
    """


class Unmet(Model):
    """
    A demand of the text that the layout does not meet, and its objects.
    """

    objects: list[str]
    """
    Names of objects.
    """
    kind: Literal["relation", "arrangement", "yaw", "position"]
    """
    Kind of a demand.
    """
    relation: str | None = None
    """
    The relation, such as `left_of`; without targets, to the table.
    """
    targets: list[str] | None = None
    """
    Names of objects.
    """
    distance_m: float | None = None
    """
    The stated distance.
    """
    index: int | None = None
    """
    Index of the arrangement.
    """
    arrangement: Literal["row", "column", "circle", "grid", "pile", "pyramid"] | None = None
    """
    Form of an arrangement.
    """
    columns: int | None = None
    """
    Columns of a grid.
    """
    yaw_rad: float | None = None
    """
    The stated rotation about the vertical axis, counter-clockwise from above.
    """
    x_m: float | None = None
    """
    The stated position from the center of the table top, to the right.
    """
    y_m: float | None = None
    """
    The stated position from the center of the table top, to the back.
    """


class Variant(Model):
    """
    One variant.
    """

    id: UUID
    seed: int
    link: str


class Variants(Model):
    """
    The variants of a scene, in order.
    """

    parent: UUID
    seed: int
    """
    Seed that the seeds of the variants are drawn from.
    """
    randomize: Randomize
    scenes: list[Variant]
    remaining: int
    """
    Variants for which a limit leaves no room; the same request with the same Idempotency-Key goes on.
    """


class VerificationResult(Model):
    """
    Findings of the last verification.
    """

    intact: bool
    scenes: int
    bytes: int
    fault_count: int
    faults: list[DatasetFault]
    """
    The first hundred.
    """


class Version(Model):
    """
    Version of the program.
    """

    name: str
    version: str
    studio: bool
    """
    Whether the program has the page for people at `/studio/`.
    """


class WebhookMessageData(Model):
    """
    The subject of an event, after it.
    """

    id: UUID
    """
    Id of the scene, the job, the batch, the recording, the dataset or the webhook.
    """
    state: str
    """
    Word of the event behind its dot; of a batch, a recording or a dataset its state.
    """
    failure_code: str | None
    """
    Code of the failure; null without one.
    """
    job_id: UUID | None
    """
    The job that ended, where it is one that made a scene or a dataset.
    """
    path: str
    """
    Path of the subject on the server.
    """


class Wordings(Model):
    """
    The same task as three people would say it.
    """

    vague: str
    """
    With wide nouns, which may fit several objects.
    """
    default: str
    """
    In a plain sentence that names each object once and clearly.
    """
    specific: str
    """
    With colors and places, and with each motion.
    """


class Batch(Model):
    """
    Many requests for scenes.
    """

    id: UUID
    name: str | None
    state: Literal["running", "cancelling", "finished", "cancelled"]
    """
    State of a batch; `finished` and `cancelled` are final unless it is retried.
    """
    request_counts: RequestCounts
    progress: float
    """
    Share of the requests that came to their end, without duplicates and invalid ones.
    """
    estimate: BatchEstimate | None
    """
    Absent before the first request has ended, and after the last.
    """
    spending: BatchSpending
    created_at: AwareDatetime
    """
    RFC 3339 in UTC with milliseconds.
    """
    finished_at: AwareDatetime | None
    """
    RFC 3339 in UTC with milliseconds.
    """
    links: BatchLinks


class BatchPage(Model):
    """
    A page of batches.
    """

    batches: list[Batch]
    next_page_token: str | None
    """
    Null on the last page.
    """


class BatchResult(Model):
    """
    A line of the output or of the errors of a batch.
    """

    custom_id: str | None
    """
    Null for a line whose name cannot be read.
    """
    scene_id: UUID | None
    state: Literal["pending", "running", "succeeded", "failed", "quarantined", "cancelled", "duplicate", "invalid"]
    """
    State of a request of a batch.
    """
    verdict: str | None
    """
    `pass` or `quarantine`, once certified.
    """
    bundle: str | None
    error: BatchResultError | None
    stages_s: float
    """
    Duration of all computed stages together.
    """
    attempts: int
    duplicate_of: str | None = None
    """
    The request that asks for the same scene.
    """


class Call(Model):
    """
    One try of a call of a remote model.
    """

    job_id: UUID
    stage: str
    instance: str | None = None
    """
    Absent when the stage works on the whole scene.
    """
    port: Literal["analyst", "image_generator", "segmenter", "mesh_generator", "feature_extractor"]
    """
    Purpose of a call of a remote model.
    """
    provider: str
    model: str
    endpoint: str
    operation: str
    idempotency_key: str
    """
    The same for every try of a question in one stage of one job.
    """
    attempt: int
    reserved_usd: float
    """
    US dollars, whole millionths.
    """
    settled_usd: float | None
    """
    Null while the call is under way.
    """
    outcome: str | None
    """
    `answered`, `outcome_unknown` (it may have been answered and billed), or the code of a failure; null while the call
    is under way.
    """
    sent_bytes: int
    received_bytes: int | None
    input_tokens: int | None
    output_tokens: int | None
    task: str | None
    """
    The vendor's id of the job that the call began; null where the answer came at once.
    """
    started_at: AwareDatetime
    """
    RFC 3339 in UTC with milliseconds.
    """
    finished_at: AwareDatetime | None
    """
    RFC 3339 in UTC with milliseconds.
    """


class Category(Model):
    """
    A category of objects.
    """

    name: str
    label: str
    """
    In words, singular.
    """
    synonyms: list[str]
    stands_in_for: list[str]
    """
    Other objects, in words, for which one of this category stands in.
    """
    families: list[str]
    group: str
    """
    Functional group, such as `cutlery`.
    """
    size: SizeView
    mass_kg: float | None
    """
    Mass at the typical size, kilograms; null where it follows from volume and substance.
    """
    substance: str
    """
    Main substance.
    """
    palette: list[str]
    """
    Colors that it has where none is asked for, `#rrggbb`.
    """
    affordances: list[str]
    states: list[str]
    """
    States that it can be in beside standing upright.
    """


class ChangedPart(Model):
    """
    A part of the text that an edit changed.
    """

    span: TextSpan
    by: str
    """
    Change made by the operation, in one sentence.
    """


class DatasetFilter(Model):
    """
    Conditions; a scene must meet all. Those that are absent hold, but that the verdict must be `pass`.
    """

    verdict: Literal["pass", "quarantine", "any"] | None = None
    """
    Condition on the verdict of a scene.
    """
    min_objects: int | None = None
    max_objects: int | None = None
    required_categories: list[str] | None = None
    """
    Each category must occur.
    """
    excluded_categories: list[str] | None = None
    """
    None of the categories may occur.
    """
    labels: dict[str, str] | None = None
    """
    Labels of the batch's record, by name.
    """


class DatasetSubmission(Model):
    """
    Exactly one of `batch`, `scenes` and `label` names the scenes.
    """

    name: str
    batch: UUID | None = None
    """
    A batch that has ended.
    """
    scenes: list[UUID] | None = None
    label: str | None = None
    """
    The scenes with this label, `key:value`.
    """
    filter: DatasetFilter | None = None
    splits: dict[str, float] | None = None
    """
    Ratios with the sum 1, by names of lower-case letters, digits and `_`, in this order; 0.8 `train`, 0.1 `validation`
    and 0.1 `test` when absent. A split with a ratio above 0 that would be empty is an error: of this request where the
    ids of `scenes` show it, else the freeze fails with `empty_split`.
    """
    seed: int | None = 0
    """
    Of the assignment to splits.
    """
    disjoint: list[Literal["lineage", "text", "image", "mesh"]] | None = None
    """
    Parts that scenes of different splits must not share; all kinds when absent, nothing when empty.
    """
    shard_mb: int | None = None
    """
    Largest shard in MiB; 64 when absent.
    """
    shard_scenes: int | None = None


class DatasetSummary(Model):
    """
    From the manifest of the version.
    """

    counts: dict[str, Any]
    selection: dict[str, Any]
    changes: dict[str, Any] | None
    unchanged: bool
    """
    The version existed already.
    """


class DatasetVerification(Model):
    """
    Whether a verification waits or runs, and what the last one found.
    """

    state: Literal["queued", "running", "finished"]
    """
    State of a verification.
    """
    found: VerificationResult | None


class Diagnosis(Model):
    """
    Facts about a job that killed its process again and again.
    """

    alone: bool
    """
    No other job was in the process that died last.
    """
    shared_deaths: int
    """
    Number of deaths of the process while it held the job, since the job's last new checkpoint.
    """
    lone_deaths: int
    """
    Number of deaths of the process while it held the job, since the job's last new checkpoint.
    """
    stages: list[StageInProgress]
    """
    Stages in progress at the last death.
    """
    events: list[EventName]
    """
    The job's last events, newest first.
    """


class EditAccount(Model):
    """
    Result of an edit: part of `scene.json`, of the report, and of the scene in the API.
    """

    parent: str
    """
    Id of the parent in its `scene.json`.
    """
    operations: list[OperationResult]
    """
    One entry per operation, in order.
    """
    asides: list[str] | None = None
    """
    Words of the instruction that ask for nothing, where the edit was given in words.
    """
    moved: list[MovedObject]
    """
    Objects that no operation names and that moved nevertheless. All others have exactly the parent's poses.
    """


class EditPlace(Model):
    """
    A place, by exactly one of `relation`, `position_m` and `offset_m`.
    """

    relation: (
        Literal[
            "on",
            "in",
            "left_of",
            "right_of",
            "in_front_of",
            "behind",
            "next_to",
            "between",
            "at_center",
            "at_back",
            "at_front",
            "at_left",
            "at_right",
            "at_back_left",
            "at_back_right",
            "at_front_left",
            "at_front_right",
            "from_left_edge",
            "from_right_edge",
            "from_front_edge",
            "from_back_edge",
        ]
        | None
    ) = None
    target: str | None = None
    """
    The other object; absent for the table.
    """
    second_target: str | None = None
    """
    The second object of `between`.
    """
    distance_m: float | None = None
    """
    Free distance to the target or to the edge.
    """
    position_m: list[float] | None = None
    """
    Center of the object on the table top, from its center, to the right and to the back.
    """
    offset_m: list[float] | None = None
    """
    Displacement from where a moved object is, to the right and to the back.
    """
    yaw_rad: float | None = None
    """
    Rotation about the vertical axis; 0 faces the front edge. Chosen where it is absent.
    """


class EditPrediction(Model):
    """
    Prediction of an edit, as far as it needs no new object.
    """

    operations: list[OperationResult]
    """
    Results of the operations that need no new object.
    """
    undetermined: list[int]
    """
    Indices of operations whose objects are made, and placed, only when the edit runs; later operations are predicted
    without them.
    """
    moved: list[MovedObject]
    """
    Objects that no operation names and that would move.
    """


class EpisodeRecording(Model):
    """
    Recorded data of each episode.
    """

    cameras: list[EpisodeCamera | Literal["side", "front", "wrist"]] | None = None
    """
    Usual cameras or own ones, which have at most 4,194,304 pixels together; the three usual ones when absent.
    """
    size_px: int | None = 224
    """
    Side of the images of usual cameras.
    """
    fps: int | None = 15
    """
    Frames per second.
    """
    depth: bool | None = False
    """
    Needs a camera; one of the formats must be robomimic or parquet-png.
    """
    instance_ids: bool | None = False
    """
    Needs a camera; one of the formats must be robomimic or parquet-png.
    """
    point_cloud: int | None = None
    """
    Points in a cloud of what all cameras see. Needs a camera; one of the formats must be robomimic or parquet-png.
    """


class ExecutedGrasp(Model):
    """
    A grasp of a parallel gripper; the tool closes along its y axis and comes along its z axis.
    """

    object_from_tool: Pose
    """
    The tool when the fingers have closed.
    """
    opening_m: float
    """
    Distance of the pads from each other when they hold the object, meters.
    """
    pregrasp_opening_m: float
    """
    Distance of the pads from each other when the hand approaches, meters.
    """
    force_n: float
    """
    Force of each pad, newtons.
    """
    confidence: float
    """
    0..=1: the score of the candidate, and above 0.5 only if it was stable.
    """
    verdict: Literal["stable", "slipped", "dropped", "untested"]
    """
    Result of the trial of a grasp in simulation.
    """
    slip_m: float
    """
    Distance that the gripped point moved in the hand while it was shaken, meters; 0 if it was not tried.
    """
    turn_rad: float
    """
    Angle by which the object turned in the hand since it was gripped, radians; 0 if it was not tried.
    """


class Failure(Model):
    """
    Reason of the failure.
    """

    class_: (
        Literal[
            "transient",
            "rate_limited",
            "permanent",
            "refused",
            "over_budget",
            "crashed",
        ]
        | None
    ) = Field(None, alias="class")
    """
    Whether and when a failure is worth another try.
    """
    code: str
    message: str


class Frame(Model):
    """
    The commands and the state at a time.
    """

    time_s: float
    phase: Literal["transit", "approach", "close", "lift", "carry", "lower", "open", "retreat", "rest"]
    """
    Activity of the robot at a time.
    """
    joint_targets: list[float]
    """
    Servo targets from this time on: a position servo with the stiffness and damping of the model that follows these
    targets repeats the motion. They lead the motion, because damping and held weights hold it back.
    """
    joint_references: list[float]
    """
    Planned positions of the joints at `k / rate_hz`, for frame `k`: within the limits of position, velocity,
    acceleration and jerk, as differences of these numbers are, too.
    """
    joint_positions: list[float]
    """
    Numbers in the order of the joints.
    """
    joint_velocities: list[float]
    """
    Numbers in the order of the joints.
    """
    opening_target_m: float
    """
    Target and measured distance of the pads from each other at this time, meters. While they hold an object, the target
    is lower by the offset that the gripper's servo needs for the force of the grasp: below 0 where the object is thin.
    """
    opening_reference_m: float
    """
    Target distance as fast as the limits of the fingers allow, and never below 0.
    """
    opening_m: float
    gripper_target: float
    """
    Target position of the gripper's joint: the one that belongs to `opening_target_m`.
    """
    object_poses: list[Pose]
    """
    `world_from_object`.
    """


class GoalPredicate(Model):
    """
    A condition on the end state.
    """

    predicate: Literal[
        "in",
        "on",
        "stacked_on",
        "left_of",
        "right_of",
        "in_front_of",
        "behind",
        "next_to",
        "between",
        "at_center",
        "at_back",
        "at_front",
        "at_left",
        "at_right",
        "at_back_left",
        "at_back_right",
        "at_front_left",
        "at_front_right",
        "lifted",
        "opened",
        "closed",
        "upright",
        "lying_on_side",
        "upside_down",
        "out_of",
        "off",
        "away_from",
        "swapped",
        "rotated",
        "moved",
        "poured_into",
        "used_on",
        "pressed",
    ]
    """
    Kinds of conditions. Directions are as seen from the front edge of the table.
    """
    object: str
    target: str | None = None
    """
    The second object of a relation; absent for properties and for relations to the table.
    """
    second_target: str | None = None
    """
    The third object of `between`.
    """


class HeldJob(Model):
    """
    A job that a worker holds.
    """

    job_id: UUID
    kind: Literal["generate", "retry", "freeze_dataset", "verify_dataset", "record_attempt", "assemble_recording", "execute_task"]
    """
    The operation: `generate` and `retry` build a scene, `freeze_dataset` makes a version of a dataset and
    `verify_dataset` reads one, `record_attempt` makes one attempt of a recording and `assemble_recording` writes its
    dataset, `execute_task` has a simulated robot do a task.
    """
    scene_id: UUID | None
    dataset_id: UUID | None
    recording_id: UUID | None
    since: AwareDatetime
    """
    Time of the newest claim of the job.
    """


class Index(Model):
    """
    Name and version of the program, and paths of its interface.
    """

    name: str
    version: str
    links: IndexLinks


class Job(Model):
    """
    An operation on a scene, a dataset or a recording.
    """

    id: UUID
    kind: Literal["generate", "retry", "freeze_dataset", "verify_dataset", "record_attempt", "assemble_recording", "execute_task"]
    """
    The operation: `generate` and `retry` build a scene, `freeze_dataset` makes a version of a dataset and
    `verify_dataset` reads one, `record_attempt` makes one attempt of a recording and `assemble_recording` writes its
    dataset, `execute_task` has a simulated robot do a task.
    """
    state: Literal["queued", "running", "cancelling", "succeeded", "failed", "cancelled"]
    """
    Activity of the machine with a job.
    """
    scene_id: UUID | None
    """
    The scene that is built, or the one in which a task is executed.
    """
    dataset_id: UUID | None
    recording_id: UUID | None
    attempt_number: int | None = None
    """
    Of an attempt of a recording, from 0. Absent from other jobs.
    """
    retry_of: UUID | None
    from_stage: str | None
    attempt: int
    """
    Tries since the last progress.
    """
    queue_position: int | None = None
    """
    Place among the client's own queued scenes, 1 is next. Absent unless the job waits and builds a scene.
    """
    estimated_finish_at: AwareDatetime | None = None
    """
    Probable end of the job, by the durations of jobs that ended lately and the jobs that run now. Absent where these
    say nothing, and once the job has ended.
    """
    failure: Failure | None
    created_at: AwareDatetime
    """
    RFC 3339 in UTC with milliseconds.
    """
    started_at: AwareDatetime | None
    """
    RFC 3339 in UTC with milliseconds.
    """
    finished_at: AwareDatetime | None
    """
    RFC 3339 in UTC with milliseconds.
    """
    links: JobLinks


class JobPage(Model):
    """
    A page of jobs.
    """

    jobs: list[Job]
    next_page_token: str | None
    """
    Null on the last page.
    """


class Key(Model):
    """
    A key without its secret.
    """

    id: UUID
    tenant: str
    name: str
    scopes: list[Literal["read", "submit", "delete", "operate", "admin"]]
    created_at: AwareDatetime
    """
    RFC 3339 in UTC with milliseconds.
    """
    expires_at: AwareDatetime | None
    """
    RFC 3339 in UTC with milliseconds.
    """
    revoked_at: AwareDatetime | None
    """
    RFC 3339 in UTC with milliseconds.
    """
    last_used_at: AwareDatetime | None
    """
    To a minute.
    """
    key: str | None = None
    """
    The secret, in the answer to its making alone.
    """


class KeyPage(Model):
    """
    A page of keys.
    """

    keys: list[Key]
    next_page_token: str | None
    """
    Null on the last page.
    """


class MethodShare(Model):
    """
    Number of objects of one reconstruction method.
    """

    method: Literal["box", "category", "turned", "slab", "extrusion", "inflation", "generated"]
    """
    Method by which the shape of a mesh was found.
    """
    objects: int
    share: float
    """
    Share of all objects, 0..1.
    """


class MoveCameraOperation1(Model):
    """
    Another view of the reference camera: turned about the center of the table and raised, nearer or farther, or with
    another focal length; at least one of them.
    """

    op: Literal["move_camera"]
    turn_rad: float | None
    raise_rad: float | None = None
    distance_factor: float | None = None
    """
    A factor.
    """
    focal_factor: float | None = None
    """
    A factor.
    """


class MoveCameraOperation2(Model):
    """
    Another view of the reference camera: turned about the center of the table and raised, nearer or farther, or with
    another focal length; at least one of them.
    """

    op: Literal["move_camera"]
    turn_rad: float | None = None
    raise_rad: float | None
    distance_factor: float | None = None
    """
    A factor.
    """
    focal_factor: float | None = None
    """
    A factor.
    """


class MoveCameraOperation3(Model):
    """
    Another view of the reference camera: turned about the center of the table and raised, nearer or farther, or with
    another focal length; at least one of them.
    """

    op: Literal["move_camera"]
    turn_rad: float | None = None
    raise_rad: float | None = None
    distance_factor: float | None
    """
    A factor.
    """
    focal_factor: float | None = None
    """
    A factor.
    """


class MoveCameraOperation4(Model):
    """
    Another view of the reference camera: turned about the center of the table and raised, nearer or farther, or with
    another focal length; at least one of them.
    """

    op: Literal["move_camera"]
    turn_rad: float | None = None
    raise_rad: float | None = None
    distance_factor: float | None = None
    """
    A factor.
    """
    focal_factor: float | None
    """
    A factor.
    """


class MoveOperation(Model):
    """
    Another place; what stands on or in the object moves with it.
    """

    op: Literal["move"]
    target: str
    """
    An object of the scene: its name (`mug_1`) or a phrase ("the red mug", "the second book from the left", "all
    spoons"). A phrase that fits several objects where one is meant fails the job, which names them.
    """
    where: EditPlace


class NewKey(Model):
    """
    A key to be made.
    """

    name: str
    """
    For people, such as the machine that uses it.
    """
    scopes: list[Literal["read", "submit", "delete", "operate", "admin"]]
    expires_in_s: int | None = None
    """
    The key expires after so many seconds; never, where it is absent.
    """
    tenant: str | None = None
    """
    The operator's administrators may name any; others their own one.
    """


class NewWebhook(Model):
    """
    A webhook to be made.
    """

    url: AnyUrl
    """
    https, at a public address, without a name and a password.
    """
    description: str | None = ""
    """
    For people.
    """
    events: (
        list[
            Literal[
                "scene.succeeded",
                "scene.failed",
                "scene.cancelled",
                "job.failed",
                "job.cancelled",
                "batch.ended",
                "recording.ended",
                "scene.quarantined",
                "job.succeeded",
                "dataset.ended",
                "webhook.test",
            ]
        ]
        | None
    ) = None
    """
    Events to send; all, where it is absent or empty.
    """


class OpenApi(Model):
    """
    A document by the OpenAPI Specification.
    """

    openapi: str
    info: dict[str, Any]
    paths: dict[str, Any]


class Pick(Model):
    """
    An object that was picked up, its grasp, and how far it moved in the hand.
    """

    object: str
    grasp: ExecutedGrasp
    slip_m: float
    """
    Distance that the gripped point moved in the hand until it was let go, meters.
    """


class PredicateOutcome(Model):
    """
    Whether a predicate holds, and the value that decides.
    """

    predicate: GoalPredicate
    holds: bool
    measured: float
    """
    The value that decides, meters or radians; 0 where nothing can be measured.
    """
    limit: float
    bound: str
    """
    Side of the limit on which the measured value must be: `at_least` or `at_most`.
    """
    unit: str
    """
    `meters` or `radians`.
    """
    reason: str
    """
    Meaning of the measured value, or the reason why the predicate does not hold.
    """


class Problem(Model):
    """
    A refusal (RFC 9457).
    """

    type: Literal[
        "urn:tabletopgen:problem:malformed-request",
        "urn:tabletopgen:problem:invalid-request",
        "urn:tabletopgen:problem:unauthorized",
        "urn:tabletopgen:problem:forbidden",
        "urn:tabletopgen:problem:not-found",
        "urn:tabletopgen:problem:method-not-allowed",
        "urn:tabletopgen:problem:request-timeout",
        "urn:tabletopgen:problem:conflict",
        "urn:tabletopgen:problem:gone",
        "urn:tabletopgen:problem:precondition-failed",
        "urn:tabletopgen:problem:payload-too-large",
        "urn:tabletopgen:problem:unsupported-media-type",
        "urn:tabletopgen:problem:range-not-satisfiable",
        "urn:tabletopgen:problem:misdirected-request",
        "urn:tabletopgen:problem:too-many-requests",
        "urn:tabletopgen:problem:internal",
        "urn:tabletopgen:problem:unavailable",
        "urn:tabletopgen:problem:insufficient-storage",
    ]
    """
    Type of a problem; each has one status.
    """
    title: str
    """
    The reason phrase of the status.
    """
    status: int
    code: str
    detail: str
    """
    Correction.
    """
    request_id: str
    errors: list[FieldError] | None = None
    limit: LimitUse | None = None
    """
    The limit that leaves no room, where that is the reason.
    """


class QueueWorker(Model):
    """
    A worker and the jobs that it holds.
    """

    id: str
    since: AwareDatetime
    """
    The earliest claim of these jobs.
    """
    jobs: list[HeldJob]


class RecolorOperation(Model):
    """
    Another color, another material, or both; at least one of them. Materials change mass and friction.
    """

    op: Literal["recolor"]
    target: str
    """
    An object of the scene: its name (`mug_1`) or a phrase ("the red mug", "the second book from the left", "all
    spoons"). A phrase that fits several objects where one is meant fails the job, which names them.
    """
    color: str | None = None
    material: str | None = None


class RecordedDataset(Model):
    """
    Content of the recorded dataset.
    """

    episodes: int
    frames: int
    formats: list[RecordedFormat]


class RecordingEventData(Model):
    """
    Subject of the event; each kind has the fields that name it.
    """

    progress: RecordingProgress
    number: int | None = None
    """
    `attempt`, `attempt_lost`: the number of the attempt, which others may overtake.
    """
    outcome: str | None = None
    """
    `attempt`: `success`, or the reason of its failure.
    """
    detail: str | None = None
    """
    `attempt` without success: what happened, in words.
    """
    failure: RecordingFailure | None = None


class Relaxation(Model):
    """
    An object that was made smaller or moved for lack of space.
    """

    name: str
    outcome: Literal["shrunk", "moved"]
    """
    Change of an object that has no room.
    """
    scale: float | None = None
    """
    Of what was shrunk: the factor on its size.
    """
    from_: str | None = Field(None, alias="from")
    """
    Of what was moved to the table: what was to carry it.
    """


class RobotFinding(Model):
    """
    Abilities of the robot of the request in the scene, measured in simulation.
    """

    name: str
    """
    As the request names it.
    """
    objects: int
    """
    Number of objects that are for grippers.
    """
    pickable: int
    """
    Number of objects that it can pick up where they are: a stable grasp is free of table and neighbors on its way to
    the object and up with it, and the arm makes both motions from some place of its base.
    """
    tasks_proposed: int
    """
    Number of tasks that were proposed, each with objects that it can pick up.
    """
    tasks_done: int
    """
    Number of proposed tasks that it executed successfully.
    """
    tasks: list[TriedTask]
    """
    The proposed tasks, in the order of their proposal.
    """


class SceneSettings(Model):
    """
    Settings of this scene that differ from the server's, as text; `config/default.toml` says all about each. Others are
    its operator's.
    """

    analyst_default_max_objects: str | None = Field(None, alias="analyst.default_max_objects")
    """
    Maximum objects of a scene the theme completes; at least fewest_objects (objects, 1 to 64).
    """
    analyst_fewest_objects: str | None = Field(None, alias="analyst.fewest_objects")
    """
    Fewest objects of a scene the theme completes; more fills the table (objects, 1 to 64).
    """
    analyst_table_area_per_footprint: str | None = Field(None, alias="analyst.table_area_per_footprint")
    """
    Table area over the area its objects cover; more gives emptier tables (ratio, 1.5 to 10).
    """
    appraise_ratings: Literal["true", "false"] | None = Field(None, alias="appraise.ratings")
    """
    A truth value as text.
    """
    appraise_tasks: str | None = Field(None, alias="appraise.tasks")
    """
    How many tasks for a robot the analyst proposes for each finished scene, each with the objects it is about; 0 asks
    for none. One more call a scene. Wants chat in providers.analyst (tasks, 0 to 20).
    """
    category_fit_max_oversize: str | None = Field(None, alias="category_fit.max_oversize")
    """
    Maximum by which an image's scale may be off; more takes large objects for small ones (natural logarithm, 0.1 to
    1.5).
    """
    category_fit_min_confidence: str | None = Field(None, alias="category_fit.min_confidence")
    """
    Probability from which an object gets the name of a category; less names more objects, and more of them wrongly. 1
    names none and compares nothing (probability, 0 to 1).
    """
    decompose_joined_excess_m: str | None = Field(None, alias="decompose.joined_excess_m")
    """
    How far hulls may stick out that are joined because there are more than that; where too many are left it is raised
    by halves. Less keeps gaps and holes open, more leaves less air in all hulls together (meters, 0.0005 to 1).
    """
    decompose_max_hulls: str | None = Field(None, alias="decompose.max_hulls")
    """
    Maximum hulls of a mesh; more fits closer and makes contact slower (hulls, 1 to 64).
    """
    decompose_max_pieces: str | None = Field(None, alias="decompose.max_pieces")
    """
    Maximum pieces concave shells are cut into before joining, together (each may have twelve); more fits lumpy objects
    closer and takes longer (pieces, 1 to 48).
    """
    decompose_max_vertices: str | None = Field(None, alias="decompose.max_vertices")
    """
    Maximum corners of a hull; 64 is what GPU engines accept (corners, 8 to 64).
    """
    decompose_min_thickness_m: str | None = Field(None, alias="decompose.min_thickness_m")
    """
    Minimum thickness of a hull; thin sheets tunnel through objects (meters, 0 to 0.01).
    """
    decompose_tolerance_m: str | None = Field(None, alias="decompose.tolerance_m")
    """
    How far a hull may stick out of the visual mesh; less gives closer and more hulls (meters, 0.001 to 0.01).
    """
    dro_refine_camera: Literal["true", "false"] | None = Field(None, alias="dro.refine_camera")
    """
    A truth value as text.
    """
    export_author: str | None = Field(None, alias="export.author")
    """
    Author named in asset metadata (text).
    """
    export_date: str | None = Field(None, alias="export.date")
    """
    Date written into asset metadata; a setting and not a clock, so bundles are the same on any day (YYYY-MM-DD).
    """
    export_gravity_m_s2: str | None = Field(None, alias="export.gravity_m_s2")
    """
    Gravity of the simulation files, positive downward (meters/second^2, 0 to 100).
    """
    export_licence: str | None = Field(None, alias="export.licence")
    """
    SPDX identifier of the licence of the bundle's own files and of assets that name none (text).
    """
    export_mujoco_impratio: str | None = Field(None, alias="export.mujoco_impratio")
    """
    MuJoCo's ratio of frictional to normal constraint impedance; larger creeps less and converges more slowly (ratio, 1
    to 100).
    """
    export_mujoco_timestep_s: str | None = Field(None, alias="export.mujoco_timestep_s")
    """
    Step of the MJCF file; smaller is stiffer and slower (seconds, 0.0005 to 0.005).
    """
    export_urdf: Literal["relative", "ros2"] | None = Field(None, alias="export.urdf")
    """
    Paths of meshes in the URDF files. relative: to the file. ros2: package:// paths, and urdf/ is a ROS 2 package with
    package.xml and CMakeLists.txt.
    """
    export_usd: Literal["usda", "usdc", "usdz"] | None = Field(None, alias="export.usd")
    """
    Form of the USD files. usda: every layer as text. usdc: layers with meshes in the crate format, which is smaller and
    opens faster; the stage as text. usdz: everything in one package, usd/scene.usdz.
    """
    export_usd_dome_intensity: str | None = Field(None, alias="export.usd_dome_intensity")
    """
    Intensity of the USD dome light; brighter is larger (intensity, 0 to 1000000).
    """
    export_usd_sun_intensity: str | None = Field(None, alias="export.usd_sun_intensity")
    """
    Intensity of the USD sun (intensity, 0 to 1000000).
    """
    image_generator_azimuth_rad: str | None = Field(None, alias="image_generator.azimuth_rad")
    """
    The camera stands at most this far from the front's center (radians, 0 to 1).
    """
    image_generator_elevation_rad: str | None = Field(None, alias="image_generator.elevation_rad")
    """
    Lowest and highest elevation of the camera (25 to 70 degrees); lower shows more sides and hides more (radians, 0.3
    to 1.5).
    """
    image_generator_fov_x_rad: str | None = Field(None, alias="image_generator.fov_x_rad")
    """
    Horizontal field of view; more gives stronger perspective (radians, 0.2 to 1.5).
    """
    image_generator_frame_margin: str | None = Field(None, alias="image_generator.frame_margin")
    """
    Share of the image left free on each side (share, 0 to 0.3).
    """
    image_generator_height_px: str | None = Field(None, alias="image_generator.height_px")
    """
    Height of the reference image (pixels, 240 to 960).
    """
    image_generator_width_px: str | None = Field(None, alias="image_generator.width_px")
    """
    Width of the reference image; more gives finer masks and takes longer (pixels, 320 to 1280).
    """
    layout_edge_margin_m: str | None = Field(None, alias="layout.edge_margin_m")
    """
    Distance kept from the table's edge (meters, 0 to 0.2).
    """
    layout_gap_m: str | None = Field(None, alias="layout.gap_m")
    """
    Free space around each object; more is sparser (meters, 0.002 to 0.1).
    """
    layout_jitter_rad: str | None = Field(None, alias="layout.jitter_rad")
    """
    Standard deviation of how carelessly objects are turned; more is messier (radians, 0 to 0.5).
    """
    layout_min_gap_m: str | None = Field(None, alias="layout.min_gap_m")
    """
    What that shrinks to in the last attempts (meters, 0.001 to 0.1).
    """
    layout_placement_cost_noise: str | None = Field(None, alias="layout.placement_cost_noise")
    """
    Share of chance in the cost of a place; more is more various and less orderly (cost, 0 to 2).
    """
    mesh_generator_wear: str | None = Field(None, alias="mesh_generator.wear")
    """
    Traces of use on tabletops and objects of the catalog: scratches, stains, rings of cups, dust. 0 is as new, 1
    neglected. Glass, ceramics, cloth and food stay clean; photographs show their own (share, 0 to 1).
    """
    no_room_min_scale: str | None = Field(None, alias="no_room.min_scale")
    """
    Nothing is made smaller than this share of its size; less makes room on fuller tables (share, 0.1 to 1).
    """
    no_room_outcome: Literal["fail", "shrink", "move"] | None = Field(None, alias="no_room.outcome")
    """
    What is done when an object has to be given up, as the table is too full or it does not find its place in or on
    another one: the job fails and names it; objects are made smaller until there is room (all alike on a full table,
    else the object alone with what it carries); or it is moved from what was to carry it to free space on the table.
    What was done is in the report.
    """
    photograph_field_of_view_rad: str | None = Field(None, alias="photograph.field_of_view_rad")
    """
    Horizontal field of view of the camera; 0 = estimated from the image. Of a request without it, it is what the EXIF
    data of its image state (radians, 0 to 2.6).
    """
    photograph_intrinsics_px: str | None = Field(None, alias="photograph.intrinsics_px")
    """
    Intrinsics of the camera in place of its field of view: focal lengths fx, fy, principal point cx, cy, then width and
    height of the image that they belong to, which may be larger or smaller than the given one. All 0 = not known
    (pixels, 0 to 65536).
    """
    photograph_table_height_m: str | None = Field(None, alias="photograph.table_height_m")
    """
    Height every table is taken to have where its feet show and nothing else is known (meters, 0.4 to 1).
    """
    preview_hero_width_px: str | None = Field(None, alias="preview.hero_width_px")
    """
    Width of the hero image; more shows more and takes longer (pixels, 64 to 1920).
    """
    preview_side_width_px: str | None = Field(None, alias="preview.side_width_px")
    """
    Width of the side and top views and of either half of the image beside the reference (pixels, 64 to 960).
    """
    render_shadow_map_px: str | None = Field(None, alias="render.shadow_map_px")
    """
    Side of the key light's shadow map, 0 for no shadows; more gives crisper contact shadows (texels, 0 to 1024).
    """
    render_sky_directions: str | None = Field(None, alias="render.sky_directions")
    """
    Occlusion-tested directions of the sky, 0 for none; more gives smoother contact darkening (directions, 0 to 16).
    """
    render_supersampling: str | None = Field(None, alias="render.supersampling")
    """
    Color samples along each side of a pixel; 2 smooths edges at about three times the cost (samples, 1 to 2).
    """
    resolve_clearances_m: str | None = Field(None, alias="resolve.clearances_m")
    """
    Gaps kept between neighbors, one a round, growing; more values give more tries (meters, 0 to 0.1).
    """
    resolve_container_depth_share: str | None = Field(None, alias="resolve.container_depth_share")
    """
    A contained object must reach down into its container by this share of the cavity's depth (share, 0 to 1).
    """
    resolve_outline_margin_m: str | None = Field(None, alias="resolve.outline_margin_m")
    """
    Distance everything keeps from the table's edge (meters, 0 to 0.2).
    """
    tsa_origin: Literal["sightings", "table"] | None = Field(None, alias="tsa.origin")
    """
    What tells where the world's origin is on the top view: the table's box together with the places where the camera of
    the reference image sees the objects, or as in the paper the table's box alone.
    """
    tsa_scale: Literal["consensus", "anchor"] | None = Field(None, alias="tsa.scale")
    """
    Who sets the scale of the top view: all objects by vote, or as in the paper the one whose box is largest and of the
    most believable shape.
    """


class Spending(Model):
    """
    Cost of calls of remote models; only when one scene is asked for. No call is made whose reservation would overrun
    the budget.
    """

    budget_usd: float
    """
    US dollars, whole millionths.
    """
    spent_usd: float
    """
    By calls that have ended, with what those of unknown outcome may have cost.
    """
    reserved_usd: float
    """
    For calls under way.
    """
    calls: list[Call]
    """
    Every try of every call, in order.
    """


class Stage(Model):
    """
    One stage of a job.
    """

    stage: str
    instance: str | None = None
    """
    Absent when the stage works on the whole scene.
    """
    state: Literal["running", "finished"]
    """
    State of a stage.
    """
    cached: bool
    """
    Found, not computed, when the job last passed here.
    """
    runs: int
    """
    Number of times that this job started computing it.
    """
    elapsed_ms: int | None
    """
    Duration of the computation, in whichever job it ran.
    """
    started_at: AwareDatetime
    """
    RFC 3339 in UTC with milliseconds.
    """


class StageList(Model):
    """
    The stages of a job.
    """

    stages: list[Stage]


class Task(Model):
    """
    A task for a robot in a scene, as `schemas/task.schema.json` describes it.
    """

    format: Literal["tabletopgen-task/1"]
    """
    `tabletopgen-task/1`.
    """
    instruction: str
    """
    The instruction to the robot, in natural language.
    """
    goal: list[GoalPredicate]
    """
    Predicates that must all hold at the end.
    """
    robot: str
    """
    Name of the robot (`panda`).
    """
    limits: TaskLimits


class Trajectory(Model):
    """
    The motion in equal steps of time. Angles in radians, lengths in meters.
    """

    rate_hz: float
    joints: list[str]
    """
    The joints of the arm, in the order of the frames' numbers.
    """
    gripper_joint: str
    """
    The joint whose servo moves all fingers.
    """
    objects: list[str]
    """
    The objects, in the order of the frames' poses.
    """
    frames: list[Frame]


class Unrecognized(Model):
    """
    A part of the text that has no effect, and the reason.
    """

    span: TextSpan
    reason: Literal[
        "unknown_object",
        "unknown_word",
        "not_placeable",
        "out_of_range",
        "not_supported",
        "contradiction",
        "no_referent",
        "not_expressible",
        "not_in_image",
        "shown_by_image",
    ]
    """
    The reason why a part of the text has no effect.
    """
    nearest_by_spelling: str | None = None
    """
    The known word that is spelled most similarly.
    """
    nearest_by_meaning: str | None = None
    """
    The known object that is nearest in meaning.
    """


class Webhook(Model):
    """
    A webhook.
    """

    id: UUID
    url: str
    description: str
    events: list[
        Literal[
            "scene.succeeded",
            "scene.failed",
            "scene.cancelled",
            "job.failed",
            "job.cancelled",
            "batch.ended",
            "recording.ended",
            "scene.quarantined",
            "job.succeeded",
            "dataset.ended",
            "webhook.test",
        ]
    ]
    """
    Events that are sent; empty: all.
    """
    state: Literal["enabled", "disabled"]
    """
    Whether events are sent.
    """
    disabled_reason: str | None
    """
    Reason why it is disabled.
    """
    created_at: AwareDatetime
    """
    RFC 3339 in UTC with milliseconds.
    """
    updated_at: AwareDatetime
    """
    RFC 3339 in UTC with milliseconds.
    """
    secret: str | None = None
    """
    Key of the signatures, in the answer to its making alone.
    """


class WebhookList(Model):
    """
    The webhooks of the tenant, newest first.
    """

    webhooks: list[Webhook]


class WebhookMessage(Model):
    """
    The message of an event: the body that is signed and sent.
    """

    type: Literal[
        "scene.succeeded",
        "scene.failed",
        "scene.cancelled",
        "job.failed",
        "job.cancelled",
        "batch.ended",
        "recording.ended",
        "scene.quarantined",
        "job.succeeded",
        "dataset.ended",
        "webhook.test",
    ]
    """
    Kind of an event. A scene, a job, a recording or a dataset that is worked on again ends again.
    """
    timestamp: AwareDatetime
    """
    Time of the event.
    """
    data: WebhookMessageData


class WebhookPatch(Model):
    """
    A change of a webhook.
    """

    url: AnyUrl | None = None
    description: str | None = None
    """
    Null removes it.
    """
    events: (
        list[
            Literal[
                "scene.succeeded",
                "scene.failed",
                "scene.cancelled",
                "job.failed",
                "job.cancelled",
                "batch.ended",
                "recording.ended",
                "scene.quarantined",
                "job.succeeded",
                "dataset.ended",
                "webhook.test",
            ]
        ]
        | None
    ) = None
    """
    Null or an empty list: all.
    """
    state: Literal["enabled", "disabled"] | None = None
    """
    One that is enabled again sends what has waited since.
    """


class AddOperation(Model):
    """
    New objects: a phrase as in a text ("a red mug"), without a place; anywhere on the table unless `where` is given.
    """

    op: Literal["add"]
    object: str
    """
    Words for a new object, or a label.
    """
    count: int | None = 1
    where: EditPlace | None = None


class ArrangeOperation(Model):
    """
    Objects in a row or a column: in the order of the phrases, sorted, or as they stand.
    """

    op: Literal["arrange"]
    targets: list[str]
    arrangement: Literal["row", "column"]
    """
    Directions in which objects are lined up.
    """
    sort_by: Literal["size", "height", "color", "kind"] | None = None
    where: EditPlace | None = None
    """
    An edge or a part of the table; where the objects are unless it is given.
    """


class Catalog(Model):
    """
    The objects that scenes are made of.
    """

    categories: list[Category]


class Dataset(Model):
    """
    A freeze, and the version that it made.
    """

    id: UUID
    name: str
    version: int | None
    job_id: UUID | None
    """
    The newest job, the freeze or the last verification; null of versions that an earlier release froze.
    """
    state: Literal["queued", "running", "finished", "failed"]
    """
    State of a freeze.
    """
    request: dict[str, Any]
    digest: str | None
    """
    SHA-256 of the manifest, as it states it.
    """
    summary: DatasetSummary | None
    failure: DatasetFailure | None
    progress: DatasetProgress | None
    verification: DatasetVerification | None
    created_at: AwareDatetime
    """
    RFC 3339 in UTC with milliseconds.
    """
    finished_at: AwareDatetime | None
    """
    RFC 3339 in UTC with milliseconds.
    """
    links: DatasetLinks


class DatasetPage(Model):
    """
    A page of datasets.
    """

    datasets: list[Dataset]
    next_page_token: str | None
    """
    Null on the last page.
    """


class Delivery(Model):
    """
    A message for a webhook, with the account of its attempts.
    """

    id: str
    """
    The header `webhook-id`, the same in every attempt.
    """
    event: Literal[
        "scene.succeeded",
        "scene.failed",
        "scene.cancelled",
        "job.failed",
        "job.cancelled",
        "batch.ended",
        "recording.ended",
        "scene.quarantined",
        "job.succeeded",
        "dataset.ended",
        "webhook.test",
    ]
    """
    Kind of an event. A scene, a job, a recording or a dataset that is worked on again ends again.
    """
    state: Literal["waiting", "delivered", "failed"]
    """
    State of a delivery to a webhook.
    """
    created_at: AwareDatetime
    """
    RFC 3339 in UTC with milliseconds.
    """
    attempts: int
    """
    Attempts since it was ordered, the present one included.
    """
    next_attempt_at: AwareDatetime | None
    """
    Earliest time of the next attempt; null for one that has ended.
    """
    last_attempt: DeliveryAttempt | None
    message: WebhookMessage


class DeliveryPage(Model):
    """
    A page of deliveries.
    """

    deliveries: list[Delivery]
    next_page_token: str | None
    """
    Null on the last page.
    """


class EditOptions(Model):
    """
    Options of an edit.
    """

    budget_usd: float | None = None
    """
    The most that calls of remote models may cost together; the server's usual budget when absent.
    """
    robot: str | None = None
    """
    A robot that is tried in the finished scene, such as `panda`: its grasps of each object, what it can pick up, and
    tasks. Takes seconds for each object.
    """
    set: SceneSettings | None = None


class EpisodesSubmission(Model):
    """
    Order of a recording; one of `task` and `tasks`.
    """

    title: str | None = None
    """
    Of the dataset's cards; the instructions when absent.
    """
    robot: str | None = "panda"
    task: Task | str | None = None
    """
    An instruction in words, or a task as `GET /scenes/{scene_id}/tasks` gives it.
    """
    tasks: list[Task | str] | None = None
    """
    Tasks that take turns.
    """
    count: int
    """
    Episodes that succeed.
    """
    seed: int | None = 0
    randomize: RandomizationAmplitudes | Literal["usual", "wide", "none"] | None = None
    """
    Differences between episodes.
    """
    record: EpisodeRecording | None = None
    formats: (
        list[Literal["lerobot-v3.0", "lerobot-v3.0-images", "lerobot-v2.1", "lerobot-v2.1-images", "robomimic", "parquet-png"]] | None
    ) = None
    """
    `lerobot-v3.0` when absent.
    """
    keep_failures: bool | None = False
    """
    Whether attempts that fail become episodes, too; they do not count.
    """
    max_attempts: int | None = None
    """
    Attempts until the recording fails, at least `count`; 4 for each episode, and 20, when absent.
    """


class EventData(Model):
    """
    Subject of the event; each kind has the fields that name it.
    """

    scene_id: UUID | None = None
    """
    `job_queued`.
    """
    attempt: int | None = None
    """
    `job_started`.
    """
    epoch: int | None = None
    """
    `job_started`: the number of the claim.
    """
    stage: str | None = None
    """
    `stage_started`, `stage_progress`, `stage_finished`.
    """
    instance: str | None = None
    """
    Of events of stages; absent when the stage works on the whole scene.
    """
    cached: bool | None = None
    """
    `stage_finished`: found, not computed.
    """
    elapsed_ms: int | None = None
    """
    `stage_finished`.
    """
    artifacts: list[str] | None = None
    """
    `stage_finished`: names of the artifacts of the stage. Absent from events of earlier versions.
    """
    failure: Failure | None = None
    delay_ms: int | None = None
    """
    `job_retrying`, `job_orphaned`: how long it waits.
    """
    alone: bool | None = None
    """
    `job_orphaned`: no other job was in the process that died.
    """
    shared_deaths: int | None = None
    """
    `job_orphaned`: beside other jobs.
    """
    lone_deaths: int | None = None
    """
    `job_orphaned`: alone in the process.
    """
    stages: list[StageInProgress] | None = None
    """
    `job_orphaned`: stages in progress when the process died.
    """
    diagnosis: Diagnosis | None = None
    """
    `job_failed` with the code `worker_crashed`.
    """
    class_: (
        Literal[
            "transient",
            "rate_limited",
            "permanent",
            "refused",
            "over_budget",
            "crashed",
        ]
        | None
    ) = Field(None, alias="class")
    """
    `job_failed`.
    """
    code: str | None = None
    """
    `job_failed`.
    """
    message: str | None = None
    """
    `job_failed`, `stage_progress`.
    """
    verdict: Literal["pass", "quarantine"] | None = None
    """
    `job_succeeded`.
    """
    metrics: Metrics | None = None
    """
    `job_succeeded`.
    """


class Execution(Model):
    """
    Result of a task.
    """

    robot: str
    variant: str | None
    """
    The variant of the robot's model.
    """
    world_from_base: Pose
    succeeded: bool
    failure: Literal["unreachable", "no_grasp", "no_path", "slipped", "dropped", "goal_not_met", "disturbed_others"] | None
    """
    Reason of the failure.
    """
    detail: str | None
    """
    Details of the failure, in words.
    """
    predicates: list[PredicateOutcome]
    """
    The verdicts about the goal's predicates at the end, with what was measured.
    """
    disturbed: list[Disturbance]
    """
    Objects beside the goal that were moved too far.
    """
    picks: list[Pick]
    """
    Objects that were picked up.
    """
    duration_s: float
    limit_shares: SharesOfLimits


class ExecutionRequest1(Model):
    """
    Task of a robot, in words or as a document; one of `text` and `task`.
    """

    text: str
    """
    An instruction in words.
    """
    task: Task | None = None
    """
    A task as `GET /scenes/{scene_id}/tasks` gives it; it names its robot.
    """
    robot: str | None = "panda"
    """
    The robot of an instruction in words; a task names its own.
    """
    seed: int | None = 0
    base: BasePlace | None = None
    """
    Place of the base of the robot; chosen by the reach of the arm if absent.
    """
    video: bool | None = False
    """
    Whether the archive has a video of the motion, `video.mp4`; only with `format=zip`.
    """


class ExecutionRequest2(Model):
    """
    Task of a robot, in words or as a document; one of `text` and `task`.
    """

    text: str | None = None
    """
    An instruction in words.
    """
    task: Task
    """
    A task as `GET /scenes/{scene_id}/tasks` gives it; it names its robot.
    """
    robot: str | None = "panda"
    """
    The robot of an instruction in words; a task names its own.
    """
    seed: int | None = 0
    base: BasePlace | None = None
    """
    Place of the base of the robot; chosen by the reach of the arm if absent.
    """
    video: bool | None = False
    """
    Whether the archive has a video of the motion, `video.mp4`; only with `format=zip`.
    """


class ExecutionRequest(RootModel[ExecutionRequest1 | ExecutionRequest2]):
    root: ExecutionRequest1 | ExecutionRequest2
    """
    Task of a robot, in words or as a document; one of `text` and `task`.
    """


class Fidelity(Model):
    """
    Similarity of the finished scene to the reference image from the same camera, as in `report.json`.
    """

    is_judged: bool | None = None
    """
    Whether the verdict depends on it; not where the program rendered the reference image. Absent in scenes of earlier
    versions, where it does.
    """
    silhouette_iou: float
    """
    A share.
    """
    color_difference: float | None
    """
    Mean CIELAB distance (CIE 1976) where both show the same object.
    """
    left_out_px: list[list[int]] | None = None
    """
    Boxes of what was found in the image and does not stand on the table. Absent where there is none.
    """
    depth: DepthAccount | None = None
    """
    Absent without a depth image.
    """
    missed: Regions
    invented: Regions
    methods: list[MethodShare]
    appearance: Appearance


class Goal(Model):
    """
    The goal of an instruction; the scene shows its start state.
    """

    instruction: str
    """
    The instruction as the text has it.
    """
    predicates: list[GoalPredicate]
    """
    All of them must hold at the end.
    """


class Input(Model):
    """
    The source of a scene; each kind has the fields that name it.
    """

    kind: Literal["text", "image", "edit", "variant"]
    """
    The source of the scene.
    """
    text: str | None = None
    """
    The text; of an image, the one beside it; of an edit, its instruction.
    """
    sha256: str | None = None
    """
    Of an image.
    """
    media_type: str | None = None
    """
    Of an image.
    """
    depth_sha256: str | None = None
    """
    Of an image with a depth image beside it: the digest of that.
    """
    parent: str | None = None
    """
    Of an edit or a variant: the id in the `scene.json` of the parent.
    """
    bundle_sha256: str | None = None
    """
    Of an edit or a variant: the archive of the parent.
    """
    operations: (
        list[
            AddOperation
            | RemoveOperation
            | ReplaceOperation
            | MoveOperation
            | RotateOperation
            | ResizeOperation
            | RecolorOperation
            | RelabelOperation
            | RestyleTableOperation
            | StackOperation
            | SwapOperation
            | ArrangeOperation
            | TidyOperation
            | ClutterOperation
            | RemakeOperation
            | RearrangeOperation
            | RelightOperation
            | SetPhysicsOperation1
            | SetPhysicsOperation2
            | MoveCameraOperation1
            | MoveCameraOperation2
            | MoveCameraOperation3
            | MoveCameraOperation4
        ]
        | None
    ) = None
    """
    Of an edit.
    """
    words: list[str] | None = None
    """
    Of an edit in words: the words that each operation comes from, in order.
    """
    asides: list[str] | None = None
    """
    Of an edit in words: those that ask for nothing.
    """
    randomize: Randomize | None = None
    """
    Of a variant.
    """


class InstructionEdit(Model):
    """
    An edit as an instruction in English words.
    """

    operations: None = Field(None)
    text: str
    """
    Description of the objects on the table; at least one letter or digit, and no control characters but tabs and line
    ends.
    """
    allow_quarantined: bool | None = False
    """
    Edit also a scene whose certificate says quarantine.
    """
    seed: int | None = None
    """
    Drawn and reported when absent.
    """
    labels: dict[str, str] | None = None
    """
    Pairs of words for the client's own use.
    """
    options: EditOptions | None = None
    priority: int | None = None
    """
    Orders the client's own jobs; 0 is usual, more is sooner. Waiting jobs overtake more urgent ones in the end.
    """
    not_before: AwareDatetime | None = None
    """
    The job starts no earlier.
    """
    deadline: AwareDatetime | None = None
    """
    The job fails if it has not ended by then; later than now and than `not_before`.
    """


class LineageEntry(Model):
    """
    A scene and what made it.
    """

    id: UUID
    parent: UUID | None
    state: Literal["pending", "ready", "failed", "deleted"]
    """
    Whether a scene can be used.
    """
    verdict: Literal["pass", "quarantine"] | None
    operations: (
        list[
            AddOperation
            | RemoveOperation
            | ReplaceOperation
            | MoveOperation
            | RotateOperation
            | ResizeOperation
            | RecolorOperation
            | RelabelOperation
            | RestyleTableOperation
            | StackOperation
            | SwapOperation
            | ArrangeOperation
            | TidyOperation
            | ClutterOperation
            | RemakeOperation
            | RearrangeOperation
            | RelightOperation
            | SetPhysicsOperation1
            | SetPhysicsOperation2
            | MoveCameraOperation1
            | MoveCameraOperation2
            | MoveCameraOperation3
            | MoveCameraOperation4
        ]
        | None
    )
    """
    Of an edit; null for other scenes.
    """
    randomize: Randomize | None
    """
    Of a variant; null for other scenes.
    """
    text: str | None
    """
    The instruction of an edit, or the text of the scene.
    """
    created_at: AwareDatetime
    """
    RFC 3339 in UTC with milliseconds.
    """
    stages: list[Stage] | None = None
    """
    Of the newest job of the scene that was asked for; `cached` says that a result was found.
    """


class OperationsEdit(Model):
    """
    An edit as a list of operations.
    """

    operations: list[
        AddOperation
        | RemoveOperation
        | ReplaceOperation
        | MoveOperation
        | RotateOperation
        | ResizeOperation
        | RecolorOperation
        | RelabelOperation
        | RestyleTableOperation
        | StackOperation
        | SwapOperation
        | ArrangeOperation
        | TidyOperation
        | ClutterOperation
        | RemakeOperation
        | RearrangeOperation
        | RelightOperation
        | SetPhysicsOperation1
        | SetPhysicsOperation2
        | MoveCameraOperation1
        | MoveCameraOperation2
        | MoveCameraOperation3
        | MoveCameraOperation4
    ]
    """
    Operations, carried out in order.
    """
    text: None = Field(None)
    allow_quarantined: bool | None = False
    """
    Edit also a scene whose certificate says quarantine.
    """
    seed: int | None = None
    """
    Drawn and reported when absent.
    """
    labels: dict[str, str] | None = None
    """
    Pairs of words for the client's own use.
    """
    options: EditOptions | None = None
    priority: int | None = None
    """
    Orders the client's own jobs; 0 is usual, more is sooner. Waiting jobs overtake more urgent ones in the end.
    """
    not_before: AwareDatetime | None = None
    """
    The job starts no earlier.
    """
    deadline: AwareDatetime | None = None
    """
    The job fails if it has not ended by then; later than now and than `not_before`.
    """


class Options(Model):
    """
    Options of each scene.
    """

    table: TableSpec | None = None
    """
    Overrides the choice of the table.
    """
    metric_anchor: MetricAnchor | None = None
    """
    A known length in the scene, which sets its scale.
    """
    max_objects: int | None = None
    """
    More objects are refused.
    """
    budget_usd: float | None = None
    """
    The most that calls of remote models may cost together; the server's usual budget when absent.
    """
    on_unknown: Literal["fail", "stand_in", "drop"] | None = None
    """
    Treatment of objects of the text that the catalog does not have.
    """
    robot: str | None = None
    """
    A robot that is tried in the finished scene, such as `panda`: its grasps of each object, what it can pick up, and
    tasks. Takes seconds for each object.
    """
    clutter: Clutter | None = None
    """
    Objects without a stated place are dropped onto each other, so that they lean, overlap and lie at random.
    """
    set: SceneSettings | None = None
    """
    Values of settings by name, in place of the server's.
    """


class ProposedTask(Model):
    """
    A feasible task by rules over shapes and affordances.
    """

    kind: Literal["in", "on", "stack", "next_to", "left_of", "right_of", "swap", "lift", "two_steps"]
    """
    Kind of a proposed task.
    """
    task: Task
    """
    With the default wording as its instruction.
    """
    wordings: Wordings
    difficulty: Difficulty


class Queue(Model):
    """
    Work of a tenant; for the operator, of all tenants.
    """

    paused: QueuePause | None
    """
    Null while workers take jobs.
    """
    kinds: list[QueueKind]
    """
    Kinds of which jobs wait or run.
    """
    workers: list[QueueWorker]
    """
    Workers that hold jobs, by name.
    """
    storage: Literal["ok", "full", "unavailable"]
    """
    Whether the database and the place of blobs take writes: `full` where the disk or a quota leaves no room.
    """


class Recording(Model):
    """
    Demonstrations of tasks in a scene, and the dataset that becomes of them.
    """

    id: UUID
    scene_id: UUID
    state: Literal["queued", "running", "finished", "failed", "cancelled"]
    """
    State of a recording of episodes; only `queued` and `running` are not final.
    """
    order: EpisodesSubmission
    progress: RecordingProgress
    attempts: dict[str, int]
    """
    Number of attempts by result, `success` or the reason of a failure.
    """
    failure: RecordingFailure | None
    dataset: RecordedDataset | None
    created_at: AwareDatetime
    """
    RFC 3339 in UTC with milliseconds.
    """
    started_at: AwareDatetime | None
    """
    RFC 3339 in UTC with milliseconds.
    """
    finished_at: AwareDatetime | None
    """
    RFC 3339 in UTC with milliseconds.
    """
    links: RecordingLinks


class RecordingEvent(Model):
    """
    Something that happened to a recording.
    """

    seq: int
    at: AwareDatetime
    """
    RFC 3339 in UTC with milliseconds.
    """
    kind: Literal["queued", "running", "attempt", "attempt_lost", "restarted", "assembling", "finished", "failed", "cancelled"]
    """
    A finished `attempt`, or a change of what is being done. `attempt_lost`: its episode is lost or damaged, and it is
    made again. `restarted`: all attempts so far were dropped, as a process of another version or machine goes on.
    `assembling`: no attempt is missing, and the dataset is written; it comes again after a lost attempt.
    """
    data: RecordingEventData


class RecordingEventPage(Model):
    """
    A page of events of a recording.
    """

    events: list[RecordingEvent]
    next_after: int
    """
    The `after` of the next page.
    """


class RecordingPage(Model):
    """
    A page of recordings.
    """

    recordings: list[Recording]
    next_page_token: str | None
    """
    Null on the last page.
    """


class SceneTasks(Model):
    """
    Proposed tasks of a robot in a scene.
    """

    robot: str
    seed: int
    own: Task | None
    """
    The task of the scene's own text, where it was an instruction.
    """
    instructed: Task | None = None
    """
    Task of the given instruction.
    """
    proposed: list[ProposedTask]
    """
    Empty where an instruction was given.
    """


class StoredRequest(Model):
    """
    The request as it is kept, with the seed that was drawn.
    """

    version: int
    """
    Version of the stored format.
    """
    input: Input
    seed: int
    """
    Selects one of many possible results.
    """
    options: Options


class TextAccount(Model):
    """
    Parts of a text that were understood, and parts that were not. Every word is part of it, but for a closed list of
    ignorable ones.
    """

    understood: list[Understood]
    """
    Parts of the text with a meaning, in the order of the text.
    """
    unrecognized: list[Unrecognized]
    """
    Parts of the text without effect, in the order of the text.
    """
    goal: Goal | None
    """
    The goal of an instruction; the scene shows its start state.
    """
    stand_ins: list[str]
    """
    Objects that the catalog does not have: those that have the mark of a stand-in.
    """
    fillings: list[str]
    """
    Objects that the text does not name; the theme added them.
    """
    unmet: list[Unmet] | None = None
    """
    Demands of the text that the layout does not meet; empty before a layout exists, and where it is not known.
    """
    of_scene: str | None = None
    """
    Id of the scene that was made from the text, in its `scene.json`, where this scene is an edit of it.
    """
    changed: list[ChangedPart] | None = None
    """
    Parts of the text of which edits changed some or all, in the order of the text. `understood` has only what is left
    of their meaning.
    """


class TextSubmission(Model):
    """
    A scene from a text.
    """

    text: str
    """
    Description of the objects on the table; beside an image, of its content, with counts, colors, materials, lengths
    and masses. There it provides labels and properties of the objects that are found; the image decides about the table
    and all places.
    """
    image: None = Field(None)
    seed: int | None = None
    """
    Drawn and reported when absent.
    """
    labels: dict[str, str] | None = None
    """
    Pairs of words for the client's own use.
    """
    options: Options | None = None
    priority: int | None = None
    """
    Orders the client's own jobs; 0 is usual, more is sooner. Waiting jobs overtake more urgent ones in the end.
    """
    not_before: AwareDatetime | None = None
    """
    The job starts no earlier.
    """
    deadline: AwareDatetime | None = None
    """
    The job fails if it has not ended by then; later than now and than `not_before`.
    """


class Validated(Model):
    """
    The request as it is understood.
    """

    valid: Literal[True]
    request: StoredRequest
    text: TextAccount | None
    """
    The account of the text; null without a text, and where a remote model reads texts. Beside an image it is an account
    before the image is recognized.
    """


class ValidatedEdit(Model):
    """
    The edit as it is understood.
    """

    valid: Literal[True]
    request: StoredRequest
    prediction: EditPrediction | None
    """
    Places and collisions of the result; null where nothing is predicted.
    """


class ValidatedVariants(Model):
    """
    The requests of the variants as they are understood.
    """

    valid: Literal[True]
    requests: list[StoredRequest]


class VariantsSubmission(Model):
    """
    Number of variants, and the differences between them.
    """

    count: int | None = 1
    randomize: Randomize | None = None
    """
    Differences; everything where it is absent or names nothing.
    """
    allow_quarantined: bool | None = False
    """
    Whether the parent may be a scene whose certificate says quarantine.
    """
    seed: int | None = None
    """
    Drawn and reported when absent.
    """
    labels: dict[str, str] | None = None
    """
    Pairs of words for the client's own use.
    """
    options: EditOptions | None = None
    priority: int | None = None
    """
    Orders the client's own jobs; 0 is usual, more is sooner. Waiting jobs overtake more urgent ones in the end.
    """
    not_before: AwareDatetime | None = None
    """
    The job starts no earlier.
    """
    deadline: AwareDatetime | None = None
    """
    The job fails if it has not ended by then; later than now and than `not_before`.
    """


class BatchRecipe(Model):
    """
    Templates with slots in braces, times the values of the slots, times seeds, times options. Seeds vary fastest, then
    options, then slots from the last to the first, then templates.
    """

    templates: list[str]
    slots: dict[str, list[str]] | None = None
    """
    Values of each slot; every slot that a template uses has at least one.
    """
    seeds: SeedRange | list[int] | None = None
    """
    One seed, derived from the text, when absent.
    """
    options: Options | list[Options] | None = None
    labels: dict[str, str] | None = None
    """
    Pairs of words for the client's own use.
    """
    select: RecipeProduct | RecipeSample | None = None


class BatchRequestBody(Model):
    """
    A scene from a text. Without a seed it has one that depends on the rest alone.
    """

    text: str
    """
    Description of the objects on the table; at least one letter or digit, and no control characters but tabs and line
    ends.
    """
    seed: int | None = None
    """
    Drawn and reported when absent.
    """
    labels: dict[str, str] | None = None
    """
    Pairs of words for the client's own use.
    """
    options: Options | None = None


class BatchRequestLine(Model):
    """
    A line of the body of a batch.
    """

    custom_id: str
    """
    Unique in its batch.
    """
    body: BatchRequestBody


class EditSubmission(RootModel[OperationsEdit | InstructionEdit]):
    root: OperationsEdit | InstructionEdit
    """
    Exactly one of `operations` and `text` states the change.
    """


class Event(Model):
    """
    Something that happened to a job.
    """

    seq: int
    at: AwareDatetime
    """
    RFC 3339 in UTC with milliseconds.
    """
    kind: Literal[
        "job_queued",
        "job_started",
        "stage_started",
        "stage_progress",
        "stage_finished",
        "job_retrying",
        "job_orphaned",
        "job_released",
        "job_cancelling",
        "job_cancelled",
        "job_failed",
        "job_succeeded",
    ]
    """
    Kind of an event of a job.
    """
    data: EventData


class EventPage(Model):
    """
    A page of events of a job.
    """

    events: list[Event]
    next_after: int
    """
    The `after` of the next page.
    """


class ExecutedTask(Model):
    """
    A task, what became of it, and the motion.
    """

    task: Task
    seed: int
    execution: Execution
    trajectory: Trajectory


class FormRequest(Model):
    """
    Request beside the file.
    """

    text: str | None = None
    """
    Description of the objects on the table; beside an image, of its content, with counts, colors, materials, lengths
    and masses. There it provides labels and properties of the objects that are found; the image decides about the table
    and all places.
    """
    image: None = Field(None)
    seed: int | None = None
    """
    Drawn and reported when absent.
    """
    labels: dict[str, str] | None = None
    """
    Pairs of words for the client's own use.
    """
    options: Options | None = None
    priority: int | None = None
    """
    Orders the client's own jobs; 0 is usual, more is sooner. Waiting jobs overtake more urgent ones in the end.
    """
    not_before: AwareDatetime | None = None
    """
    The job starts no earlier.
    """
    deadline: AwareDatetime | None = None
    """
    The job fails if it has not ended by then; later than now and than `not_before`.
    """


class ImageSubmission(Model):
    """
    A scene from an image.
    """

    text: str | None = None
    """
    Description of the objects on the table; beside an image, of its content, with counts, colors, materials, lengths
    and masses. There it provides labels and properties of the objects that are found; the image decides about the table
    and all places.
    """
    image: ImageBytes | ImageUrl
    """
    Bytes of an image, or its URL.
    """
    seed: int | None = None
    """
    Drawn and reported when absent.
    """
    labels: dict[str, str] | None = None
    """
    Pairs of words for the client's own use.
    """
    options: Options | None = None
    priority: int | None = None
    """
    Orders the client's own jobs; 0 is usual, more is sooner. Waiting jobs overtake more urgent ones in the end.
    """
    not_before: AwareDatetime | None = None
    """
    The job starts no earlier.
    """
    deadline: AwareDatetime | None = None
    """
    The job fails if it has not ended by then; later than now and than `not_before`.
    """


class Lineage(Model):
    """
    A scene between those that it was made from and those that were made from it.
    """

    ancestors: list[LineageEntry]
    """
    Oldest first, deleted scenes too; of a longer chain the nearest 1,000.
    """
    scene: LineageEntry
    children: list[LineageEntry]
    """
    Newest first, at most 200; `GET /scenes` with `parent` has pages of all.
    """


class SceneForm(Model):
    """
    A scene from an image file.
    """

    image: bytes
    """
    A PNG, JPEG or WebP file that does not move; its first bytes decide, not its name.
    """
    depth: bytes | None = None
    """
    A PNG file of one 16-bit channel with the depth of each pixel of the upright image along the optical axis,
    millimeters; 0 = not measured. It has the ratio of the sides of the image. The settings of the request state the
    camera: `photograph.intrinsics_px`, or `photograph.field_of_view_rad` where the EXIF data do not.
    """
    request: FormRequest | None = None


class SceneSubmission(RootModel[TextSubmission | ImageSubmission]):
    root: TextSubmission | ImageSubmission
    """
    The source of a scene is exactly one of `text` and `image`. Beside an image, a text names what is in it. An image as
    a file comes in a form.
    """


class Summary(Model):
    """
    Summary of a finished scene.
    """

    bundle_id: str | None = None
    """
    The id of the scene in its bundle (`id` of `scene.json`), a digest of what it was made from.
    """
    objects: int | None = None
    """
    Number of objects.
    """
    categories: list[str] | None = None
    """
    Categories of the objects, each once, in order. Absent in scenes of earlier versions.
    """
    table: str | None = None
    """
    Label of the table.
    """
    verdict_text: str | None = None
    """
    The verdict in words, with the number of stand-ins.
    """
    text: TextAccount | None = None
    """
    The account of the text; null for an image. That of an edited scene has what still holds.
    """
    edit: EditAccount | None = None
    """
    Result of the edit; null for other scenes.
    """
    fidelity: Fidelity | None = None
    resolve: list[str] | None = None
    """
    Changes made by the stage `resolve`.
    """
    gave_way: list[Relaxation] | None = None
    """
    Objects that were made smaller or moved for lack of space.
    """
    robot: RobotFinding | None = None


class TenantEvent(Model):
    """
    Something that happened to a job or a recording.
    """

    seq: int
    """
    Ascending over all jobs and recordings, with gaps.
    """
    number: int
    """
    The `seq` within the job or the recording.
    """
    at: AwareDatetime
    """
    RFC 3339 in UTC with milliseconds.
    """
    kind: (
        Literal[
            "job_queued",
            "job_started",
            "stage_started",
            "stage_progress",
            "stage_finished",
            "job_retrying",
            "job_orphaned",
            "job_released",
            "job_cancelling",
            "job_cancelled",
            "job_failed",
            "job_succeeded",
        ]
        | Literal["queued", "running", "attempt", "attempt_lost", "restarted", "assembling", "finished", "failed", "cancelled"]
    )
    """
    Kind of an event of a job or of a recording.
    """
    job_id: UUID | None
    """
    The job; null for an event of a recording itself.
    """
    job_kind: (
        Literal["generate", "retry", "freeze_dataset", "verify_dataset", "record_attempt", "assemble_recording", "execute_task"] | None
    )
    scene_id: UUID | None
    dataset_id: UUID | None
    recording_id: UUID | None
    data: EventData | RecordingEventData
    """
    Subject of the event, as the events of its job or its recording have it.
    """


class TenantEventPage(Model):
    """
    A page of events of a tenant.
    """

    events: list[TenantEvent]
    next_after: int
    """
    The `after` of the next page.
    """


class Scene(Model):
    """
    A scene and its newest job.
    """

    id: UUID
    state: Literal["pending", "ready", "failed", "deleted"]
    """
    Whether a scene can be used.
    """
    verdict: Literal["pass", "quarantine"] | None
    failure: Failure | None
    parent: UUID | None
    seed: int
    request: StoredRequest
    labels: dict[str, str]
    """
    Pairs of words for the client's own use.
    """
    metrics: Metrics | None
    summary: Summary | None
    created_at: AwareDatetime
    """
    RFC 3339 in UTC with milliseconds.
    """
    updated_at: AwareDatetime
    """
    RFC 3339 in UTC with milliseconds.
    """
    job: Job | None
    stages: list[Stage] | None = None
    """
    Only when one scene is asked for.
    """
    artifacts: list[Artifact] | None = None
    """
    Only when one scene is asked for.
    """
    spending: Spending | None = None
    links: SceneLinks


class ScenePage(Model):
    """
    A page of scenes.
    """

    scenes: list[Scene]
    next_page_token: str | None
    """
    Null on the last page.
    """
