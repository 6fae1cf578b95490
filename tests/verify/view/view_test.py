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

from view_protocol import Closed, Frame, Program, Viewer, WebSocket, camera_of, get, turned

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


def main():
    global program
    checks = {name.replace("_", " "): f for name, f in globals().items()
              if callable(f) and getattr(f, "__module__", "") == "__main__" and name not in (
                  "check", "read_npy", "png_pixels", "frame_pixels", "render", "main")}
    if "--list" in sys.argv:
        print("\n".join(checks))
        return 0
    program = os.path.abspath(sys.argv[1])
    failed = 0
    for name, run in checks.items():
        if sys.argv[2:] and name not in sys.argv[2:]:
            continue
        begin = time.perf_counter()
        try:
            run()
            print(f"passed  {name} ({time.perf_counter() - begin:.1f} s)", flush=True)
        except (AssertionError, Closed, OSError) as error:
            failed += 1
            print(f"FAILED  {name}: {error!r}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
