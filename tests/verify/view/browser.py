"""A headless Chromium, driven over the DevTools protocol. Standard library only."""
import base64
import json
import os
import shutil
import subprocess
import tempfile
import time

from view_protocol import WebSocket, get


class Browser:
    def __init__(self, width=1280, height=900):
        self.folder = tempfile.mkdtemp(prefix="scotty-browser-")
        self.process = subprocess.Popen(
            ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--hide-scrollbars", "--remote-debugging-port=0",
             f"--window-size={width},{height}", f"--user-data-dir={self.folder}/profile", "about:blank"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        address = os.path.join(self.folder, "profile", "DevToolsActivePort")
        end = time.monotonic() + 60
        while not (os.path.exists(address) and len(open(address).read().split()) == 2):
            if time.monotonic() > end or self.process.poll() is not None:
                raise AssertionError("chromium does not start")
            time.sleep(0.05)
        self.port = int(open(address).read().split()[0])

    def __enter__(self):
        return self

    def __exit__(self, *failure):
        self.process.terminate()
        self.process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)

    def page(self, url, width=1280, height=900, scale=1, dark=False):
        import urllib.request
        request = urllib.request.Request(f"http://127.0.0.1:{self.port}/json/new?about:blank", method="PUT")
        with urllib.request.urlopen(request, timeout=30) as answer:
            target = json.load(answer)
        return Page(target["webSocketDebuggerUrl"], url, width, height, scale, dark)


class Page:
    def __init__(self, address, url, width, height, scale, dark):
        self.socket = WebSocket(address)
        self.number = 0
        self.faults = []
        for domain in ("Page", "Runtime", "Log"):
            self.call(f"{domain}.enable")
        self.size(width, height, scale)
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])
        self.call("Page.navigate", url=url)

    def size(self, width, height, scale=1):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=scale, mobile=False)

    def call(self, method, **parameters):
        self.number += 1
        self.socket.send(json.dumps({"id": self.number, "method": method, "params": parameters}))
        while True:
            message = json.loads(self.socket.receive())
            if message.get("id") == self.number:
                if "error" in message:
                    raise AssertionError(f"{method}: {message['error']}")
                return message["result"]
            if message.get("method") == "Runtime.exceptionThrown":
                details = message["params"]["exceptionDetails"]
                self.faults.append(details.get("exception", {}).get("description", details["text"]))
            elif message.get("method") == "Log.entryAdded" and message["params"]["entry"]["level"] == "error":
                self.faults.append(message["params"]["entry"]["text"])

    def ask(self, expression):
        """The value of a JavaScript expression; promises are waited for."""
        result = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in result:
            raise AssertionError(f"{expression}: {result['exceptionDetails'].get('exception', {}).get('description')}")
        return result["result"].get("value")

    def wait(self, expression, seconds=120):
        """Until it is true; returns its value."""
        end = time.monotonic() + seconds
        while True:
            value = self.ask(f"(() => {{ try {{ return {expression}; }} catch (error) {{ return null; }} }})()")  # scripts may not have run yet
            if value:
                return value
            if time.monotonic() > end:
                raise AssertionError(f"not true after {seconds} s: {expression}; the page says: "
                                     f"{self.ask('document.body.innerText')[:1500]!r}; faults: {self.faults}")
            time.sleep(0.05)

    def mouse(self, kind, x, y, button="left", buttons=1, count=1, shift=False, **more):
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button=button, buttons=buttons, clickCount=count,
                  modifiers=8 if shift else 0, **more)

    def drag(self, begin, end, steps=8, **how):
        self.mouse("mousePressed", *begin, **how)
        for i in range(1, steps + 1):
            self.mouse("mouseMoved", *(a + (b - a) * i / steps for a, b in zip(begin, end)), **how)
        self.mouse("mouseReleased", *end, **how)

    def click(self, x, y, count=1):
        self.mouse("mousePressed", x, y, count=count)
        self.mouse("mouseReleased", x, y, count=count)

    def key(self, key, shift=False):
        code = {"ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40, "Tab": 9, "Escape": 27, "Enter": 13}.get(key)
        text = {} if code else {"text": key}
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, modifiers=8 if shift else 0,
                      **({"windowsVirtualKeyCode": code} if code else {}), **(text if kind == "keyDown" else {}))

    def choose(self, element, value):
        """As a person does who changes a control."""
        self.ask(f"(() => {{ const e = document.getElementById('{element}'); e.value = {json.dumps(value)}; "
                 f"e.dispatchEvent(new Event('change', {{bubbles: true}})); }})()")

    def screenshot(self, file):
        data = self.call("Page.captureScreenshot", format="png")["data"]
        with open(file, "wb") as out:
            out.write(base64.b64decode(data))
