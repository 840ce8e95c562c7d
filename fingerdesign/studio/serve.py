"""The session as a local page: trame's server on the loopback, behind a token.

The page, Vue, Plotly and all else come from installed packages on this machine; a content policy
forbids the browser to ask anything of anybody else. Without the token of the address nothing is
answered: not a page, not a script, not a socket. A browser keeps it in a cookie of this port, which
other sites cannot send.

Needs the extra ``studio`` (``pip install 'fingerdesign[studio]'``), loaded when it is started.
"""

from __future__ import annotations

import asyncio
import hmac
import logging
import os
import sys
from collections.abc import Awaitable, Callable
from importlib.resources import files
from ipaddress import ip_address
from typing import TYPE_CHECKING, Any

from fingerdesign.errors import FingerDesignError
from fingerdesign.studio.page import TEMPLATES, Page
from fingerdesign.studio.session import Session

if TYPE_CHECKING:
    from aiohttp.web import Request, StreamResponse

    Handler = Callable[[Request], Awaitable[StreamResponse]]

HOST = "127.0.0.1"
MISSING = "the studio needs trame; get it by: pip install 'fingerdesign[studio]'"
POLICY = (
    "default-src 'self' data: blob:; connect-src 'self'; style-src 'self' 'unsafe-inline'; "
    "script-src 'self' 'unsafe-inline' 'unsafe-eval'; frame-ancestors 'none'; form-action 'none'"
)


class MissingLibrary(FingerDesignError):
    """The library of the page is not installed; the message says how to get it."""


def new_token() -> str:
    """Return a token of 128 random bits."""
    return os.urandom(16).hex()


def guard(token: str) -> list[Any]:
    """Layers before every request: refused without the token; a first one leads to the page."""
    from aiohttp import web

    async def guarded(request: Request, handler: Handler) -> StreamResponse:
        if why := refusal(request, token):
            return web.Response(status=403, text=why)
        response = await handler(request)
        if not response.prepared:
            response.headers["Content-Security-Policy"] = POLICY
            response.headers["Referrer-Policy"] = "no-referrer"
        return response

    async def remembered(request: Request, handler: Handler) -> StreamResponse:
        """The first address carries the token; a cookie carries it from then on."""
        if "token" not in request.query:
            return await handler(request)
        found = web.Response(status=302, headers={"Location": "/index.html"})
        name = _cookie(request)
        found.set_cookie(name, token, httponly=True, samesite="Strict", path="/")
        return found

    return [web.middleware(guarded), web.middleware(remembered)]


def refusal(request: Request, token: str) -> str:
    """Return why a request is refused, "" where it is not.

    It must come from this machine, for this machine by name (no foreign name that was pointed
    here), from no other site's page, with the token in its address or its cookie.
    """
    if not ip_address(request.remote or "0.0.0.0").is_loopback:
        return "this page is for its own machine"
    try:
        host = request.url.host
    except ValueError:  # no address can be made of its Host header
        host = None
    if host not in (HOST, "localhost"):
        return "this page has no such name"
    origin = request.headers.get("Origin")
    if origin is not None and origin != f"{request.url.scheme}://{request.host}":
        return "this page answers no other site"
    given = request.query.get("token") or request.cookies.get(_cookie(request), "")
    if not hmac.compare_digest(given.encode(errors="replace"), token.encode()):
        return "the address lacks its token: take the one that `fingerdesign studio` printed"
    return ""


def _cookie(request: Request) -> str:
    return f"studio-{request.url.port}"


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
    server.controller.on_server_bind.add(lambda bound: bound.app.middlewares.extend(guard(token)))
    server.controller.on_server_ready.add(
        lambda **_: ready(f"http://{HOST}:{server.port}/?token={token}")
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
            "serve": {"studio": str(TEMPLATES), "plotly": plotly},
            "scripts": ["plotly/plotly.min.js", "studio/chart.js"],
            "vue_use": ["fingerdesign_studio"],
        }
    )
    return server
