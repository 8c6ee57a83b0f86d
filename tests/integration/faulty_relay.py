"""A relay of connections on loopback to an object store, with the faults that one has: while a fault lasts, the relay answers in
its place, or not at all."""
import contextlib
import selectors
import socket
import threading

ANSWERS = {"busy": ("503 Slow Down", "SlowDown"), "refusing": ("403 Forbidden", "AccessDenied")}  # and "silent"


class FaultyRelay:
    def __init__(self, port):
        self.port = port
        self.fault = None
        self.connections = set()
        self.lock = threading.Lock()

    def __enter__(self):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.endpoint = "http://127.0.0.1:%d" % self.listener.getsockname()[1]
        threading.Thread(target=self.accept, daemon=True).start()
        return self

    def __exit__(self, *_):
        self.listener.shutdown(socket.SHUT_RDWR)
        self.listener.close()
        self.cut()

    def begin(self, fault):
        self.fault = fault
        self.cut()

    def end(self):
        self.begin(None)

    def cut(self):
        with self.lock:
            connections, self.connections = self.connections, set()
        for connection in connections:
            with contextlib.suppress(OSError):
                connection.shutdown(socket.SHUT_RDWR)

    def accept(self):
        with contextlib.suppress(OSError):
            while True:
                client = self.listener.accept()[0]
                with self.lock:
                    self.connections.add(client)
                threading.Thread(target=self.serve, args=(client, self.fault), daemon=True).start()

    def serve(self, client, fault):
        with client, contextlib.suppress(OSError):
            if fault in ANSWERS:
                self.answer(client, *ANSWERS[fault])
            elif fault == "silent":
                while client.recv(65536):
                    pass
            else:
                self.relay(client)
        with self.lock:
            self.connections.discard(client)

    def relay(self, client):
        with socket.create_connection(("127.0.0.1", self.port)) as store, selectors.DefaultSelector() as both:
            with self.lock:
                self.connections.add(store)
            both.register(client, selectors.EVENT_READ, store)
            both.register(store, selectors.EVENT_READ, client)
            while True:
                for key, _ in both.select():
                    piece = key.fileobj.recv(65536)
                    if not piece:
                        return
                    key.data.sendall(piece)

    def answer(self, client, status, code):
        """To each request of the connection, after its body."""
        with client.makefile("rb") as requests:
            while line := requests.readline():
                head_only, length = line.startswith(b"HEAD"), 0
                while (header := requests.readline()) not in (b"\r\n", b""):
                    if header.lower().startswith(b"content-length:"):
                        length = int(header.split(b":")[1])
                while length:
                    piece = requests.read(min(length, 65536))
                    if not piece:
                        return
                    length -= len(piece)
                body = f"<?xml version='1.0'?><Error><Code>{code}</Code></Error>".encode()
                client.sendall(f"HTTP/1.1 {status}\r\nContent-Type: application/xml\r\nContent-Length: {len(body)}\r\n\r\n".encode()
                               + (b"" if head_only else body))
