"""Hostile clients against a server with its default settings: what honest clients notice, what memory it takes, when
they are closed.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.overload [--target-dir target] [--program PATH]

Six attacks, one after the other: a thousand headers that do not end, a thousand clients that ask for megabytes and read
nothing, a thousand event streams, six hundred bodies that do not end, bodies of nested lists of the largest size, and
again a thousand non-readers against a server of 64 connections. During each, two honest clients ask for scenes and
check texts on new connections, at a steady pace. All clients have the same address. Promised: the honest p99 stays
under twice the idle one (or under 20 ms, as short answers on two cores scatter), every honest request is answered,
memory stays under the cap, and every hostile connection is closed within its limit.
"""

import asyncio
import http.client
import json
import multiprocessing
import os
import resource
import select
import shutil
import socket
import time
from pathlib import Path

from tabletopgen_checks.bars.page import arguments, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.service.server import Server

DEPENDS_ON = ("config/default.toml", "src/api", "src/api.rs", "src/service", "src/service.rs")
THOUSAND, BODIES, NESTED = 1000, 600, 8
HONEST_PER_S, HONEST_SECONDS = 20, 12
# The largest body is 28 MiB; bodies in flight may take 256 MiB (server.body_memory_bytes).
NESTED_BYTES, MEMORY_CAP_BYTES = 28 << 20, 512 << 20
P99_FACTOR, P99_FLOOR_S = 2.0, 0.020
# Shorter than the defaults of 15 minutes and 60 s, so that a run takes minutes.
STREAM_SECONDS = 20
SETTINGS = {
    "server.max_event_stream_secs": STREAM_SECONDS,
    "server.keep_alive_timeout_secs": STREAM_SECONDS,
    "store.fsync": "false",
}
# A model that accepts connections and never answers: jobs stay as they are and compute nothing.
SILENT = {"providers.analyst": "chat", "providers.allow_http": "true", "providers.private_hosts": "127.0.0.1"}
# Seconds: the setting, and what the reaper and a busy machine may add.
HEADER_LIMIT, RATE_LIMIT, SLACK = 10, 10, 4
HEAD = "{method} {path} HTTP/1.1\r\nhost: localhost\r\n"
HALF_HEADER = HEAD.format(method="GET", path="/healthz") + "x-slow: "
BIG_ANSWERS = (HEAD.format(method="GET", path="/openapi.yaml") + "\r\n") * 100
HALF_BODY = HEAD.format(method="POST", path="/scenes") + (
    "content-type: application/json\r\ncontent-length: 29000000\r\n\r\n" + '{"text": "' + "x" * 60_000
)


class Attack:
    """Sockets that send one text and then neither send nor read."""

    def __init__(self, text: str, count: int):
        self.text, self.count = text.encode(), count
        self.sockets, self.closed, self.refused = [], {}, 0

    async def open(self, port: int):
        loop = asyncio.get_running_loop()
        for _ in range(self.count):
            sock = socket.socket()
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            sock.setblocking(False)
            try:
                await asyncio.wait_for(loop.sock_connect(sock, ("127.0.0.1", port)), 10)
                await asyncio.wait_for(loop.sock_sendall(sock, self.text), 10)
            except (TimeoutError, OSError):
                # Closed before everything was sent, which is an end as well.
                self.refused += 1
            self.sockets.append((sock, time.monotonic()))

    async def watch(self, limit: float):
        """Until the server has closed all, or the last one is older than the limit."""
        poll, open_since = select.poll(), {}
        while True:
            for sock, began in self.sockets[len(open_since) :]:
                open_since[sock.fileno()] = began
                poll.register(sock.fileno(), select.POLLRDHUP | select.POLLHUP | select.POLLERR)
            for descriptor, _ in poll.poll(0):
                self.closed[descriptor] = time.monotonic() - open_since[descriptor]
                poll.unregister(descriptor)
            last = self.sockets[-1][1] if self.sockets else time.monotonic()
            if len(self.closed) == self.count or time.monotonic() > last + limit:
                return
            await asyncio.sleep(0.1)

    def end(self):
        for sock, _ in self.sockets:
            sock.close()


class Honest:
    """Requests at a steady pace, each on a connection of its own."""

    def __init__(self, port: int, scene: str):
        self.port, self.scene = port, scene
        self.seconds, self.failures = [], []

    async def run(self, seconds: float):
        tasks, began = [], time.monotonic()
        for k in range(int(seconds * HONEST_PER_S)):
            await asyncio.sleep(max(0.0, began + k / HONEST_PER_S - time.monotonic()))
            tasks.append(asyncio.create_task(self.ask(k)))
        await asyncio.gather(*tasks)

    async def ask(self, k: int):
        body = json.dumps({"text": "a mug and two plates", "seed": k}).encode()
        if k % 2:
            head, body = HEAD.format(method="GET", path=f"/scenes/{self.scene}"), b""
        else:
            head = HEAD.format(method="POST", path="/scenes/validate")
            head += f"content-type: application/json\r\ncontent-length: {len(body)}\r\n"
        began = time.monotonic()
        try:
            answer = await asyncio.wait_for(self.exchange(head.encode() + b"connection: close\r\n\r\n" + body), 30)
        except (TimeoutError, OSError) as error:
            self.failures.append(str(error) or type(error).__name__)
            return
        self.seconds.append(time.monotonic() - began)
        if not answer.startswith(b"HTTP/1.1 200"):
            self.failures.append(answer[:60].decode("latin-1"))

    async def exchange(self, request: bytes) -> bytes:
        reader, writer = await asyncio.open_connection("127.0.0.1", self.port)
        try:
            writer.write(request)
            await writer.drain()
            return await reader.read(-1)
        finally:
            writer.close()

    def p(self, share: float) -> float:
        ordered = sorted(self.seconds)
        return ordered[min(len(ordered) - 1, int(share * len(ordered)))] if ordered else float("inf")


class Memory:
    """Peak of the resident memory of a process since the last reset, bytes."""

    def __init__(self, pid: int):
        self.place = Path("/proc") / str(pid)

    def reset(self):
        try:
            (self.place / "clear_refs").write_text("5")
        except OSError as error:
            raise Problem(f"the peak of the server's memory cannot be reset: {error.strerror}") from error

    def peak(self) -> int:
        for line in (self.place / "status").read_text().splitlines():
            if line.startswith("VmHWM"):
                return int(line.split()[1]) << 10
        raise Problem("the system does not tell the peak of a process's memory")


def send_nested(port: int, answers: multiprocessing.Queue):
    """One body of nested lists, from a process of its own: to send it takes as long as to refuse it.

    A client of another machine would not take the server's cores, so this one comes last for them."""
    os.nice(19)
    body = b"[" * (NESTED_BYTES // 2) + b"]" * (NESTED_BYTES // 2)
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
    try:
        connection.request("POST", "/scenes", body, {"content-type": "application/json"})
        answers.put(str(connection.getresponse().status))
    except (OSError, http.client.HTTPException) as error:
        answers.put(str(error) or type(error).__name__)


async def attacked(server: Server, scene: str, attack, limit: float):
    """(honest client, attack) after the attack."""
    honest = Honest(server.port, scene)
    if attack is None:
        await honest.run(HONEST_SECONDS)
        return honest
    await asyncio.gather(attack.open(server.port), honest.run(HONEST_SECONDS), attack.watch(limit + SLACK))
    attack.end()
    return honest


def main() -> bool:
    given = arguments(__doc__, program="")
    binary = Path(given.program) if given.program else given.binary
    folder = given.work / "overload"
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "data").mkdir(parents=True)
    rows, held = [], True
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, min(hard, 4096)), hard))
    silent = socket.create_server(("127.0.0.1", 0))
    with Server(binary, folder / "data", folder / "log", arguments=settings(silent)) as server:
        memory = Memory(server.pid)
        created = server.submit_text("a mug", seed=1)
        scene, job = created["id"], created["job"]["id"]
        streams = HEAD.format(method="GET", path=f"/jobs/{job}/events") + "accept: text/event-stream\r\n\r\n"
        idle = asyncio.run(attacked(server, scene, None, 0))
        promised = max(P99_FACTOR * idle.p(0.99), P99_FLOOR_S)
        rows.append(["none", 0, *times(idle), len(idle.failures), megabytes(memory.peak()), "-", "-"])
        for name, attack, limit in (
            ("headers that do not end", Attack(HALF_HEADER, THOUSAND), HEADER_LIMIT),
            ("clients that do not read", Attack(BIG_ANSWERS, THOUSAND), RATE_LIMIT),
            ("event streams", Attack(streams, THOUSAND), STREAM_SECONDS),
            ("bodies that do not end", Attack(HALF_BODY, BODIES), RATE_LIMIT),
        ):
            memory.reset()
            honest = asyncio.run(attacked(server, scene, attack, limit))
            closed = max(attack.closed.values(), default=float("inf"))
            all_closed = len(attack.closed) == attack.count
            rows.append(
                [name, attack.count, *times(honest), len(honest.failures), megabytes(memory.peak())]
                + [f"{len(attack.closed)}, the last after {closed:.1f} s", f"{limit} s"]
            )
            good = honest.p(0.99) < promised and not honest.failures and all_closed and closed < limit + SLACK
            held &= good and memory.peak() < MEMORY_CAP_BYTES
            complain(name, good, honest)
        memory.reset()
        honest, answers = nested_and_honest(server, scene)
        rows.append(
            [f"nested lists of {NESTED_BYTES >> 20} MiB", NESTED, *times(honest), len(honest.failures)]
            + [megabytes(memory.peak()), f"{len(answers)} answered: {spread(answers)}", "-"]
        )
        good = honest.p(0.99) < promised and not honest.failures and len(answers) == NESTED
        held &= good and memory.peak() < MEMORY_CAP_BYTES
        complain("nested lists", good, honest)
    held &= small_server(binary, folder, rows, silent)
    silent.close()
    columns = ["hostile clients", "number", "honest p50, ms", "honest p99, ms", "honest failures", "peak memory, MB"]
    body = (
        f"Honest clients: {HONEST_PER_S} requests a second for {HONEST_SECONDS} s, half of them `GET /scenes/{{id}}`, half "
        f"`POST /scenes/validate`, each on a new connection of the same address as the hostile ones. Promised: p99 under "
        f"{promised * 1000:.0f} ms, no failure, memory under {MEMORY_CAP_BYTES >> 20} MiB, all closed within the limit and "
        f"{SLACK} s. Peak is that of resident memory.\n\n" + table(columns + ["closed by the server", "limit"], rows)
    )
    if given.program:
        print(body)
    else:
        write("overload", "Hostile clients", body, DEPENDS_ON)
    return held


def settings(silent: socket.socket, **more) -> list:
    """Arguments of the server."""
    base = {"providers.chat.base_url": f"http://127.0.0.1:{silent.getsockname()[1]}/v1"}
    chosen = SETTINGS | SILENT | base | {f"server.{key}": value for key, value in more.items()}
    return [word for key, value in chosen.items() for word in ("--set", f"{key}={value}")]


def nested_and_honest(server: Server, scene: str):
    honest, answers = Honest(server.port, scene), multiprocessing.Queue()
    senders = [multiprocessing.Process(target=send_nested, args=(server.port, answers)) for _ in range(NESTED)]
    for sender in senders:
        sender.start()
    asyncio.run(honest.run(HONEST_SECONDS))
    for sender in senders:
        sender.join(60)
        sender.kill()
    return honest, [answers.get() for _ in range(answers.qsize())]


def small_server(binary: Path, folder: Path, rows: list, silent: socket.socket) -> bool:
    """A thousand clients that do not read against 64 slots. Those that have just connected keep their slot for a
    moment, so some honest requests are asked to come back."""
    (folder / "small").mkdir()
    sets = settings(silent, max_connections=64)
    with Server(binary, folder / "small", folder / "log_small", arguments=sets) as server:
        created = server.submit_text("a mug", seed=1)
        memory = Memory(server.pid)
        memory.reset()
        attack = Attack(BIG_ANSWERS, THOUSAND)
        honest = asyncio.run(attacked(server, created["id"], attack, RATE_LIMIT))
        rows.append(
            ["that do not read, 64 connections in all", THOUSAND, *times(honest), len(honest.failures), megabytes(memory.peak())]
            + [f"{len(attack.closed)}", f"{RATE_LIMIT} s"]
        )
        refused = len(honest.failures) / max(1, HONEST_PER_S * HONEST_SECONDS)
        good = refused < 0.1 and len(attack.closed) == THOUSAND
        complain("64 connections", good, honest)
        return good


def times(honest: Honest):
    return f"{honest.p(0.5) * 1000:.1f}", f"{honest.p(0.99) * 1000:.1f}"


def megabytes(size: int) -> str:
    return f"{size / 1e6:.0f}"


def spread(answers) -> str:
    kinds = sorted(set(answers))
    return ", ".join(f"{answers.count(kind)} x {kind}" for kind in kinds)


def complain(name: str, good: bool, honest: Honest):
    if not good:
        print(f"{name}: {honest.failures[:3]} p99 {honest.p(0.99) * 1000:.1f} ms", flush=True)


if __name__ == "__main__":
    run(main)
