"""The command line in this process."""

import pytest
from fingerdesign_cli.main import main


@pytest.fixture
def said(capsys):
    """Run the command line to an exit code; what was said by then, on ``out`` and ``err``."""

    def run(*arguments, code=0):
        assert main([str(each) for each in arguments]) == code
        return capsys.readouterr()

    return run
