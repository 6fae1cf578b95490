"""view_client.py PROGRAM [ARGUMENT OF scotty view...]: starts a view, moves its camera as a hand would, and measures frames a
second, the time from an input to the frame that shows it, the first picture, and the time to a whole picture at rest.

    python3 tests/verify/view/view_client.py build/release/bin/scotty CBcoil.dae --backend cuda --size 1024x1024

Options of its own, before PROGRAM: --seconds S of movement (10), --samples N while it moves (1), --at-least F frames a second,
--median MS and --most MS of latency (99 %), --rest S: exit code 1 where one is missed. --json prints one line of JSON besides.
Standard library only; needs no browser and no display."""
import argparse
import json
import statistics
import sys
import time

from view_protocol import Frame, Program, Viewer, camera_of, turned


def percentile(values, share):
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))] if ordered else float("nan")


def move(viewer, camera, seconds, samples):
    """Inputs as fast as a screen would send them, 120 a second; frames as they come."""
    viewer.send(type="set", values={"moving_samples": str(samples)})
    frames, latencies, sent, sizes = [], [], {}, []
    behind = 0
    begin = time.perf_counter()
    due = begin
    angle = 0.0
    last_shown = 0
    while time.perf_counter() - begin < seconds:
        now = time.perf_counter()
        if now >= due:
            angle += 0.5
            sent[viewer.send(type="camera", moving=True, **turned(camera, angle))] = time.perf_counter()
            due = max(due + 1 / 120, now - 0.05)
        if not viewer.socket.has_input(max(0.0, min(due - time.perf_counter(), 0.01))):
            continue
        got = viewer.next()
        if not isinstance(got, Frame):
            continue
        shown = got.header["shows"]
        if shown > last_shown and shown in sent:
            frames.append(got)
            latencies.append(got.at - sent[shown])
            sizes.append((got.header["width"], got.header["height"]))
            last_shown = shown
    return frames, latencies, sizes, time.perf_counter() - begin


def rest(viewer, camera):
    """The seconds from the last input to the whole picture."""
    begin = time.perf_counter()
    number = viewer.send(type="camera", moving=False, **camera)
    frame = viewer.frame_that(lambda h: h["rest"] and h["shows"] >= number and h["samples"] == h["target"])
    return time.perf_counter() - begin, frame.header


def main():
    options = argparse.ArgumentParser(usage=__doc__.replace("%", "%%"))
    options.add_argument("--seconds", type=float, default=10.0)
    options.add_argument("--samples", type=int, default=1)
    options.add_argument("--at-least", type=float)
    options.add_argument("--median", type=float)
    options.add_argument("--most", type=float)
    options.add_argument("--first", type=float)
    options.add_argument("--rest", type=float)
    options.add_argument("--no-rest", action="store_true")
    options.add_argument("--json", action="store_true")
    options.add_argument("program")
    options.add_argument("words", nargs=argparse.REMAINDER)
    given = options.parse_args()
    with Program(given.program, *given.words) as program:
        linked = time.perf_counter() - program.started
        viewer = Viewer(program.link)
        first = viewer.frame_that(lambda h: True)
        first_picture = first.at - program.started
        whole = viewer.frame_that(lambda h: h["rest"])
        camera = camera_of(whole.header)
        move(viewer, camera, 1.0, given.samples)  # buffers grow to their sizes
        frames, latencies, sizes, seconds = move(viewer, camera, given.seconds, given.samples)
        result = {
            "scene": viewer.hello["scene"]["name"], "backend": whole.header["backend"], "size": whole.header["full"],
            "samples": given.samples, "filter": frames[-1].header["filter"] if frames else None,
            "frames_per_second": len(frames) / seconds,
            "latency_median_ms": 1e3 * statistics.median(latencies) if latencies else float("nan"),
            "latency_99_ms": 1e3 * percentile(latencies, 0.99),
            "latency_most_ms": 1e3 * max(latencies, default=float("nan")),
            "moving_size": statistics.mode(sizes) if sizes else None,
            "bytes_per_frame": sum(f.bytes for f in frames) // max(1, len(frames)),
            "render_ms": 1e3 * statistics.median([f.header["render_seconds"] for f in frames] or [0]),
            "encode_ms": 1e3 * statistics.median([f.header["encode_seconds"] for f in frames] or [0]),
            "link_s": linked, "first_picture_s": first_picture}
        if not given.no_rest:
            rests = [rest(viewer, turned(camera, angle)) for angle in (10.0, 20.0, 30.0)]
            result.update(rest_samples=rests[-1][1]["samples"], rest_s=statistics.median(r[0] for r in rests))
        viewer.close()
        code = program.end()
    print(f"{result['scene']} by {result['backend']}, {result['size'][0]}x{result['size'][1]}, {given.samples} samples while moving, "
          f"filter {result['filter']}")
    print(f"  frames delivered     {result['frames_per_second']:8.1f} /s   at {result['moving_size']}, "
          f"{result['bytes_per_frame'] / 1e3:.0f} kB each; render {result['render_ms']:.1f} ms, encode {result['encode_ms']:.1f} ms")
    print(f"  input to its frame   {result['latency_median_ms']:8.1f} ms   median; 99 %: {result['latency_99_ms']:.1f} ms, "
          f"most: {result['latency_most_ms']:.1f} ms, of {len(latencies)}")
    print(f"  first picture        {result['first_picture_s']:8.2f} s    after the command; the link after {linked:.2f} s")
    if "rest_s" in result:
        print(f"  rest to {result['rest_samples']:4d} samples {result['rest_s']:8.2f} s")
    print(f"  Ctrl-C               exit code {code}")
    if given.json:
        print(json.dumps(result))
    missed = [what for what, limit, value, sign in (
        ("frames a second", given.at_least, result["frames_per_second"], -1), ("median latency", given.median, result["latency_median_ms"], 1),
        ("latency of 99 %", given.most, result["latency_99_ms"], 1), ("first picture", given.first, result["first_picture_s"], 1),
        ("rest", given.rest, result.get("rest_s", 0), 1)) if limit is not None and not sign * value <= sign * limit]
    for what in missed:
        print(f"  MISSED: {what}")
    return 1 if missed or code != 0 else 0


if __name__ == "__main__":
    sys.exit(main())
