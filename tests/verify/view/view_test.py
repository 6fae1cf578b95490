"""view_test.py PROGRAM: the view over its protocol, without a browser. Each check is a function; --list has their names, and
names after PROGRAM choose some."""
import json
import os
import re
import shlex
import socket
import struct
import subprocess
import sys
import tempfile
import time
import urllib.parse
import zlib

from view_protocol import Closed, Frame, Program, Viewer, WebSocket, camera_of, get, gltf_with_two_cameras, run_checks, turned

program = None
SMALL = ["--size", "64x48", "--spp", "8"]


def check(condition, what):
    if not condition:
        raise AssertionError(what)


def read_npy(data):
    check(data[:6] == b"\x93NUMPY", "no .npy file")
    length, = struct.unpack_from("<H", data, 8)
    return data[10:10 + length], data[10 + length:]


def png_pixels(data):
    """8-bit RGB of a PNG: width, height, bytes."""
    check(data[:8] == b"\x89PNG\r\n\x1a\n", "no PNG")
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        if kind == b"IHDR":
            width, height, depth, colors = struct.unpack_from(">IIBB", data, at + 8)
            check((depth, colors) == (8, 2), "not 8-bit RGB")
        if kind == b"IDAT":
            packed += data[at + 8:at + 8 + length]
        at += 12 + length
    raw, rows, stride = zlib.decompress(packed), [], 3 * width
    before = bytearray(stride)
    for y in range(height):
        kind, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride):
            a, b, c = row[i - 3] if i >= 3 else 0, before[i], before[i - 3] if i >= 3 else 0
            p = a + b - c
            nearest = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            row[i] = (row[i] + [0, a, b, (a + b) // 2, nearest][kind]) & 255
        rows.append(bytes(row))
        before = row
    return width, height, b"".join(rows)


def frame_pixels(frame):
    return b"".join(png_pixels(part)[2] for part in frame.parts)


def render(command, folder, file="view.npy"):
    """Runs the command that a view names, with another output."""
    words = shlex.split(command)
    check(words[:2] == ["scotty", "render"], f"not a command of scotty render: {command}")
    words[words.index("view.exr")] = file
    done = subprocess.run([program] + words[1:], cwd=folder, capture_output=True, text=True)
    check(done.returncode == 0, f"{command}: {done.stderr}")
    with open(os.path.join(folder, file), "rb") as made:
        return made.read()


def cameras_of_the_file():
    """They are offered by name, and one of them is what scotty render makes of `FILE#camera=NAME`."""
    with tempfile.TemporaryDirectory() as folder:
        scene = os.path.join(folder, "two.gltf")
        with open(scene, "w", encoding="utf-8") as file:
            file.write(gltf_with_two_cameras())
        with Program(program, scene, *SMALL) as view:
            viewer = Viewer(view.link)
            first = viewer.complete()
            check(viewer.hello["scene"]["cameras"] == ["Front", "Side"], viewer.hello["scene"])
            check(first.header["camera"]["position"] == [0, 0, 4], first.header["camera"])
            number = viewer.send(type="own camera", number=1)
            frame = viewer.frame_that(lambda h: h["shows"] >= number and h["samples"] == h["target"])
            check(frame.header["camera"]["position"] == [1, 0, 3], frame.header["camera"])
            saved = get(view.link, "picture.npy")[1]
            size = ["--size", "64x48", "--spp", "8", "--backend", "emulator"]
            made = render(shlex.join(["scotty", "render", scene + "#camera=Side", "-o", "view.exr", *size]), folder)
            check(read_npy(made)[1] == read_npy(saved)[1], "not the bits of scotty render")
            number = viewer.send(type="own camera", number=2)
            refused = viewer.wait_for("error", lambda m: m["id"] == number)
            check("no such camera" in refused["text"], refused)
            viewer.close()


def the_same_bits_as_render(backend="emulator"):
    """At rest, from a camera that was moved: the saved picture, the frame that was shown and the command that the view names."""
    with Program(program, "coil", *SMALL, "--filter", "none", "--backend", backend) as view, tempfile.TemporaryDirectory() as folder:
        viewer = Viewer(view.link)
        first = viewer.complete()
        for angle in (0, 25):
            if angle:
                number = viewer.send(type="camera", moving=False, **turned(camera_of(first.header), angle))
                frame = viewer.frame_that(lambda h: h["shows"] >= number and h["samples"] == h["target"])
                viewer.state = None
                viewer.send(type="show", exposure=0.0)
                while viewer.state is None:
                    viewer.next()
            else:
                frame = first
            status, saved = get(view.link, "picture.npy")
            check(status == 200, f"picture.npy: {status}")
            if viewer.state["camera_file"]:
                with open(os.path.join(folder, viewer.state["camera_file"]), "wb") as file:
                    file.write(get(view.link, "camera")[1])
            check(bool(viewer.state["camera_file"]) == bool(angle), "a camera that was moved needs a file, the scene's own needs none")
            check(read_npy(render(viewer.state["command"], folder))[1] == read_npy(saved)[1],
                  f"{angle} degrees: not the bits of {viewer.state['command']}")
            shown = png_pixels(render(viewer.state["command"], folder, "view.png"))
            check(shown[2] == frame_pixels(frame), f"{angle} degrees: the lossless frame is not the PNG of scotty render")
        viewer.close()


def the_filter_is_that_of_render():
    with Program(program, "coil", "--size", "64x48", "--spp", "2") as view, tempfile.TemporaryDirectory() as folder:
        viewer = Viewer(view.link)
        for name in ("median", "gaussian", "bilateral"):
            number = viewer.send(type="set", values={"filter": name})
            frame = viewer.frame_that(lambda h: h["shows"] >= number and h["samples"] == 2)
            check(frame.header["filter"] == name, f"the frame has the filter {frame.header['filter']}")
            shown = png_pixels(render(viewer.state["command"] + f" --filter {name}", folder, "view.png"))
            check(shown[2] == frame_pixels(frame), f"{name}: not the picture of scotty render")
        before = viewer.send(type="show", filtered=False)
        frame = viewer.frame_that(lambda h: h["shows"] >= before)
        check(frame.header["filter"] == "none" and frame.header["samples"] == 2, "before and after renders nothing anew")
        check(png_pixels(render(viewer.state["command"], folder, "view.png"))[2] == frame_pixels(frame), "not the unfiltered picture")


def only_who_has_the_link_is_answered():
    with Program(program, "cornell", *SMALL) as view:
        parts = urllib.parse.urlsplit(view.link)
        token = parts.path.strip("/")
        check(len(token) == 32 and parts.hostname == "127.0.0.1", f"the link: {view.link}")
        root = f"http://{parts.netloc}/"
        allowed = [{"Host": host} for host in ("127.0.0.1", "localhost", "[::1]", "localhost:9999", "127.0.0.1:1", "[::1]:8080")]
        refused = [{"Host": host} for host in ("evil.example", "127.0.0.1.evil.example", "localhost.evil", "evil@127.0.0.1", "10.0.0.1",
                                               "[::2]", "127.0.0.1:x", "")]
        for headers in allowed:
            check(get(view.link, "camera", headers)[0] == 200, f"{headers} is refused")
        for headers in refused:
            check(get(view.link, "camera", headers)[0] in (400, 403), f"{headers} is answered")
        for origin in ("http://localhost:1234", "http://127.0.0.1", f"http://{parts.netloc}"):
            check(get(view.link, "camera", {"Origin": origin})[0] == 200, f"{origin} is refused")
        for origin in ("http://evil.example", "null", "https://127.0.0.1", "http://127.0.0.1.evil.example", "file://", ""):
            check(get(view.link, "camera", {"Origin": origin})[0] == 403, f"the origin '{origin}' is answered")
            try:
                WebSocket(view.link + "socket", {"Origin": origin})
                raise AssertionError(f"a socket for the origin '{origin}'")
            except Closed as closed:
                check("403" in str(closed), str(closed))
        wrong = ("0" if token[0] != "0" else "1") + token[1:]
        for path in ("", "socket", wrong + "/", wrong + "/socket", token[:-1] + "/", token + "0/", "../" + token + "/", "%2e%2e/"):
            check(get(root, path)[0] == 404, f"/{path} is answered")
        check(get(view.link, "etc/passwd")[0] == 404 and get(view.link, "../../etc/passwd")[0] == 404, "files are served")
        check(get(view.link, "")[0] == 200, "the page")
        for line in ("POST / HTTP/1.1\r\nHost: localhost\r\n\r\n", f"HEAD /{token}/ HTTP/1.1\r\nHost: localhost\r\n\r\n",
                     f"GET /{token}/ HTTP/1.1\r\n\r\n", f"GET /{token}/ HTTP/1.1\r\nHost: localhost\r\nHost: evil\r\n\r\n",
                     "GET /" + "x" * 600 + " HTTP/1.1\r\nHost: localhost\r\n\r\n", "\x00\x01\x02\r\n\r\n",
                     "GET / HTTP/1.1\r\nHost: localhost\r\n" + "X: " + "y" * 20000 + "\r\n\r\n",
                     f"GET /{token}/ HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\nhello"):
            with socket.create_connection((parts.hostname, parts.port), timeout=20) as raw:
                raw.sendall(line.encode("latin1"))
                answer = raw.recv(64)
                check(answer.split()[1:2] and answer.split()[1][:1] == b"4", f"{line[:40]!r}: {answer!r}")


def hostile_messages_harm_nobody():
    """Each is answered by an error or cuts its sender off; the viewer beside it goes on."""
    with Program(program, "cornell", *SMALL) as view:
        good = Viewer(view.link)
        good.complete()
        bad = Viewer(view.link)
        refused = ["", "x", "[]", "null", "{", '{"type":1}', '{"type":"no such"}', '{"type":"camera"}', '{"type":"set","values":{"width":"3"}}',
                   '{"type":"set","values":{"image_width":"99999999"}}', '{"type":"set","values":{"image_width":"65536","image_height":"65536"}}',
                   '{"type":"set","values":{"backend":"cuda2"}}', '{"type":"set","values":[1]}', '{"type":"set","values":{"no such":"1"}}',
                   '{"type":"set","values":{"arithmetic":"fast"}}', '{"type":"show","what":"all"}', '{"type":"show","exposure":1e9}',
                   '{"type":"pick","x":-1,"y":0}', '{"type":"pick","x":64,"y":0}', '{"type":"pick","x":1e30,"y":0}', '{"type":"start","job":"rm"}',
                   '{"type":"start","job":"compare","backend":"; rm -rf /"}', '{"type":"start","job":"queues","x":64,"y":64}',
                   '{"type":"camera","position":[0,0,0],"target":[0,0,0],"up":[0,1,0],"fov":40}',
                   '{"type":"camera","position":[0,0,0],"target":[0,1,0],"up":[0,1,0],"fov":40}',
                   '{"type":"camera","position":[1e300,0,0],"target":[0,1,0],"up":[0,1,0],"fov":40}',
                   '{"type":"camera","position":["a",0,0],"target":[0,1,0],"up":[0,1,0],"fov":40}',
                   '{"type":"camera","position":[0,0,0],"target":[0,1,1],"up":[0,1,0],"fov":0}', '{"id":-1,"type":"seen"}',
                   '{"id":1e400,"type":"seen"}', "[" * 8000, '{"a":' * 3000, '"' + "x" * 16000 + '"']
        for text in refused:
            bad.socket.send(text)
            bad.wait_for("error")
        bad.send(type="set", values={"width": "8"})
        bad.close()
        for opcode, payload in ((1, b"x" * 70000), (2, b"binary"), (1, b"\xff\xfe\xfd"), (3, b"reserved"), (9, b"p" * 126), (0, b"continued")):
            rude = Viewer(view.link)
            try:
                rude.socket.send_frame(opcode, payload)
                while True:
                    rude.next()
            except (Closed, OSError):
                pass
        flood = Viewer(view.link)
        try:
            for _ in range(5000):
                flood.send(type="show", exposure=0.0)
            while True:
                flood.next()
        except (Closed, OSError):
            pass
        half = WebSocket(view.link + "socket")
        half.socket.sendall(b"\x81")  # and no more
        number = good.send(type="camera", moving=False, fov=50, position=[0, 1, 3], target=[0, 1, 0], up=[0, 1, 0])
        good.frame_that(lambda h: h["shows"] >= number and h["samples"] == h["target"])
        check(view.end() == 0, "Ctrl-C with a client that has said half a word")


def a_slow_reader_makes_no_queue():
    """One that acknowledges nothing gets two frames, and the next it asks for is the newest; one that reads nothing stops nobody."""
    with Program(program, "cornell", *SMALL) as view:
        slow, deaf, quick = Viewer(view.link, acknowledges=False), WebSocket(view.link + "socket"), Viewer(view.link)
        camera = camera_of(quick.complete().header)
        got = []
        for step in range(60):
            number = quick.send(type="camera", moving=True, **turned(camera, step))
            newest = quick.frame_that(lambda h: h["shows"] >= number)
        while slow.socket.has_input(0.5):
            frame = slow.next()
            if isinstance(frame, Frame):
                got.append(frame.header["frame"])
        check(len(got) <= 2, f"{len(got)} frames without an answer")
        slow.socket.send('{"type":"seen"}')
        frame = slow.frame_that(lambda h: True)
        check(frame.header["frame"] >= newest.header["frame"], f"frame {frame.header['frame']} after {newest.header['frame']}")
        deaf.close()


def viewers_share_a_view_and_the_last_one_idles_it():
    with Program(program, "cornell", "--size", "128x96", "--spp", "100000") as view:
        one, two = Viewer(view.link), Viewer(view.link)
        one.wait_for("state", lambda s: s["viewers"] == 2)
        camera = camera_of(one.frame_that(lambda h: h["rest"]).header)
        one.send(type="camera", moving=False, **turned(camera, 30))
        state = one.frame_that(lambda h: h["rest"] and h["shows"] == one.id).header["state"]
        two.frame_that(lambda h: h["rest"] and h["state"] >= state)
        one.close()
        two.wait_for("state", lambda s: s["viewers"] == 1)
        two.close()

        def seconds():
            with open(f"/proc/{view.process.pid}/stat") as file:
                fields = file.read().rsplit(")", 1)[1].split()
            return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
        time.sleep(1.0)
        before = seconds()
        time.sleep(1.5)
        check(seconds() - before < 0.3, f"{seconds() - before:.2f} s of work in 1.5 s with nobody there")
        three = Viewer(view.link)
        three.frame_that(lambda h: h["rest"] and h["samples"] >= 1)


def it_ends_cleanly():
    for number, code in ((2, 0), (15, 0)):
        with Program(program, "coil", "--spp", "100000") as view:
            viewer = Viewer(view.link)
            viewer.send(type="start", job="verify")
            viewer.wait_for("job")
            begin = time.perf_counter()
            check(view.end(number) == code, f"signal {number}: exit code {view.process.returncode}")
            check(time.perf_counter() - begin < 8, "it takes long to end")
    done = subprocess.run([program, "view", "no such scene"], capture_output=True, text=True)
    check(done.returncode == 2 and "no such scene" in done.stderr, done.stderr)
    with Program(program, "cornell", *SMALL) as view:
        port = str(urllib.parse.urlsplit(view.link).port)
        done = subprocess.run([program, "view", "cornell", "--port", port], capture_output=True, text=True)
        check(done.returncode == 3 and port in done.stderr, f"a port that is taken: {done.returncode}, {done.stderr}")


def changes_keep_the_picture():
    """Parameters of tree and pipeline change no bit; a back end that lacks something says so."""
    with Program(program, "coil", "--size", "48x36", "--spp", "4") as view:
        viewer = Viewer(view.link)
        first = viewer.complete().header["hash"]
        for values in ({"width": "2"}, {"queue_levels": "3", "hit_mode": "buffer"}, {"backend": "simt"}, {"backend": "emulator"},
                       {"batch_rays": "500"}):
            number = viewer.send(type="set", values=values)
            frame = viewer.frame_that(lambda h: h["shows"] >= number and h["rest"] and h["samples"] == 4)
            check(frame.header["hash"] == first, f"{values}: another picture")
        for message in [t for t in viewer.texts if t["type"] == "changed"]:
            check(message["same_picture"] and not message["fault"], message["text"])
        number = viewer.send(type="set", values={"bounces": "1"})
        viewer.wait_for("changed", lambda m: "bounces" in m["what"] and not m["same_picture"] and not m["fault"])
        viewer.send(type="set", values={"backend": "embree"})
        for message in ({"type": "show", "what": "queues"}, {"type": "pick", "x": 1, "y": 1}, {"type": "start", "job": "verify"}):
            number = viewer.send(**message)
            error = viewer.wait_for("error")
            check(error["id"] == number and "no stages" in error["text"], error["text"])


def main():
    global program
    checks = {name.replace("_", " "): f for name, f in globals().items()
              if callable(f) and getattr(f, "__module__", "") == "__main__" and name not in (
                  "check", "read_npy", "png_pixels", "frame_pixels", "render", "main")}
    if "--list" in sys.argv:
        print("\n".join(checks))
        return 0
    program = os.path.abspath(sys.argv[1])
    return run_checks(checks, sys.argv[2:])


if __name__ == "__main__":
    sys.exit(main())
