"""The protocol of docs/view.md for tests: a WebSocket client, a viewer, and the program it looks at. Standard library only."""
import base64
import json
import os
import select
import signal
import socket
import struct
import subprocess
import sys
import time
import urllib.error
import urllib.parse
import urllib.request


class Closed(Exception):
    pass


class WebSocket:
    """RFC 6455, as a client; no extensions."""

    def __init__(self, url, headers=None, timeout=60.0):
        parts = urllib.parse.urlsplit(url)
        self.socket = socket.create_connection((parts.hostname, parts.port), timeout=timeout)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.buffer = bytearray()
        key = base64.b64encode(os.urandom(16)).decode()
        head = {"Host": parts.netloc, "Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Key": key,
                "Sec-WebSocket-Version": "13"}
        head.update(headers or {})
        lines = [f"GET {parts.path or '/'} HTTP/1.1"] + [f"{name}: {value}" for name, value in head.items() if value is not None]
        self.socket.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        while b"\r\n\r\n" not in self.buffer:
            self._fill()
        answer, _, rest = bytes(self.buffer).partition(b"\r\n\r\n")
        self.buffer = bytearray(rest)
        self.status = int(answer.split()[1])
        if self.status != 101:
            self.socket.close()
            raise Closed(f"status {self.status}")

    def _fill(self):
        piece = self.socket.recv(1 << 20)
        if not piece:
            raise Closed("the other side has closed")
        self.buffer += piece

    def _take(self, count):
        while len(self.buffer) < count:
            self._fill()
        out = bytes(self.buffer[:count])
        del self.buffer[:count]
        return out

    def has_input(self, seconds=0.0):
        return bool(self.buffer) or bool(select.select([self.socket], [], [], seconds)[0])

    def send_frame(self, opcode, payload, final=True):
        mask = os.urandom(4)
        head = bytes([(0x80 if final else 0) | opcode])
        if len(payload) < 126:
            head += bytes([0x80 | len(payload)])
        elif len(payload) < 65536:
            head += bytes([0x80 | 126]) + struct.pack(">H", len(payload))
        else:
            head += bytes([0x80 | 127]) + struct.pack(">Q", len(payload))
        repeated = (mask * (len(payload) // 4 + 1))[:len(payload)]
        masked = (int.from_bytes(payload, "big") ^ int.from_bytes(repeated, "big")).to_bytes(len(payload), "big")
        self.socket.sendall(head + mask + masked)

    def send(self, text):
        self.send_frame(1, text.encode())

    def receive(self):
        """A text as str, or bytes. Raises Closed at the end."""
        message, kind = b"", None
        while True:
            first, second = self._take(2)
            length = second & 0x7f
            if length == 126:
                length, = struct.unpack(">H", self._take(2))
            elif length == 127:
                length, = struct.unpack(">Q", self._take(8))
            payload = self._take(length)
            opcode = first & 0x0f
            if opcode == 8:
                raise Closed("closed by the other side")
            if opcode == 9:
                self.send_frame(10, payload)
                continue
            if opcode == 10:
                continue
            kind = kind or opcode
            message += payload
            if first & 0x80:
                return message.decode() if kind == 1 else message

    def close(self):
        self.socket.close()


class Frame:
    def __init__(self, data, at):
        length, = struct.unpack_from("<I", data)
        self.header = json.loads(data[4:4 + length])
        self.at = at
        self.parts = []
        begin = 4 + length
        for _, size in self.header["parts"]:
            self.parts.append(data[begin:begin + size])
            begin += size
        assert begin == len(data), "a frame is longer than its header says"
        self.bytes = len(data)


class Viewer:
    def __init__(self, link, acknowledges=True, timeout=60.0):
        self.socket = WebSocket(link + "socket", timeout=timeout)
        self.acknowledges = acknowledges
        self.id = 0
        self.texts = []
        self.frames = 0
        self.hello = self.wait_for("hello")
        self.state = self.wait_for("state")

    def send(self, **message):
        self.id += 1
        message["id"] = self.id
        self.socket.send(json.dumps(message))
        return self.id

    def next(self):
        """A Frame, or a message as a dictionary."""
        data = self.socket.receive()
        now = time.perf_counter()
        if isinstance(data, str):
            message = json.loads(data)
            self.texts.append(message)
            if message["type"] == "state":
                self.state = message
            return message
        frame = Frame(data, now)
        self.frames += 1
        if self.acknowledges:
            self.socket.send('{"type":"seen"}')
        return frame

    def wait_for(self, kind, accept=lambda message: True):
        while True:
            got = self.next()
            if not isinstance(got, Frame) and got["type"] == kind and accept(got):
                return got

    def frame_that(self, accept):
        while True:
            got = self.next()
            if isinstance(got, Frame) and accept(got.header):
                return got

    def complete(self, state=0):
        """The frame of the whole picture at rest."""
        return self.frame_that(lambda h: h["rest"] and h["samples"] == h["target"] and h["state"] >= state)

    def close(self):
        self.socket.close()


def camera_of(header):
    """What a camera message needs, from a frame's camera: position, target one metre in front, up, degrees."""
    import math
    camera = header["camera"]
    target = [p + f for p, f in zip(camera["position"], camera["forward"])]
    return {"position": camera["position"], "target": target, "up": camera["up"],
            "fov": 2 * math.degrees(math.atan(camera["tan_half_fov"]))}


def turned(camera, degrees):
    """The camera, turned around the vertical axis through the origin."""
    import math
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    turn = lambda v: [c * v[0] + s * v[2], v[1], c * v[2] - s * v[0]]
    return {**camera, "position": turn(camera["position"]), "target": turn(camera["target"]), "up": turn(camera["up"])}


def get(link, path="", headers=None):
    """Status and body."""
    try:
        with urllib.request.urlopen(urllib.request.Request(link + path, headers=headers or {}), timeout=60) as answer:
            return answer.status, answer.read()
    except urllib.error.HTTPError as error:
        return error.code, error.read()


class Program:
    """`scotty view`, started; use it in a `with`."""

    def __init__(self, program, *words):
        self.started = time.perf_counter()
        # A shell's background job ignores SIGINT, and so would the program, by which it is ended.
        self.process = subprocess.Popen([program, "view", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
        self.link = self.process.stdout.readline().strip()
        if not self.link.startswith("http://"):
            self.process.kill()
            raise SystemExit(f"{program} view {' '.join(words)}: no link; {self.process.stderr.read()}")

    def __enter__(self):
        return self

    def end(self, number=signal.SIGINT, seconds=20):
        """The exit code, or what the program said last."""
        self.process.send_signal(number)
        try:
            self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            raise AssertionError(f"scotty view still runs {seconds} s after a signal")
        return self.process.returncode

    def __exit__(self, *failure):
        if self.process.poll() is None:
            self.end()
        text = self.process.stderr.read()
        if failure[0] is not None:
            sys.stderr.write(text)

    def memory(self):
        """Resident bytes."""
        with open(f"/proc/{self.process.pid}/statm") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def gltf_with_two_cameras():
    """A triangle, and cameras in front of it and beside it."""
    corners = struct.pack("<9f", -1, -1, 0, 1, -1, 0, 0, 1, 0)
    return json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
        "nodes": [{"mesh": 0}, {"name": "Front", "camera": 0, "translation": [0, 0, 4]},
                  {"name": "Side", "camera": 0, "translation": [1, 0, 3]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64," + base64.b64encode(corners).decode()}]})


def run_checks(checks, words, *arguments):
    """Runs the functions that `words` name, or all; prints a line each. The exit code: 1 where one fails, 2 where there is no such."""
    unknown = [word for word in words if word not in checks]
    if unknown:
        print(f"no such check: {', '.join(unknown)}; --list has their names")
        return 2
    failed = 0
    for name, run in checks.items():
        if words and name not in words:
            continue
        begin = time.perf_counter()
        try:
            run(*arguments)
            print(f"passed  {name} ({time.perf_counter() - begin:.1f} s)", flush=True)
        except (AssertionError, Closed, OSError) as error:
            failed += 1
            print(f"FAILED  {name}: {error!r}", flush=True)
    return 1 if failed else 0
