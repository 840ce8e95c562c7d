"""The studio's door: who may come in, and what a message of the page may hold.

The page lies below a path that nobody can guess, ``/TOKEN/``. Nothing else is answered: not a page,
not a script, not a socket. There is no cookie: browsers send those to every port of a machine.
A message is one whole frame of at most ``MOST_BYTES``, for a method with arguments that fit; any
other closes its connection.
"""

from __future__ import annotations

import hmac
import inspect
import os
from collections.abc import Awaitable, Callable, Collection
from ipaddress import ip_address
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from aiohttp.web import Request, StreamResponse

    Handler = Callable[[Request], Awaitable[StreamResponse]]

HOST = "127.0.0.1"
POLICY = (
    "default-src 'self' data: blob:; connect-src 'self'; style-src 'self' 'unsafe-inline'; "
    "script-src 'self' 'unsafe-inline' 'unsafe-eval'; frame-ancestors 'none'; form-action 'none'"
)
MOST_BYTES = 65_536  # of a message; the page's longest, all sliders' values, has under 2,000
MOST_PAGES = 16  # that are open at once
_METHODS = ("wslink.hello", "trame.state.get", "trame.lifecycle.update", "trame.error.client")
_HEADER = 12  # bytes of wslink's: id, offset, whole size; each four, the least first
_POLICY_VIOLATION = 1008  # of RFC 6455


def new_token() -> str:
    """Return a token of 128 random bits."""
    return os.urandom(16).hex()


def close_door(bound: Any, server: Any, token: str, changed: Collection[str]) -> None:
    """Put a bound server of wslink's below ``/token/``, with a guard before it.

    bound: wslink's, before it starts; server: trame's; changed: the state's keys that a page sets.
    """
    from aiohttp import web

    page = bound.app
    page.add_routes(bound._default_routes)  # a sub-application takes none later
    bound._default_routes = []
    outer = web.Application(middlewares=guard(token), client_max_size=MOST_BYTES)
    outer.add_subapp(f"/{token}", page)
    bound.set_app(outer)
    for handler in bound._ws_handlers:
        _close_to_garbage(handler, server, changed)


def guard(token: str) -> list[Any]:
    """The layer before every request: refused without the token, 4xx where it makes no sense."""
    from aiohttp import web

    open_pages = 0

    async def guarded(request: Request, handler: Handler) -> StreamResponse:
        nonlocal open_pages
        if why := refusal(request, token):
            return web.Response(status=403, text=why)
        socket = request.path == f"/{token}/ws"
        if socket and not web.WebSocketResponse().can_prepare(request).ok:
            return web.Response(status=400, text="this address takes web sockets only")
        if socket and open_pages >= MOST_PAGES:
            return web.Response(status=429, text=f"at most {MOST_PAGES} pages; close one")
        open_pages += socket
        try:
            response = await handler(request)
        except (ValueError, OSError):  # names that no file can have
            return web.Response(status=400, text="there is no such address")
        finally:
            open_pages -= socket
        if not response.prepared:
            response.headers["Content-Security-Policy"] = POLICY
            response.headers["Referrer-Policy"] = "no-referrer"
        return response

    return [web.middleware(guarded)]


def refusal(request: Request, token: str) -> str:
    """Return why a request is refused, "" where it is not.

    It must come from this machine, for this machine by name (no foreign name that was pointed
    here), from no other site's page, with the token as the first part of its path.
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
    given = request.path.partition("/")[2].partition("/")[0]
    if not hmac.compare_digest(given.encode(errors="replace"), token.encode()):
        return "the address lacks its token: take the one that `fingerdesign studio` printed"
    return ""


def message_fault(data: Any, server: Any, changed: Collection[str]) -> str:
    """Return why a message of a socket is refused, "" where it is not.

    data: the bytes of a frame, the header of wslink's first. server, changed: as of
    :func:`close_door`. No more memory than the frame's is taken, whatever its header claims.
    """
    import msgpack

    if not isinstance(data, bytes) or not _HEADER < len(data) <= MOST_BYTES:
        return f"a message has at most {MOST_BYTES} bytes"
    offset, size = (int.from_bytes(data[at : at + 4], "little") for at in (4, 8))
    if (offset, size) != (0, len(data) - _HEADER):
        return "a message comes whole"
    try:
        found = msgpack.unpackb(data[_HEADER:])
    except (ValueError, TypeError, RecursionError):  # msgpack's own are ValueErrors
        return "a message is MessagePack"
    if not (
        isinstance(found, dict) and all(isinstance(found.get(k), str) for k in ("id", "method"))
    ):
        return "a message has an id and a method"
    given = found.get("args", [])
    if not (isinstance(given, list) and isinstance(found.get("kwargs", {}), dict)):
        return "a method has arguments"
    return _call_fault(found["method"], given, server, changed)


def _call_fault(method: str, given: list[Any], server: Any, changed: Collection[str]) -> str:
    """Return why a call is refused, "" where it is not; methods that wslink does not know it
    answers itself, as it does those that are not written here."""
    if method == "trame.trigger":
        kinds = (str, list, dict)
        if len(given) != 3 or not all(map(isinstance, given, kinds)):
            return "an action has a name and arguments"
        action = server.controller.trigger_fn(given[0])
        if action is None or not _fits(action, *given[1:]):
            return "there is no such action"
    elif method == "trame.state.update":
        rows = given[0] if len(given) == 1 and isinstance(given[0], list) else [None]
        if not all(isinstance(row, dict) and row.get("key") in changed for row in rows):
            return f"a page sets {', '.join(changed)}"
    elif method not in _METHODS:
        return "there is no such method"
    return ""


def _fits(action: Callable[..., Any], given: list[Any], named: dict[Any, Any]) -> bool:
    """Tell whether an action can be called with these arguments."""
    try:
        inspect.signature(action).bind(*given, **named)
    except TypeError:
        return False
    return True


def _close_to_garbage(handler: Any, server: Any, changed: Collection[str]) -> None:
    """Let a handler of wslink's take sound messages alone; a socket with another is closed."""
    taken = handler.onMessage

    async def take(is_binary: bool, message: Any, client: str) -> None:
        why = message_fault(message.data, server, changed)
        if not why:
            await taken(is_binary, message, client)
            return
        await handler.connections[client].close(code=_POLICY_VIOLATION, message=why.encode())

    handler.onMessage = take
