"""soak.py [--minutes M] [--clients N] PROGRAM [ARGUMENT OF scotty view...]: a view for a long time (30 minutes, 10 clients), with random
input and clients that come and go, some of them slow, rude or deaf. Exit code 1 where memory grows after the first quarter, a frame is
older than the newest by more than two, an answer fails to come, or the program ends. Not part of the tests that run in minutes."""
import argparse
import random
import sys
import threading
import time

from view_protocol import Closed, Frame, Program, Viewer, camera_of, get, turned

newest = 0
faults = []
counts = {"clients": 0, "frames": 0, "messages": 0, "errors": 0}
lock = threading.Lock()


def fault(text):
    with lock:
        faults.append(text)
    print(f"FAULT: {text}", flush=True)


def someone(link, seed, end):
    """One client after the other, each of some kind."""
    global newest
    chance = random.Random(seed)
    while time.monotonic() < end and not faults:
        kind = chance.choice(["mover", "mover", "slow", "changer", "rude", "deaf", "saver"])
        until = min(end, time.monotonic() + chance.uniform(1, 20))
        try:
            viewer = Viewer(link, acknowledges=kind != "slow", timeout=90)
            with lock:
                counts["clients"] += 1
            camera, pending = None, 0
            while time.monotonic() < until:
                if kind == "deaf":
                    time.sleep(0.5)
                    continue
                if viewer.socket.has_input(chance.uniform(0, 0.05)):
                    # The newest that anybody has seen before this one was read.
                    with lock:
                        known = newest
                    got = viewer.next()
                    if isinstance(got, Frame):
                        number = got.header["frame"]
                        with lock:
                            newest = max(newest, number)
                            counts["frames"] += 1
                        # Two are underway to a client that acknowledges at once; what it reads late has been sent early.
                        if kind == "mover" and number < known - 2 and not viewer.socket.has_input():
                            late = viewer.late = getattr(viewer, "late", 0) + 1
                            if late > 3:
                                fault(f"frame {number} when {known} had been seen")
                        else:
                            viewer.late = 0
                        camera = camera_of(got.header)
                        if kind == "slow":
                            time.sleep(chance.uniform(0, 0.5))
                            viewer.socket.send('{"type":"seen"}')
                    elif got["type"] == "error":
                        counts["errors"] += 1
                    continue
                if camera is None:
                    continue
                with lock:
                    counts["messages"] += 1
                if kind in ("mover", "slow"):
                    viewer.send(type="camera", moving=chance.random() < 0.9, **turned(camera, chance.uniform(-5, 5)))
                elif kind == "changer":
                    name, value = chance.choice([("width", chance.choice("248")), ("bounces", chance.choice("0123")), ("early_out", "off"),
                                                 ("early_out", "immediate"), ("hit_mode", "buffer"), ("hit_mode", "packed"),
                                                 ("image_width", str(chance.randint(20, 300))), ("filter", "gaussian"), ("filter", "median"),
                                                 ("backend", chance.choice(["emulator", "embree"])), ("seed", str(chance.randint(0, 99)))])
                    viewer.send(type="set", values={name: value})
                    viewer.send(type="show", what=chance.choice(["picture", "picture", "distance", "normal", "queues", "variance"]))
                    viewer.send(type="pick", x=chance.randint(0, 40), y=chance.randint(0, 40))
                    time.sleep(chance.uniform(0, 1))
                elif kind == "saver":
                    status, _ = get(link, chance.choice(["", "camera", "picture.npy", "picture.png", "nothing"]))
                    if status not in (200, 404):
                        fault(f"GET: status {status}")
                else:
                    viewer.socket.send_frame(chance.choice([1, 1, 2, 3]), chance.randbytes(chance.randint(0, 300)))
            viewer.close()
        except (Closed, OSError) as error:
            if kind in ("mover", "saver") and time.monotonic() < end - 1:
                fault(f"{kind} was cut off: {error!r}")


def main():
    options = argparse.ArgumentParser(usage=__doc__.replace("%", "%%"))
    options.add_argument("--minutes", type=float, default=30.0)
    options.add_argument("--clients", type=int, default=10)
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("program")
    options.add_argument("words", nargs=argparse.REMAINDER)
    given = options.parse_args()
    with Program(given.program, *(given.words or ["coil", "--size", "256x192"])) as view:
        begin = time.monotonic()
        end = begin + 60 * given.minutes
        threads = [threading.Thread(target=someone, args=(view.link, given.seed + i, end)) for i in range(given.clients)]
        for thread in threads:
            thread.start()
        early = []  # the largest of the first half, and of the second
        late = []
        while time.monotonic() < end and not faults:
            time.sleep(min(5.0, max(0.1, end - time.monotonic())))
            if view.process.poll() is not None:
                fault(f"the program has ended with {view.process.returncode}")
                break
            megabytes = view.memory() / 1e6
            share = (time.monotonic() - begin) / (end - begin)
            if share > 0.25:
                (early if share < 0.625 else late).append(megabytes)
            print(f"{time.monotonic() - begin:7.0f} s  {megabytes:7.1f} MB  {counts}", flush=True)
        for thread in threads:
            thread.join(60)
        if early and late and max(late) > 1.1 * max(early) + 20:
            fault(f"memory grows: up to {max(early):.1f} MB, then up to {max(late):.1f} MB")
        # With patience: where a soak runs beside other work, it has what they leave.
        if view.process.poll() is None and view.end(seconds=300) != 0:
            fault(f"exit code {view.process.returncode}")
    print(f"{'FAILED' if faults else 'passed'}: {given.minutes:.1f} minutes, {given.clients} clients at a time, {counts}"
          + (f"; memory up to {max(early):.0f} MB, then {max(late):.0f} MB" if early and late else ""))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
