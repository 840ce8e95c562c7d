"""``fingerdesign studio``: the page on which a finger's numbers follow its sliders."""

from __future__ import annotations

import asyncio
import webbrowser
from pathlib import Path

import click

from fingerdesign.studio.serve import new_token, serve
from fingerdesign.studio.session import Session


def studio(design_file: Path | None, port: int, open_browser: bool, quiet: bool) -> int:
    """Serve the studio until it is interrupted."""
    session = Session(design_file)

    def ready(address: str) -> None:
        if not quiet:
            click.echo(f"studio: {address}")
            click.echo("open it in a browser on this machine; Ctrl-C ends it")
        if open_browser:
            webbrowser.open(address)

    asyncio.run(serve(session, new_token(), port, ready))
    return 0
