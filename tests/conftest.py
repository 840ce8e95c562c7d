"""Fixtures that several folders of tests share stand in tests/support."""

pytest_plugins = ["tests.support.closed_form_analysis", "tests.support.closed_form_plants"]

collect_ignore = ["support"]  # its modules are no tests; those of plug-ins register toys
