"""The command line with another evaluator: ``python command_with.py MODULE:FUNCTION ARGUMENT...``.

For studies that are killed: a process of their own, in which jobs are evaluated quickly, or badly.
"""

import functools
import sys

from fingerdesign_cli.main import main
from fingerdesign_cli.studies import search

from fingerdesign.search.run.cluster import Cluster

search.Cluster = functools.partial(Cluster, evaluator=sys.argv[1])
sys.exit(main(sys.argv[2:]))
