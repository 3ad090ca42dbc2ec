"""Keys and cookies, right ones and wrong ones, wherever a client may put them; then everything that a server writes or
answers is searched for them, and for those of the other parts."""

import json
import time

from tabletopgen_checks.bars.reliability.bench import STORES
from tabletopgen_checks.bars.reliability.part import Finding
from tabletopgen_checks.bars.reliability.scenes import SMALL, request_of
from tabletopgen_checks.bars.tenants.bench import command
from tabletopgen_checks.bars.tenants.collector import Collector
from tabletopgen_checks.bars.tenants.secrets import cookie_of
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.processes import output_of

# As talkative as it can be.
SETTINGS = {"log.filter": "trace", "log.format": "json", "telemetry.sample_ratio": "1.0"}
MADE_UP = "tt_{}0123456789abcdefghijklmnopqrstuvwxyzABCD"


def measure(bench) -> Finding:
    for store in bench.stores():
        with Collector() as collector:
            settings = SMALL | SETTINGS | {"telemetry.traces_endpoint": collector.endpoint}
            with bench.keyed(store, f"secrets-{store}", settings) as service:
                mark = use(bench, service)
                # Spans leave every five seconds.
                time.sleep(6)
                bench.secrets.search("traces", b"\0".join(collector.received), "/scenes/{scene_id}")
                search_outputs(bench, service, mark)
    found = sorted(set(bench.secrets.found))
    rows = [[place, size, sum(line.endswith(f"in the {place}") for line in found)] for place, size in sorted(bench.secrets.read.items())]
    words = (
        f"{len(bench.secrets.known)} secrets of all parts, as they are, escaped, and in base64. Most places have a mark that had to "
        "be found there, too, such as the id of a key. The log has the level `trace`. Wrong keys were given in headers, cookies, queries, "
        "bodies and paths; the logs and rows of the other parts were searched before they went."
    )
    words = "\n\n".join([words, *(f"- {line}" for line in found[:20])])
    return Finding(["place", "bytes searched", "secrets found"], rows, not found, words, full=len(bench.stores()) == len(STORES))


def use(bench, service) -> str:
    """Secrets wherever a client can put them; scenes, streams, refusals. The id of a key that was made over HTTP."""
    secrets, admin = bench.secrets, bench.client(service)
    problems, streams = [], []

    def ask(method, path, body=None, headers=None, expect=None):
        content = None if body is None else body if isinstance(body, bytes) else json.dumps(body).encode()
        usual = {} if content is None else {"content-type": "application/json"}
        status, answered, content = service.api.request(method, path, content, {**usual, **(headers or {})})
        if expect is not None and status != expect:
            raise Problem(f"{method} {path} was answered with {status}: {content[:300]!r}")
        if status >= 400:
            problems.append(content)
        return answered, content

    own = admin.credential()
    _, made = ask("POST", "/keys", {"name": "over HTTP", "scopes": ["read", "submit"]}, own, 201)
    made = json.loads(made)
    secrets.add("key made over HTTP", made["key"])
    headers, _ = ask("POST", "/session", {"key": made["key"]}, expect=204)
    session = {"cookie": f"tt_session={secrets.add('cookie of a session', cookie_of(headers))}"}
    text, seed = request_of(0)
    _, scene = ask("POST", "/scenes", {"text": text, "seed": seed}, session, 202)
    scene = json.loads(scene)
    streams += [json.dumps(event).encode() for event in admin.events(scene["job"]["id"])]
    ask("GET", f"/scenes/{scene['id']}", headers=session, expect=200)

    def wrong(kind):
        return secrets.add(f"wrong key in a {kind}", MADE_UP.format(kind[:6]))

    ask("GET", "/scenes", headers={"authorization": f"Bearer {wrong('header')}"}, expect=401)
    ask("GET", "/scenes", headers={"cookie": f"tt_session={wrong('cookie')}"}, expect=401)
    for key in (wrong("query"), made["key"]):
        ask("GET", f"/scenes?key={key}", headers=own)
        ask("GET", f"/keys/{key}", headers=own)
        ask("DELETE", f"/keys/{key}", headers=own)
        ask("DELETE", f"/keys/{key}")
        ask("GET", f"/{key}", headers=own)
        ask("POST", "/session", {key: 1}, expect=422)
        ask("POST", "/session", {"key": key, "more": key}, expect=422)
        ask("POST", "/session", json.dumps(key).encode(), expect=422)
    ask("POST", "/session", {"key": wrong("login")}, expect=401)
    ask("GET", "/keys", headers=session, expect=403)
    ask("DELETE", f"/keys/{made['id']}", headers=own, expect=204)
    ask("GET", "/scenes", headers=session, expect=401)
    secrets.search("problem documents", b"\0".join(problems), "credential_invalid")
    secrets.search("event streams", b"\0".join(streams), "job_succeeded")
    return made["id"]


def search_outputs(bench, service, mark: str):
    """What the server answers and its commands print about itself."""
    secrets, reader = bench.secrets, bench.client(service, scopes="read,operate,admin")
    for place, path, seen in (
        ("lists of keys", "/keys", mark),
        ("audit over HTTP", "/audit?page_size=200", mark),
        ("lines of the audit over HTTP", "/audit/lines", mark),
        ("metrics", "/metrics", "tabletopgen_http_requests_total"),
        ("contract", "/openapi.yaml", "createKey"),
    ):
        status, _, content = reader.request("GET", path)
        if status != 200:
            raise Problem(f"GET {path} was answered with {status}: {content[:200]!r}")
        secrets.search(place, content, seen)
    secrets.search("audit by the command", command(service, "audit", "--json").encode(), mark)
    secrets.search("keys by the command", command(service, "keys", "list", "--json").encode(), mark)
    secrets.search("log of the server", b"\0".join(log.read_bytes() for log in service.folder.glob("*.log")), mark)
    if service.store == "sqlite":
        backup = service.folder / "backup"
        said = command(service, "backup", backup)
        secrets.search("words of the backup", said.encode())
        secrets.search_files("files of the backup", backup, mark=mark)
        secrets.search("words of the verification", output_of(bench.binary, "restore", "--verify", backup).encode())
