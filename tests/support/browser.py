"""A page in a real headless Chromium, driven by its DevTools protocol: clicks, keys, time, silence.

    with Browser(page, work) as browser:
        browser.click("#sort-name")
        assert browser.evaluate("document.title") == "..."
        assert browser.console == [] and browser.requests == []

https://chromedevtools.github.io/devtools-protocol/ names the methods. Needs Chromium on the PATH.
"""

import asyncio
import base64
import contextlib
import json
import shutil
import subprocess
import time
import urllib.request
from typing import Any

from fingerdesign.errors import FingerDesignError

# Other tests use the cores at the same time: a limit ends what hangs, and measures no speed.
START_S, ANSWER_S = 120.0, 300.0
LARGEST_MESSAGE = 200_000_000  # bytes: a whole page's text may come back
_KEYS = {
    "Enter": ("Enter", 13, "\r"),
    "Tab": ("Tab", 9, ""),
    " ": ("Space", 32, " "),
    "Escape": ("Escape", 27, ""),
    "ArrowLeft": ("ArrowLeft", 37, ""),
    "ArrowUp": ("ArrowUp", 38, ""),
    "ArrowRight": ("ArrowRight", 39, ""),
    "ArrowDown": ("ArrowDown", 40, ""),
    "Home": ("Home", 36, ""),
    "End": ("End", 35, ""),
}


class BrowserError(FingerDesignError):
    """No browser, or one that does not answer, or a script of the page's that threw."""


class NotYetError(AssertionError):
    """What a test waits for did not become true in its time."""


def chromium():
    """The browser's path, None where there is none."""
    return shutil.which("chromium") or shutil.which("chromium-browser")


class Browser:
    """One page, a file or a local server's address, open while the block lasts.

    console: messages and errors of the page. requests: addresses that it requested,
    other than its own and data:. Downloads go to ``work/downloads``.
    """

    def __init__(self, page, work, size=(1400, 1000)):
        self.page, self.work, self.size = page, work, size
        self.console: list[str] = []
        self.requests: list[str] = []
        self._number = 0

    def __enter__(self):
        program = chromium()
        if program is None:
            raise BrowserError("there is no Chromium on the PATH")
        profile = self.work / "profile"
        (self.work / "downloads").mkdir(parents=True, exist_ok=True)
        width, height = self.size
        self._process = subprocess.Popen(
            [
                *(program, "--headless=new", "--no-sandbox", "--remote-debugging-port=0"),
                *("--disable-background-networking", "--disable-component-update"),
                *(
                    "--no-first-run",
                    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
                    "--mute-audio",
                ),
                *(f"--user-data-dir={profile}", f"--window-size={width},{height}"),
                *("--disable-gpu", "--enable-unsafe-swiftshader"),  # WebGL without a card
                # What no test needs takes a sixth of its processor time.
                *("--disable-extensions", "--disable-sync", "--disable-breakpad"),
                *("--renderer-process-limit=1", "--in-process-gpu"),
                "--disable-features=Translate,OptimizationHints,MediaRouter,BackForwardCache",
                "about:blank",
            ],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self._loop = asyncio.new_event_loop()
        try:
            self._socket = self._run(self._connected(self._address(profile)))
            self._open()
        except BaseException:
            self._end()
            raise
        return self

    def __exit__(self, kind, error, trace):
        self._end()

    def goto(self, page, size=(1400, 1000)):
        """Open another page in the same window; console and requests are forgotten."""
        width, height = size
        screen = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.call("Emulation.setDeviceMetricsOverride", **screen)
        self.page, self._loaded = page, False
        self.console.clear()
        self.requests.clear()
        begin = time.monotonic()
        self.call("Page.navigate", url=self._page_address())
        while not self._loaded:
            if time.monotonic() - begin > ANSWER_S:
                raise BrowserError(f"{page} did not open in {ANSWER_S:g} s")
            self._run(self._hear())

    def evaluate(self, script):
        """The value (JSON) of a JavaScript expression, awaited where it is a promise."""
        requested = {"expression": script, "returnByValue": True, "awaitPromise": True}
        found = self.call("Runtime.evaluate", **requested, userGesture=True)
        if "exceptionDetails" in found:
            raise BrowserError(f"{script[:200]}: {_thrown(found['exceptionDetails'])}")
        return found["result"].get("value")

    def wait(self, ready, timeout_s=ANSWER_S):
        """Until an expression is true."""
        end = time.monotonic() + timeout_s
        while not self.evaluate(f"Boolean({ready})"):
            if time.monotonic() > end:
                raise NotYetError(f"never true: {ready}")
            time.sleep(0.05)

    def show(self, place):
        """Scroll the element of that id into the middle of the window."""
        self._center(f"document.getElementById('{place}')")

    def change(self, place, value, event="input"):
        """Give a field a value as a user would."""
        self.evaluate(
            f"(() => {{ const e = document.getElementById('{place}'); e.value = {value};"
            f"e.dispatchEvent(new Event('{event}')); }})()"
        )

    def click(self, selector):
        """A real press of the mouse in the middle of the first element, scrolled into view."""
        place = self._center(f"document.querySelector({json.dumps(selector)})")
        if not place:
            raise BrowserError(f"the page has no {selector}")
        self.press_at(*place)

    def _center(self, element):
        """Scroll an element into the middle of the window; the place of its own middle, px."""
        return self.evaluate(
            f"(async () => {{ const e = {element};"
            "if (!e) return 0;"
            "e.scrollIntoView({block: 'center', inline: 'center', behavior: 'instant'});"
            # What comes into sight may be drawn now, and move the rest.
            "for (let k = 0; k < 2; k += 1) await new Promise(requestAnimationFrame);"
            "const r = e.getBoundingClientRect();"
            "return [r.x + r.width / 2, r.y + r.height / 2]; })()"
        )

    def press_until(self, place, ready):
        """Press at the place that ``place()`` computes anew, px, until an expression is true.

        A chart that is being drawn may move, and loses the press: a user presses again.
        """
        for wait_s in (10.0, 20.0, 40.0):
            self.press_at(*place())
            with contextlib.suppress(NotYetError):
                return self.wait(ready, wait_s)
        raise NotYetError(f"never true, though pressed three times: {ready}")

    def press_at(self, x, y, to=None):
        """Press the mouse at a place of the window, px; with ``to``, drag it there."""
        mouse = {"button": "left", "clickCount": 1}
        self.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)
        self.call("Input.dispatchMouseEvent", type="mousePressed", x=x, y=y, **mouse)
        for part in (0.5, 1.0) if to else ():
            at = {"x": x + part * (to[0] - x), "y": y + part * (to[1] - y)} if to else {}
            self.call("Input.dispatchMouseEvent", type="mouseMoved", **at, button="left", buttons=1)
        x, y = to or (x, y)
        self.call("Input.dispatchMouseEvent", type="mouseReleased", x=x, y=y, **mouse)

    def key(self, name, times=1):
        """A real stroke of a key on whatever has the focus: "Tab", "ArrowDown", "a", ..."""
        code, number, text = _KEYS.get(name, ("", ord(name[0].upper()), name))
        held = {"key": name, "code": code, "windowsVirtualKeyCode": number}
        for _ in range(times):
            down = "keyDown" if text else "rawKeyDown"
            self.call(
                "Input.dispatchKeyEvent", type=down, **held, **({"text": text} if text else {})
            )
            self.call("Input.dispatchKeyEvent", type="keyUp", **held)

    def write(self, text):
        """Type a text into what has the focus."""
        self.call("Input.insertText", text=text)

    def appear(self, dark=False, paper=False, still=False):
        """Light or dark; as on paper; with the wish for reduced motion."""
        features = [
            {"name": "prefers-color-scheme", "value": "dark" if dark else "light"},
            {"name": "prefers-reduced-motion", "value": "reduce" if still else "no-preference"},
        ]
        self.call("Emulation.setEmulatedMedia", media="print" if paper else "", features=features)

    def pdf(self, path):
        """The page as it is printed."""
        found = self.call("Page.printToPDF", preferCSSPageSize=True)
        path.write_bytes(base64.b64decode(found["data"]))
        return path

    def downloaded(self, name, timeout_s=START_S):
        """The file that was downloaded under this name."""
        path = self.work / "downloads" / name
        end = time.monotonic() + timeout_s
        while not (path.is_file() and path.stat().st_size):  # first an empty one
            if time.monotonic() > end:
                raise BrowserError(f"{name} was not downloaded")
            time.sleep(0.02)
        return path

    def call(self, method, **parameters):
        """One call of the protocol, and its answer."""
        self._number += 1
        number = self._number
        message = json.dumps({"id": number, "method": method, "params": parameters})
        answer: dict[str, Any] = self._run(self._answer(message, number))
        if "error" in answer:
            raise BrowserError(f"{method}: {answer['error'].get('message')}")
        found: dict[str, Any] = answer.get("result", {})
        return found

    def _open(self):
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.call(f"{domain}.enable")
        where = str(self.work / "downloads")
        self.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=where)
        self.goto(self.page, self.size)

    def _address(self, profile):
        """Where the page's own socket is."""
        reported, end = profile / "DevToolsActivePort", time.monotonic() + START_S
        while time.monotonic() < end:
            lines = reported.read_text("ascii").splitlines() if reported.is_file() else []
            if len(lines) == 2:
                url = f"http://127.0.0.1:{lines[0]}/json/list"
                with urllib.request.urlopen(url, timeout=START_S) as answer:
                    pages = [each for each in json.load(answer) if each["type"] == "page"]
                if pages:
                    return str(pages[0]["webSocketDebuggerUrl"])
            time.sleep(0.02)
        raise BrowserError(f"Chromium did not start in {START_S:g} s")

    async def _connected(self, address):
        from tornado.websocket import websocket_connect

        return await websocket_connect(address, max_message_size=LARGEST_MESSAGE)

    async def _answer(self, message, number):
        await self._socket.write_message(message)
        while True:
            found = await self._hear()
            if found.get("id") == number:
                return found

    async def _hear(self):
        try:
            text = await asyncio.wait_for(self._socket.read_message(), ANSWER_S)
        except TimeoutError as error:
            raise BrowserError(f"the browser was silent for {ANSWER_S:g} s") from error
        if text is None:
            raise BrowserError("the browser has gone")
        found: dict[str, Any] = json.loads(text)
        self._note(found.get("method", ""), found.get("params", {}))
        return found

    def _note(self, event, reported):
        if event == "Page.loadEventFired":
            self._loaded = True
        elif event == "Runtime.consoleAPICalled":
            values = (str(each.get("value", each.get("description"))) for each in reported["args"])
            self.console.append(f"{reported['type']}: {' '.join(values)}")
        elif event == "Runtime.exceptionThrown":
            self.console.append(_thrown(reported["exceptionDetails"]))
        elif event == "Log.entryAdded" and reported["entry"]["source"] != "rendering":
            # "rendering": how fast WebGL is without a card says nothing of the page.
            self.console.append(f"{reported['entry']['level']}: {reported['entry']['text']}")
        elif event == "Network.requestWillBeSent":
            address = reported["request"]["url"]
            own = address.split("#")[0] == self._page_address()
            own = own or address.startswith(self._own_server())
            if not own and not address.startswith(("data:", "blob:", "about:")):
                self.requests.append(address)

    def _page_address(self):
        return self.page if isinstance(self.page, str) else self.page.absolute().as_uri()

    def _own_server(self):
        """What addresses of the page's own server begin with; of a file's page none do."""
        if not isinstance(self.page, str):
            return ()
        scheme, _, rest = self.page.partition("://")
        host = rest.partition("/")[0]
        return (f"{scheme}://{host}/", f"ws://{host}/")

    def _run(self, work):
        return self._loop.run_until_complete(work)

    async def _closed(self):
        self._socket.close()  # needs a running loop: another test's asyncio.run has left none
        await asyncio.sleep(0.05)

    def _end(self):
        if hasattr(self, "_socket"):
            self._run(self._closed())
        self._process.terminate()
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._loop.close()


def _thrown(details):
    described = details.get("exception", {}).get("description")
    return str(described or details.get("text"))
