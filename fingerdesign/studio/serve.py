"""The session as a local page: trame's server on the loopback, behind the :mod:`door` of a token.

The page, Vue, Plotly and all else come from installed packages on this machine; a content policy
forbids the browser to ask anything of anybody else.

Needs the extra ``studio`` (``pip install 'fingerdesign[studio]'``), loaded when it is started.
"""

from __future__ import annotations

import asyncio
import logging
import os
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from importlib.resources import files
from pathlib import Path
from typing import Any

from fingerdesign.errors import FingerDesignError
from fingerdesign.report.page import COMMON
from fingerdesign.studio.door import HOST, close_door, new_token
from fingerdesign.studio.engine import Refiner
from fingerdesign.studio.session import Session, Shown

MISSING = "the studio needs trame; get it by: pip install 'fingerdesign[studio]'"
_PARTS = Path(__file__).parent / "templates"
CHANGED = ("values", "rest")  # what the page sets; all else is this module's
_LOOK_S = 0.4  # between two looks at the file
_REST_S = 1.2  # without a move: sliders rest
_EMPTY: Shown = {
    **dict.fromkeys(("tractions", "bars", "trace", "shape", "shape_before")),
    **dict.fromkeys(("sketch", "sketch_before", "note", "pinned", "model", "name", "file"), ""),
    **{"verdict": [], "table": [], "faults": [], "sliders": [], "values": {}, "picked": None},
    **{"unsaved": 0, "took_ms": 0, "stamp": 0, "gages": 0, "deep": False},
    **{"refining": False, "rest": False},
}


class MissingLibrary(FingerDesignError):
    """The library of the page is not installed; the message says how to get it."""


class Page:
    """A session bound to trame's state: moves in, pictures out, the newest move first.

    All work is done by one thread next to the server's; what was moved while it works is answered
    next, and only the last of it.
    """

    def __init__(self, session: Session, server: Any) -> None:
        self.session, self.server, self.state = session, server, server.state
        self.refiner = Refiner()
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="studio")
        self._deep = ThreadPoolExecutor(1, thread_name_prefix="studio-3d")
        self._moved: dict[str, Any] | None = None
        self._wake = asyncio.Event()
        self._moves = 0
        self._tasks: set[asyncio.Task[None]] = set()
        self.state.update(_EMPTY)
        look = [COMMON / "report.css", _PARTS / "studio.css"]
        self.state.look = "\n".join(path.read_text("utf-8") for path in look)
        self.state.trame__template_main = (_PARTS / "studio.html").read_text("utf-8")
        self.state.trame__title = "fingerdesign studio"
        self.state.change("values")(self._values)
        for name in ("pick", "pin", "save", "refine"):
            server.trigger(name)(getattr(self, name))

    async def run(self) -> None:
        """Answer moves until it is cancelled."""
        await self._do(self.session.start)
        self._begin(self._watch())
        while True:
            await self._wake.wait()
            self._wake.clear()
            moved, self._moved = self._moved, None
            if moved is not None:
                await self._do(self.session.move, moved)
                self._begin(self._at_rest(self._moves))

    def close(self) -> None:
        """End the work in the background."""
        self.refiner.give_up()
        for task in self._tasks:
            task.cancel()
        self._thread.shutdown(wait=False, cancel_futures=True)
        self._deep.shutdown(wait=False, cancel_futures=True)

    def _values(self, values: dict[str, Any], **_: Any) -> None:
        if values and isinstance(values, dict) and values != self.session.values:
            self._moves += 1
            self._moved = dict(values)
            self.refiner.give_up()
            self._wake.set()

    async def pick(self, plate: int) -> None:
        """A gage was clicked."""
        if isinstance(plate, int):
            await self._do(self.session.pick, plate)

    async def pin(self) -> None:
        """Pin this state, or remove the pin."""
        await self._do(self.session.pin)

    async def save(self) -> None:
        """Write the file."""
        await self._do(self.session.save)

    async def refine(self) -> None:
        """Ask 3-D now; or stop it."""
        if self.state.refining:
            self.refiner.give_up()
        else:
            self.state.refining = True  # before a second press is read
            self._begin(self._refined(self._moves))

    async def _at_rest(self, moves: int) -> None:
        await asyncio.sleep(_REST_S)
        if self.state.rest and moves == self._moves and not self.state.refining:
            await self._refined(moves)

    async def _refined(self, moves: int) -> None:
        """3-D of the present state, shown where nothing was moved since."""
        session = self.session
        given = (session.design, session.press, session.engine.reach)
        with self.state as state:
            state.refining, state.note = True, ""
        loop, note = asyncio.get_running_loop(), ""
        try:
            found = await loop.run_in_executor(self._deep, self.refiner.numbers, *given)
            if moves == self._moves:
                await self._do(session.deep, found)
        except FingerDesignError as error:
            note = str(error) if moves == self._moves else ""
        with self.state as state:
            state.refining, state.note = False, note

    async def _watch(self) -> None:
        while True:
            await asyncio.sleep(_LOOK_S)
            await self._do(self.session.look)

    async def _do(self, work: Callable[..., Shown], *given: Any) -> None:
        """One piece of the session's work, in its thread, then shown."""
        loop = asyncio.get_running_loop()
        shown = await loop.run_in_executor(self._thread, lambda: work(*given))
        if not shown:
            return
        numbers = self.session.numbers
        with self.state as state:
            state.update(shown)
            state.deep = numbers is not None and numbers.dimension == 3
            state.gages = 0 if numbers is None else len(numbers.gage_x)
            state.stamp += 1

    def _begin(self, work: Any) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)


async def serve(
    session: Session,
    token: str,
    port: int = 0,
    ready: Callable[[str], None] = lambda address: None,
) -> None:
    """Serve the page until it is cancelled; ``ready`` is given the address, token and all.

    Raises MissingLibrary without trame.
    """
    server = _server()
    logging.getLogger("aiohttp.server").setLevel(logging.CRITICAL)  # of requests that are none
    page = Page(session, server)
    server.controller.on_server_bind.add(lambda bound: close_door(bound, server, token, CHANGED))
    server.controller.on_server_ready.add(
        lambda **_: ready(f"http://{HOST}:{server.port}/{token}/index.html")
    )
    arguments, sys.argv = sys.argv, sys.argv[:1]  # trame would read the command's own
    given = os.environ.pop("TRAME_ARGS", None)
    try:
        web = server.start(
            port=port,
            host=HOST,
            thread=True,
            open_browser=False,
            show_connection_info=False,
            disable_logging=True,
            exec_mode="coroutine",
            timeout=0,
        )
    finally:
        sys.argv = arguments
        if given is not None:
            os.environ["TRAME_ARGS"] = given
    try:
        await asyncio.gather(web, page.run())
    finally:
        page.close()


def _server() -> Any:
    """A server of trame's with the page's scripts, none of them from elsewhere."""
    try:
        from trame.app import get_server
    except ImportError as error:
        raise MissingLibrary(MISSING) from error
    server = get_server(f"studio-{new_token()}", client_type="vue3")
    plotly = str(files("plotly") / "package_data")
    server.enable_module(
        {
            "serve": {"studio": str(_PARTS), "plotly": plotly},
            "scripts": ["plotly/plotly.min.js", "studio/chart.js"],
            "vue_use": ["fingerdesign_studio"],
        }
    )
    return server
