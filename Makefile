# Each target does all its own set-up in .venv: `make demo`, `make test`, `make check`, `make site`.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check
# uv resolves and unpacks in a quarter of pip's time. Where it reaches no packages, for an index may
# be set for pip alone, pip does it. Python compiles what is imported: to compile all 14,500 files
# of the libraries takes 35 s.
WITH := --quiet --constraint constraints.txt --editable
install = $(PIP) install --quiet uv && $(BIN)/uv pip install --python $(BIN)/python $(WITH) $(1) || \
  { echo "uv cannot install; pip does" && $(PIP) install --no-compile $(WITH) $(1); }
PYTEST := $(BIN)/python -m pytest -n auto --dist worksteal
# Compiled files stay: without them each worker rewrites 1,500 tests again, 6 s of processor time.
export PYTHONDONTWRITEBYTECODE :=

.PHONY: demo test slow-test every-test coverage lint types wheel check records site clean-site clean

demo: $(VENV)/.runtime
	$(BIN)/fingerdesign analyse designs/film_tees.toml --out out

test: $(VENV)/.dev
	$(PYTEST) -m "not slow" --durations=15

slow-test: $(VENV)/.dev
	$(PYTEST) -m slow --durations=25

# Fast and slow tests in one run: they are collected once, and share meshes and fixtures.
every-test: $(VENV)/.dev
	$(PYTEST) --durations=40

# How much of the code the fast tests run, at least: of forked processes not all is seen.
coverage: $(VENV)/.dev
	$(PIP) install --quiet "pytest-cov>=7" && mkdir -p out
	$(PYTEST) -m "not slow" --cov --cov-report=term:skip-covered --cov-report=html

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/.dev
	$(BIN)/mypy

wheel: $(VENV)/.dev
	$(BIN)/python -m build --wheel --no-isolation --outdir dist .

check: every-test lint types wheel

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
	$(call install,.)
	@touch $@

$(VENV)/.dev: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(call install,".[dev]")
	@touch $@ $(VENV)/.runtime

$(VENV)/.docs: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(call install,".[docs]")
	@touch $@ $(VENV)/.runtime

clean: clean-site
	rm -rf $(VENV) out dist
