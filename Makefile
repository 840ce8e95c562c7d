# Each target does all its own set-up in .venv: `make demo`, `make test`, `make check`, `make site`.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check

.PHONY: demo test slow-test lint types wheel check records site clean-site clean

demo: $(VENV)/.runtime
	$(BIN)/fingerdesign analyse designs/film_tees.toml --out out

test: $(VENV)/.dev
	$(BIN)/python -m pytest -m "not slow" -n auto --dist worksteal --durations=15

slow-test: $(VENV)/.dev
	$(BIN)/python -m pytest -m slow -n auto --dist worksteal --durations=25

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/.dev
	$(BIN)/mypy

wheel: $(VENV)/.dev
	$(BIN)/python -m build --wheel --no-isolation --outdir dist .

check: lint types test slow-test wheel

# The tables of the pages that are made from records.
records: $(VENV)/.dev
	$(BIN)/python -m fingerdesign_bench.known.table

# The documentation with its gallery: warnings, links that lead nowhere among them, are errors.
site: $(VENV)/.docs
	$(BIN)/python -m sphinx -E -a -n -W --keep-going -q -d out/site-kept -b html docs out/site
	@echo "out/site/index.html written"

clean-site:
	rm -rf out/site out/site-kept docs/examples docs/generated

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/.runtime: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(PIP) install --quiet --constraint constraints.txt --editable .
	@touch $@

$(VENV)/.dev: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(PIP) install --quiet --constraint constraints.txt --editable ".[dev]"
	@touch $@ $(VENV)/.runtime

$(VENV)/.docs: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(PIP) install --quiet --constraint constraints.txt --editable ".[docs]"
	@touch $@ $(VENV)/.runtime

clean: clean-site
	rm -rf $(VENV) out dist
