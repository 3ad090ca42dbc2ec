"""Webhooks to a receiver that fails, hangs, redirects inside, answers too much, and then accepts: every event arrives,
once, signed as Standard Webhooks says, and nothing inside is reached."""

import json
import time
from collections import Counter

from tabletopgen_checks.bars.reliability.bench import STORES
from tabletopgen_checks.bars.reliability.part import Finding, yes
from tabletopgen_checks.bars.reliability.scenes import SMALL, request_of
from tabletopgen_checks.bars.tenants.secrets import DATABASES
from tabletopgen_checks.bars.tenants.vendor import RefusingVendor
from tabletopgen_checks.webhook_receiver import Answer, WebhookReceiver, verified

EVENTS, OF_EACH_WAY, BIG_BYTES = 20, 5, 10 << 20
TIMEOUT_SECS, PAUSE_SECS, PATIENCE_SECONDS = 1, 0.2, 120


def bad_answers(inside: str) -> list:
    """Five of each way in which a receiver may misbehave."""
    fails, hangs = Answer(500), Answer(500, after_s=3.0 * TIMEOUT_SECS)
    redirects, talks = Answer(307, location=inside), Answer(500, size_bytes=BIG_BYTES)
    return [answer for answer in (fails, hangs, redirects, talks) for _ in range(OF_EACH_WAY)]


def measure(bench) -> Finding:
    rows, held = [], True
    for store in bench.stores():
        with WebhookReceiver() as inside, RefusingVendor() as vendor, WebhookReceiver(bad_answers(inside.url)) as receiver:
            # A delivery may meet all bad answers, one after the other.
            pauses = ", ".join([str(PAUSE_SECS)] * (2 * len(receiver.answers)))
            sets = dict(word.split("=", 1) for word in receiver.settings(pauses, TIMEOUT_SECS)[1::2])
            bad = len(receiver.answers)
            with bench.keyed(store, f"webhooks-{store}", SMALL | vendor.settings() | sets) as service:
                secret, wanted = deliver(bench, bench.client(service), receiver, bad, inside)
            found = account(bench, receiver.received, bad, secret, wanted, len(inside.received))
        rows += [[store, what, value, promised, yes(holds)] for what, value, promised, holds in found]
        held &= all(holds for *_, holds in found)
    words = (
        f"{EVENTS} jobs end. The receiver answers {OF_EACH_WAY} times each with 500, not within {TIMEOUT_SECS} s, with 307 to an address "
        f"inside, and with {BIG_BYTES >> 20} MiB; then it accepts. Pauses between attempts are {PAUSE_SECS} s. PyPI `standardwebhooks` "
        "verifies all messages, those of attempts that failed, too."
    )
    return Finding(["store", "", "found", "promised", ""], rows, held, words, full=len(bench.stores()) == len(STORES))


def deliver(bench, client, receiver: WebhookReceiver, bad: int, inside: WebhookReceiver) -> tuple:
    """The secret of the webhook, and the scenes that have ended."""
    made = client.json("POST", "/webhooks", {"url": receiver.url}, expect=(201,))
    secret = bench.secrets.add("secret of a webhook", made["secret"], DATABASES)
    # An address inside is refused now, or when it is to be reached.
    body = json.dumps({"url": inside.url}).encode()
    client.request("POST", "/webhooks", body, {"content-type": "application/json"})
    text, _ = request_of(0)
    wanted = [client.submit_text(text, seed)["id"] for seed in range(EVENTS)]
    receiver.wait(bad + EVENTS, PATIENCE_SECONDS)
    # What would come once more comes now.
    time.sleep(3 * TIMEOUT_SECS)
    return secret, wanted


def account(bench, received: list, bad: int, secret: str, wanted: list, inside: int) -> list:
    """What was found of each promise: (what, value, promised, whether it holds)."""
    events = Counter(scene for one in received[bad:] for scene in wanted if scene in one.body)
    missing, repeated = sum(not events[scene] for scene in wanted), sum(count > 1 for count in events.values())
    faults = [one["fault"] for one in verified(received, secret, bench.given.target_dir) if "fault" in one]
    if faults:
        print(f"signatures: {faults[:5]}", flush=True)
    attempts = bad + len(wanted)
    return [
        ("events that did not arrive", missing, 0, missing == 0),
        ("events that were accepted more than once", repeated, 0, repeated == 0),
        ("attempts", len(received), attempts, len(received) == attempts),
        ("requests that reached an address inside", inside, 0, inside == 0),
        ("messages whose signature is wrong", len(faults), 0, not faults),
    ]
