# Everything runs in .venv, which is created on first use and updated when pyproject.toml changes.
SHELL := /bin/bash
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.installed

# Another active environment, or modules on PYTHONPATH, must not leak into this one.
unexport VIRTUAL_ENV PYTHONPATH PYTHONHOME

.PHONY: help install demo test planted lint format types layers wheel schemas check clean
.DEFAULT_GOAL := help

help: ## list the targets
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z]+):.*## /  make \1\t/' | expand -t 18

$(INSTALLED): pyproject.toml
	@test -x $(BIN)/python || { $(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
	  || { echo "$(PYTHON) is older than 3.11; name another one: make PYTHON=python3.12 ..." >&2; exit 1; }; \
	  $(PYTHON) -m venv $(VENV); }
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev,driver,plot,report,cluster]'
	@touch $@

install: $(INSTALLED) ## create .venv and install the package with its development tools

demo: $(INSTALLED) ## solve the examples of the papers
	@PATH="$(CURDIR)/$(BIN):$$PATH" scripts/demo.sh

test: $(INSTALLED) ## run the test suite
	$(BIN)/python -m pytest

planted: $(INSTALLED) ## random robots with known poses: none may be lost
	$(BIN)/python scripts/planted_point_mass.py 300 1
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

schemas: $(INSTALLED) ## write the JSON Schemas anew
	$(BIN)/python scripts/make_schemas.py

check: lint types layers wheel test ## everything CI runs

clean: ## remove caches (not .venv)
	find . -path ./$(VENV) -prune -o -type d \( -name __pycache__ -o -name .hypothesis -o -name .mypy_cache \) \
	  -print0 | xargs -0 rm -rf
