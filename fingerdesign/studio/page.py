"""The page bound to a session: moves in, pictures out; verdicts and searches next to them."""

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import wraps
from pathlib import Path
from typing import Any

from fingerdesign.errors import FingerDesignError
from fingerdesign.report.page import COMMON
from fingerdesign.studio.engine import numbers_in_3d
from fingerdesign.studio.judge import PLANE, SPACE, judged
from fingerdesign.studio.passing import PassingSearch
from fingerdesign.studio.process import Process
from fingerdesign.studio.session import Session, Shown

TEMPLATES = Path(__file__).parent / "templates"
_LOOK_S = 0.4  # between two looks at the file, or at a search
_JUDGE_S, _REST_S = 0.4, 1.2  # without a move: the finger is judged; 3-D where it is wished
_LIMIT_S = {PLANE: 300.0, SPACE: 900.0}  # Seconds, where nothing else loads the machine.
_MOST_TRIALS = 1000
_EMPTY: Shown = {
    **dict.fromkeys(("tractions", "bars", "trace", "shape", "shape_before", "finding", "search")),
    **dict.fromkeys(("sketch", "sketch_before", "note", "pinned", "model", "name", "file"), ""),
    **{"verdicts": [], "fixes": [], "judged": "", "summary": "", "unjudged": "", "judging": False},
    **{"table": [], "faults": [], "sliders": [], "values": {}, "picked": None, "starts": []},
    **{"unsaved": 0, "took_ms": 0, "stamp": 0, "gages": 0, "deep": False, "undo": 0, "redo": 0},
    **{"refining": False, "rest": False, "searching": False, "trials": 0, "elapsed": 0},
}


class Page:
    """A session bound to trame's state: moves in, pictures out, the newest move first.

    The session's work is done by one thread next to the server's; what was moved while it works is
    answered next, and only the last of it. Verdicts, 3-D and searches have processes of their own.
    """

    def __init__(self, session: Session, server: Any) -> None:
        self.session, self.server, self.state = session, server, server.state
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="studio")
        self._searches = ThreadPoolExecutor(1, thread_name_prefix="studio-search")
        self._judge, self._deep = Process("judge", idle_s=120.0), Process("3d")
        self._search: PassingSearch | None = None
        self._moved: dict[str, Any] | None = None
        self._wake = asyncio.Event()
        self._moves = 0
        self._tasks: set[asyncio.Task[None]] = set()
        self.state.update(_EMPTY)
        look = [COMMON / "report.css", TEMPLATES / "studio.css"]
        self.state.look = "\n".join(path.read_text("utf-8") for path in look)
        self.state.trame__template_main = (TEMPLATES / "studio.html").read_text("utf-8")
        self.state.trame__title = "fingerdesign studio"
        self.state.change("values")(self._values)
        for name in ("pick", "pin", "save", "refine", "search"):
            server.trigger(name)(getattr(self, name))
        for name in ("undo", "redo", "apply", "begin_from"):
            server.trigger(name)(self._changing(getattr(session, name)))

    async def run(self) -> None:
        """Answer moves until it is cancelled."""
        await self._do(self.session.start)
        self._begin(self._watch())
        self._begin(self._judged())
        while True:
            await self._wake.wait()
            self._wake.clear()
            moved, self._moved = self._moved, None
            if moved is not None and self._search is None:
                await self._do(self.session.move, moved)
                self._begin(self._at_rest(self._moves))

    def close(self) -> None:
        """End the work in the background."""
        if self._search is not None:
            self._search.stop()
        for task in self._tasks:
            task.cancel()
        self._judge.close()
        self._deep.close()
        for pool in (self._thread, self._searches):
            pool.shutdown(wait=False, cancel_futures=True)

    def _values(self, values: dict[str, Any], **_: Any) -> None:
        if values and isinstance(values, dict) and values != self.session.values:
            self._changed()
            self._moved = dict(values)
            self._wake.set()

    def _changed(self) -> None:
        self._moves += 1
        self._deep.give_up()

    def _changing(self, work: Callable[..., Shown]) -> Callable[..., Any]:
        """An action that changes the design; none while a search does."""

        @wraps(work)  # The door checks a message against its arguments.
        async def act(*given: Any) -> None:
            if self._search is None:
                self._changed()
                await self._do(work, *(str(each) for each in given))
                self._begin(self._at_rest(self._moves))

        return act

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
            self._deep.give_up()
        elif self._search is None:
            self._begin(self._refined(self._moves))

    async def search(self, trials: int | str = 0) -> None:
        """Begin a search for a finger that passes; or stop it."""
        if self._search is not None:
            self._search.stop()
            return
        try:
            most = min(max(int(trials), 1), _MOST_TRIALS)
        except ValueError:
            most = 1
        self._search = PassingSearch()
        self._begin(self._searched(self._search, most))

    async def _at_rest(self, moves: int) -> None:
        await asyncio.sleep(_JUDGE_S)
        if moves == self._moves:
            await self._judged()
        await asyncio.sleep(_REST_S - _JUDGE_S)
        if self.state.rest and moves == self._moves and not self.state.refining:
            await self._refined(moves)

    async def _judged(self) -> None:
        """The verdicts on the present design; again where it has changed meanwhile."""
        while not (self.state.judging or self._search or self.session.is_judged()):
            moves, design = self._moves, self.session.design
            self._show(judging=True)
            try:
                found: Any = await self._judge.call(judged, design, PLANE, time_s=_LIMIT_S[PLANE])
            except FingerDesignError as error:
                found = str(error)
            self._show(judging=False)
            await self._do(self.session.store, design, PLANE, found)
            if moves != self._moves:
                await asyncio.sleep(_JUDGE_S)

    async def _refined(self, moves: int) -> None:
        """3-D of the present state: the press, then the verdicts, where nothing was moved since."""
        session = self.session
        design, limit = session.design, _LIMIT_S[SPACE]
        self._show(refining=True, note="")
        note = ""
        try:
            given = (design, session.press, session.engine.reach)
            found = await self._deep.call(numbers_in_3d, *given, time_s=limit)
            if moves == self._moves:
                await self._do(session.deep, found)
                view = await self._deep.call(judged, design, SPACE, time_s=limit)
                await self._do(session.store, design, SPACE, view)
        except FingerDesignError as error:
            note = f"3-D: {error}" if moves == self._moves else ""
        self._show(refining=False, note=note)

    async def _searched(self, search: PassingSearch, most: int) -> None:
        """A search for a finger that passes: the controls follow the best so far."""
        self._changed()
        loop, design, note, shown = asyncio.get_running_loop(), self.session.design, "", None
        self._show(searching=True)
        await self._do(self.session.begin_search)
        begin = loop.time()
        running = loop.run_in_executor(self._searches, search.run, design, most)
        while not running.done():
            await asyncio.wait({running}, timeout=_LOOK_S)
            self._show(elapsed=round(loop.time() - begin))
            if search.progress() != shown:
                shown = search.last
                await self._do(self.session.follow, shown)
        try:
            running.result()
        except FingerDesignError as error:
            note = str(error)
        await self._do(self.session.follow, search.last)
        self._search = None
        self._moves += 1
        self._show(searching=False, note=note)
        await self._at_rest(self._moves)

    async def _watch(self) -> None:
        while True:
            await asyncio.sleep(_LOOK_S)
            await self._do(self.session.look)

    async def _do(self, work: Callable[..., Shown], *given: Any) -> None:
        """One piece of the session's work, in its thread, then shown."""
        shown = await asyncio.get_running_loop().run_in_executor(self._thread, work, *given)
        if not shown:
            return
        numbers = self.session.numbers
        deep = numbers is not None and numbers.dimension == 3
        gages = 0 if numbers is None else len(numbers.gage_x)
        self._show(**shown, deep=deep, gages=gages, stamp=self.state.stamp + 1)

    def _show(self, **values: Any) -> None:
        """Set values of the page, and send them."""
        with self.state as state:
            state.update(values)

    def _begin(self, work: Any) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
