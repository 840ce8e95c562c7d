"""The benchmarks' tests stand on what those of the product stand on."""

pytest_plugins = ["tests.support.session"]
