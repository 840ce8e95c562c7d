"""``fingerdesign studio``: the page on which a finger's numbers follow its sliders."""

from __future__ import annotations

import asyncio
import signal
import socket
import sys
import webbrowser
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import click

from fingerdesign.studio.door import HOST, new_token
from fingerdesign.studio.serve import serve
from fingerdesign.studio.session import Session
from fingerdesign_cli.terminal import quiet


def studio(design_file: Path | None, port: int, no_open: bool) -> int:
    """Serve the studio until it is interrupted."""
    _refuse_taken(port)
    session = Session(design_file)

    def ready(address: str) -> None:
        if not quiet():
            click.echo(f"studio: {address}")
            click.echo("open it in a browser on this machine; Ctrl-C ends it")
        if not no_open:
            webbrowser.open(address)

    asyncio.run(_until_interrupted(session, port, ready))
    return 0


def _refuse_taken(port: int) -> None:
    with socket.socket() as probe:
        if sys.platform != "win32":  # there it would allow a port that is taken
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((HOST, port))
        except OSError as error:
            wrong = f"--port = {port}: must be a port that is free ({error.strerror})"
            raise click.UsageError(f"{wrong}; choose another, or leave it out") from None


async def _until_interrupted(session: Session, port: int, ready: Callable[[str], None]) -> None:
    """Serve; a signal ends it between two pieces of the server's work, and not inside one. Raises
    KeyboardInterrupt where it was ended."""
    loop, task = asyncio.get_running_loop(), asyncio.current_task()
    assert task is not None
    for number in (signal.SIGINT, signal.SIGTERM):
        with suppress(NotImplementedError, RuntimeError, ValueError):  # not on this system
            loop.add_signal_handler(number, task.cancel)
    try:
        await serve(session, new_token(), port, ready)
    except asyncio.CancelledError:
        raise KeyboardInterrupt from None
