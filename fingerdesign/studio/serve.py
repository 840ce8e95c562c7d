"""The session as a local page: trame's server on the loopback, behind the :mod:`door` of a token.

The page, Vue, Plotly and all else come from installed packages on this machine; a content policy
forbids the browser to ask anything of anybody else.

Needs the extra ``studio`` (``pip install 'fingerdesign[studio]'``), loaded when it is started.
"""

import asyncio
import logging
import os
import sys
from collections.abc import Callable
from importlib.resources import files
from typing import Any

from fingerdesign.runtime.extras import needs
from fingerdesign.studio.door import HOST, close_door, new_token
from fingerdesign.studio.page import TEMPLATES, Page
from fingerdesign.studio.session import Session

CHANGED = ("values", "rest", "trials")  # what the page sets; all else is this module's


async def serve(
    session: Session, token: str, port: int = 0, ready: Callable[[str], None] = lambda address: None
) -> None:
    """Serve the page until it is cancelled; ``ready`` is given the address, token and all.

    Raises MissingExtra without trame.
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
    needs("studio", "trame")
    from trame.app import get_server

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
