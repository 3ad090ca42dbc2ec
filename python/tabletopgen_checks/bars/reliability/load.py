"""Many connections that each send a request, wait for the answer and send the next, in one thread, over epoll."""

import json
import re
import select
import socket
import time
from collections import Counter

LENGTH = re.compile(rb"(?i)\r\ncontent-length: *(\d+)")


class Client:
    """One connection with one request under way."""

    def __init__(self, port: int):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=60)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.received, self.began = b"", 0.0

    def send(self, request: bytes):
        self.received, self.began = b"", time.perf_counter()
        self.socket.sendall(request)

    def status(self):
        """Of the complete answer; None while some of it is missing."""
        data = self.socket.recv(1 << 16)
        if not data:
            return 0
        self.received += data
        head = self.received.find(b"\r\n\r\n")
        if head < 0:
            return None
        length = LENGTH.search(self.received, 0, head + 2)
        if length is None or len(self.received) < head + 4 + int(length[1]):
            return None
        return int(self.received[9:12])


def run(ports: list, clients: int, seconds: float, request_of) -> tuple:
    """Seconds of each answered request and the count of each status; `request_of(k)` is the k-th request."""
    many = [Client(ports[k % len(ports)]) for k in range(clients)]
    poll = select.epoll()
    by_descriptor = {client.socket.fileno(): client for client in many}
    durations, statuses, sent = [], Counter(), 0
    for client in many:
        poll.register(client.socket, select.EPOLLIN)
        client.send(request_of(sent))
        sent += 1
    began = time.perf_counter()
    open_clients = len(many)
    while open_clients:
        for descriptor, _ in poll.poll(60):
            client = by_descriptor[descriptor]
            status = client.status()
            if status is None:
                continue
            now = time.perf_counter()
            statuses[status] += 1
            durations.append(now - client.began)
            if status == 0 or now - began >= seconds:
                poll.unregister(client.socket)
                client.socket.close()
                open_clients -= 1
            else:
                client.send(request_of(sent))
                sent += 1
    return durations, time.perf_counter() - began, statuses


def post(path: str, body: dict, headers=None) -> bytes:
    """A request as bytes, on a connection that is kept."""
    content = json.dumps(body).encode()
    lines = [
        f"POST {path} HTTP/1.1",
        "host: 127.0.0.1",
        "content-type: application/json",
        f"content-length: {len(content)}",
    ]
    lines += [f"{name}: {value}" for name, value in (headers or {}).items()]
    return "\r\n".join(lines).encode() + b"\r\n\r\n" + content
