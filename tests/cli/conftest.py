"""A command whose work is the test's own."""

import click
import pytest
from fingerdesign_cli.main import cli


@pytest.fixture
def as_check(monkeypatch):
    """``as_check(work)``: ``fingerdesign check`` calls ``work()``."""

    def install(work):
        monkeypatch.setitem(cli.commands, "check", click.Command("check", callback=work))

    return install
