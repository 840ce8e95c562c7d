"""The console script: Ctrl-C while modules load ends it in words."""

import os
import signal
from types import FrameType


def _end(_number: int, _frame: FrameType | None) -> None:
    os.write(2, b"interrupted\n")
    os._exit(130)  # no work has begun; an extension that loads may swallow an exception


def entry_point() -> None:
    """Load the commands and run the one of the command line."""
    if signal.getsignal(signal.SIGINT) != signal.SIG_IGN:  # as under nohup
        signal.signal(signal.SIGINT, _end)
    from fingerdesign_cli.main import entry_point as run

    run()
