"""A network between workers and the services they use, that can be cut.

As root: a network namespace for the workers and one veth link for each service; a cut takes the link down, so that
packets vanish without an error, as with a broken cable. Otherwise: a TCP proxy on loopback that passes nothing on
while it is cut."""

import contextlib
import os
import subprocess

from tabletopgen_checks.bars.reliability.proxy import Proxy
from tabletopgen_checks.problem import Problem

# Addresses reserved for benchmarks (RFC 2544).
SUBNET = "198.18"


class Network:
    def __init__(self):
        self.namespace = f"ttg{os.getpid()}"
        self.links = 0
        self.isolated = os.geteuid() == 0 and self._ip("netns", "add", self.namespace)

    @property
    def how(self) -> str:
        return "network namespace, link down" if self.isolated else "TCP proxy that passes nothing"

    def __enter__(self):
        if self.isolated:
            self._need("-n", self.namespace, "link", "set", "lo", "up")
        return self

    def __exit__(self, *_):
        if self.isolated:
            self._ip("netns", "delete", self.namespace)

    def within(self) -> tuple:
        """The command that runs a program there."""
        return ("ip", "netns", "exec", self.namespace) if self.isolated else ()

    @contextlib.contextmanager
    def between(self, port: int):
        """A link to a port of this machine's loopback."""
        if not self.isolated:
            with Proxy(port) as proxy:
                yield ProxyLink(proxy)
            return
        self.links += 1
        name, peer = f"ttgh{self.links}x{os.getpid() % 10000}", f"ttgw{self.links}x{os.getpid() % 10000}"
        here, there = f"{SUBNET}.{self.links}.1", f"{SUBNET}.{self.links}.2"
        self._need("link", "add", name, "type", "veth", "peer", "name", peer, "netns", self.namespace)
        try:
            self._need("address", "add", f"{here}/24", "dev", name)
            self._need("link", "set", name, "up")
            self._need("-n", self.namespace, "address", "add", f"{there}/24", "dev", peer)
            self._need("-n", self.namespace, "link", "set", peer, "up")
            # The services listen on loopback only; this passes on what arrives over the link.
            with Proxy(port, host=here) as proxy:
                yield VethLink(self, name, f"{here}:{proxy.port}")
        finally:
            self._ip("link", "delete", name)

    def _ip(self, *words) -> bool:
        try:
            return subprocess.run(["ip", *words], capture_output=True).returncode == 0
        except OSError:
            return False

    def _need(self, *words):
        if not self._ip(*words):
            raise Problem(f"`ip {' '.join(words)}` failed; the network cannot be cut here")


class VethLink:
    def __init__(self, network: Network, name: str, address: str):
        self.network, self.name, self.address = network, name, address

    def cut(self):
        self.network._need("link", "set", self.name, "down")

    def mend(self):
        self.network._need("link", "set", self.name, "up")


class ProxyLink:
    def __init__(self, proxy: Proxy):
        self.proxy, self.address = proxy, f"127.0.0.1:{proxy.port}"

    def cut(self):
        self.proxy.hold()

    def mend(self):
        self.proxy.release()
