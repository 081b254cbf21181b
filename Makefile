# Everything runs in .venv, which is created on first use and updated when pyproject.toml or the lock changes.
SHELL := /bin/bash
PYTHON ?= python3
JOBS ?= logical
VENV := .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.installed
LOCK := requirements.lock
EXTRAS := dev,driver,plot,report,cluster,pandas
UV := .venv-tools/bin/uv
PIP := -m pip install --quiet --disable-pip-version-check
RESOLVE := --no-config --quiet --upgrade
SECONDS ?= 600

# Another active environment, or modules on PYTHONPATH, must not leak into this one.
unexport VIRTUAL_ENV PYTHONPATH PYTHONHOME

.PHONY: help install demo test test-slow test-all test-lowest test-latest fuzz planted changes lint format types layers \
  wheel container schemas lock check clean
.DEFAULT_GOAL := help

help: ## list the targets
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## /  make \1\t/' | expand -t 22

$(patsubst %,%/bin/python,.venv .venv-lowest .venv-latest .venv-tools):
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
	  || { echo "$(PYTHON) is older than 3.11; name another one: make PYTHON=python3.12 ..." >&2; exit 1; }
	$(PYTHON) -m venv $(@D:/bin=)

$(INSTALLED): pyproject.toml $(LOCK) | $(BIN)/python
	$(BIN)/python $(PIP) --require-hashes --requirement $(LOCK)
	$(BIN)/python $(PIP) --no-deps --no-build-isolation --editable .
	@touch $@

install: $(INSTALLED) ## create .venv with the locked versions, the package and its development tools

demo: $(INSTALLED) ## solve the examples of the papers
	@PATH="$(CURDIR)/$(BIN):$$PATH" scripts/demo.sh

test: $(INSTALLED) ## run the quick tests, some minutes: what a developer runs (JOBS=1: one process)
	$(BIN)/cdpr-solve warm-up
	$(BIN)/python -m pytest --numprocesses $(JOBS) -m 'not slow'

test-slow: $(INSTALLED) ## run the other tests
	$(BIN)/cdpr-solve warm-up
	$(BIN)/python -m pytest --numprocesses $(JOBS) -m slow

test-all: test test-slow ## run every test

test-lowest: RESOLUTION := lowest-direct
test-lowest: $(UV) .venv-lowest/bin/python ## run the quick tests with the lowest versions that pyproject.toml allows (Python 3.11)

test-latest: RESOLUTION := highest
test-latest: $(UV) .venv-latest/bin/python ## run the quick tests with the newest versions

test-lowest test-latest: ENVIRONMENT = .venv-$(@:test-%=%)
test-lowest test-latest: export NUMBA_CACHE_DIR = $(CURDIR)/$(ENVIRONMENT)/numba
test-lowest test-latest:
	$(UV) pip install $(RESOLVE) --resolution $(RESOLUTION) --python $(ENVIRONMENT) --editable '.[$(EXTRAS)]'
	rm -rf $(NUMBA_CACHE_DIR)
	$(ENVIRONMENT)/bin/cdpr-solve warm-up
	$(ENVIRONMENT)/bin/python -m pytest --numprocesses $(JOBS) -m 'not slow'

fuzz: $(INSTALLED) ## draw new examples and print what reproduces a failure: make fuzz SECONDS=600 SEED=1
	$(BIN)/python scripts/fuzz.py --seconds $(SECONDS) $(if $(SEED),--seed $(SEED))

changes: $(INSTALLED) ## certificates with one thing changed: none may prove anything false
	$(BIN)/python scripts/single_changes.py 100000 1

planted: $(INSTALLED) ## random robots with known poses: none may be lost
	$(BIN)/python scripts/planted_point_mass.py 300 1
	$(BIN)/python scripts/planted_real.py 120 1
	$(BIN)/python scripts/planted.py --robots 540 --seed 1 --taut-only \
	  --time-limit-per-robot 30 --cell-limit-per-robot 3000000

lint: $(INSTALLED) ## ruff: rules and format
	$(BIN)/ruff check --no-cache .
	$(BIN)/ruff format --no-cache --check .

format: $(INSTALLED) ## let ruff mend what it can
	$(BIN)/ruff check --no-cache --fix .
	$(BIN)/ruff format --no-cache .

types: $(INSTALLED) ## mypy --strict
	$(BIN)/mypy

layers: $(INSTALLED) ## import-linter: who may import whom
	$(BIN)/lint-imports --no-cache

wheel: $(INSTALLED) ## build the wheel and check what is in it
	$(BIN)/python scripts/check_wheel.py

container: ## do what the Dockerfile does, in an empty folder, and ask a question there
	scripts/container_check.sh

schemas: $(INSTALLED) ## write the JSON Schemas anew
	$(BIN)/python scripts/make_schemas.py

$(UV): | .venv-tools/bin/python
	.venv-tools/bin/python $(PIP) uv

lock: $(UV) ## renew requirements.lock: the newest versions, for every platform and Python, with hashes
	$(UV) pip compile $(RESOLVE) --universal --python-version 3.11 --fork-strategy fewest --all-extras \
	  --generate-hashes --custom-compile-command 'make lock' --output-file $(LOCK) pyproject.toml

check: lint types layers wheel container test-all ## everything CI runs

clean: ## remove caches (not the environments)
	find . -path './.venv*' -prune -o -type d \( -name __pycache__ -o -name .hypothesis -o -name .mypy_cache \) \
	  -print0 | xargs -0 rm -rf
