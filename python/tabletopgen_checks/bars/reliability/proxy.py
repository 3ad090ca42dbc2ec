"""A TCP proxy that can hold every byte back, or refuse connections."""

import contextlib
import socket
import threading

CHUNK = 1 << 16


class Proxy:
    """Passes connections on to `target`, a port of this machine.

    `hold` keeps connections open and passes nothing, as a network does that drops packets. `refuse` closes them and
    takes none, as a host does whose program is gone. `release` ends both; what was held is passed on then."""

    def __init__(self, target: int, host="127.0.0.1"):
        self.target, self.host, self.lock, self.pairs = target, host, threading.Lock(), []
        self.listener, self.passing = None, threading.Event()
        self.passing.set()

    def __enter__(self):
        self._listen(0)
        return self

    def __exit__(self, *_):
        self.refuse()
        self.passing.set()

    def _listen(self, port):
        self.listener = socket.create_server((self.host, port))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self._accept, args=(self.listener,), daemon=True).start()

    def hold(self):
        self.passing.clear()

    def refuse(self):
        with self.lock:
            pairs, self.pairs = self.pairs, []
            listener, self.listener = self.listener, None
        if listener is not None:
            # A thread that waits in accept() keeps the port open until it is woken.
            listener.shutdown(socket.SHUT_RDWR)
            listener.close()
        for pair in pairs:
            for end in pair:
                end.close()

    def release(self):
        self.passing.set()
        if self.listener is None:
            self._listen(self.port)

    def _accept(self, listener):
        while True:
            try:
                client, _ = listener.accept()
            except OSError:
                if self.listener is not listener:
                    return
                continue
            threading.Thread(target=self._connect, args=(client,), daemon=True).start()

    def _connect(self, client):
        """The target hears of a connection when something may pass: it would close one on which nothing comes."""
        self.passing.wait()
        try:
            server = socket.create_connection(("127.0.0.1", self.target))
        except OSError:
            client.close()
            return
        with self.lock:
            self.pairs.append((client, server))
        for source, sink in ((client, server), (server, client)):
            threading.Thread(target=self._pass, args=(source, sink), daemon=True).start()

    def _pass(self, source, sink):
        try:
            while data := source.recv(CHUNK):
                self.passing.wait()
                sink.sendall(data)
        except OSError:
            pass
        for end in (source, sink):
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)
