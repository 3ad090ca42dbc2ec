"""Webhooks to a receiver that fails, hangs, redirects inside and answers too much, and then accepts: every event arrives,
once, signed as Standard Webhooks says, and nothing inside is reached."""

import json
import subprocess
import time
from collections import Counter

from tabletopgen_checks.bars.reliability.bench import STORES
from tabletopgen_checks.bars.reliability.part import Finding, yes
from tabletopgen_checks.bars.reliability.scenes import SMALL, request_of
from tabletopgen_checks.bars.tenants.receiver import BAD_WAYS, Receiver
from tabletopgen_checks.bars.tenants.secrets import DATABASES
from tabletopgen_checks.bars.tenants.vendor import RefusingVendor
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.virtual_environment import environment_of

PINS = ["standardwebhooks==1.1.0"]
EVENTS_OF_A_WAY, WAY_SECONDS, PATIENCE_SECONDS = 5, 4, 120
TIMEOUT_SECS, PAUSE_SECS, PAUSES = 1, 0.25, 60
# The library wants timestamps of the last five minutes.
VERIFY = """
import json, sys
from standardwebhooks import Webhook
wrong = 0
for line in sys.stdin:
    message = json.loads(line)
    try:
        Webhook(message["secret"]).verify(message["body"], message["headers"])
        print("verified")
    except Exception as error:
        print(repr(error))
"""


def measure(bench) -> Finding:
    rows, held = [], True
    for store in bench.stores():
        with Receiver() as receiver, RefusingVendor() as vendor:
            settings = {
                "webhooks.hosts": receiver.host,
                "webhooks.timeout_secs": str(TIMEOUT_SECS),
                "webhooks.retry_secs": ",".join([str(PAUSE_SECS)] * PAUSES),
            }
            with bench.keyed(store, f"webhooks-{store}", SMALL | vendor.settings() | settings) as service:
                client = bench.client(service)
                secret, wanted = deliver(bench, client, receiver)
            found = account(bench, receiver, secret, wanted)
        rows += [[store, what, value, promised, yes(holds)] for what, value, promised, holds in found]
        held &= all(holds for *_, holds in found)
    words = (
        f"{EVENTS_OF_A_WAY} scenes end while the receiver {', '.join(BAD_WAYS)}, for {WAY_SECONDS} s each, and then it accepts. "
        f"`webhooks.timeout_secs` is {TIMEOUT_SECS}, the pauses between attempts are {PAUSE_SECS} s. Signatures are verified by PyPI "
        f"`{PINS[0]}`, those of the attempts that failed, too."
    )
    return Finding(["store", "", "found", "promised", ""], rows, held, words, full=len(bench.stores()) == len(STORES))


def deliver(bench, client, receiver: Receiver) -> tuple:
    """The secret of the webhook, and the scenes that have ended."""
    made = client.json("POST", "/webhooks", {"url": f"http://{receiver.host}/hook", "events": []}, expect=(201,))
    secret = bench.secrets.add("secret of a webhook", made["secret"], DATABASES)
    # An address inside is refused now, or when it is to be reached.
    client.request(
        "POST", "/webhooks", json.dumps({"url": f"http://{receiver.hidden_host}/inside"}).encode(), {"content-type": "application/json"}
    )
    text, wanted = request_of(0)[0], []
    for way, name in enumerate(BAD_WAYS):
        receiver.way = name
        for k in range(EVENTS_OF_A_WAY):
            wanted.append(client.submit_text(text, 1 + EVENTS_OF_A_WAY * way + k)["id"])
        time.sleep(WAY_SECONDS)
    receiver.way = "accepts"
    deadline = time.monotonic() + PATIENCE_SECONDS
    while len(accepted(receiver)) < len(wanted) and time.monotonic() < deadline:
        time.sleep(0.5)
    # What would come twice comes now.
    time.sleep(2 * TIMEOUT_SECS)
    return secret, wanted


def accepted(receiver: Receiver) -> set:
    return {one["headers"]["webhook-id"] for one in receiver.messages if one["way"] == "accepts"}


def account(bench, receiver: Receiver, secret: str, wanted: list) -> list:
    """What was found of each promise: (what, value, promised, whether it holds)."""
    taken = [one for one in receiver.messages if one["way"] == "accepts"]
    events = Counter(scene for one in taken for scene in wanted if scene in one["body"])
    ways = Counter(one["way"] for one in receiver.messages)
    bounds = {way: len(BAD_WAYS) * int(WAY_SECONDS / PAUSE_SECS) for way in BAD_WAYS}
    verdicts = Counter(verify(bench, secret, receiver.messages))
    missing, repeated = [one for one in wanted if not events[one]], [one for one, count in events.items() if count > 1]
    rows = [
        ("events that did not arrive", len(missing), 0, not missing),
        ("events accepted more than once", len(repeated), 0, not repeated),
        ("requests that reached an address inside", receiver.inside, 0, receiver.inside == 0),
        ("messages whose signature is wrong", len(receiver.messages) - verdicts["verified"], 0, set(verdicts) == {"verified"}),
    ]
    rows += [(f"attempts while it {way}", ways[way], f"1 to {bounds[way]}", 1 <= ways[way] <= bounds[way]) for way in BAD_WAYS]
    if len(verdicts) > 1:
        print(f"signatures: {dict(verdicts)}", flush=True)
    return rows


def verify(bench, secret: str, messages: list) -> list:
    """What the library says of each message."""
    python = environment_of(bench.given.target_dir, "standardwebhooks", PINS) / "bin/python"
    lines = "".join(json.dumps({"secret": secret, **one}) + "\n" for one in messages)
    done = subprocess.run([python, "-c", VERIFY], input=lines, capture_output=True, text=True)
    if done.returncode != 0:
        raise Problem(f"the library of Standard Webhooks failed: {done.stderr[-1000:]}")
    return done.stdout.split("\n")[:-1]
