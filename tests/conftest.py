"""Fixtures that several folders of tests share stand in tests/support."""

pytest_plugins = ["tests.support.session"]

collect_ignore = ["support"]  # its modules are no tests; those of plug-ins register toys
