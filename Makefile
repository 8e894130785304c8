# Everything sets itself up: a .venv in this folder, with pinned packages. Python >= 3.11 is all it needs.
SHELL := /bin/sh
PYTHON ?= $(shell command -v python3 || command -v python3.13 || command -v python3.12 || command -v python3.11)
BIN := .venv/bin
PYTEST_ARGS ?=
PYTEST_WORKERS ?= -n auto --maxprocesses 4 # about half the time on two cores
# What another environment (ROS, for one) has on its path must not leak into ours.
unexport PYTHONPATH PYTHONHOME

.DEFAULT_GOAL := help
.PHONY: help setup setup-dev setup-bench demo test lint bench campaign lock clean

help: ## say what can be made
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "make %-10s %s\n", $$1, $$2 }' Makefile

setup: ## make or mend .venv, enough to use holodrive
	@$(if $(PYTHON),,echo "set-up: no python3 found; holodrive needs Python 3.11 or newer: sudo apt install python3 python3-venv" >&2; exit 2)
	@$(PYTHON) tools/setup_venv.py core

setup-dev setup-bench:
	@$(if $(PYTHON),,echo "set-up: no python3 found; holodrive needs Python 3.11 or newer: sudo apt install python3 python3-venv" >&2; exit 2)
	@$(PYTHON) tools/setup_venv.py $(@:setup-%=%)

demo: setup ## drive three robots, replay a recorded one, write out/demo/demo.html
	@$(BIN)/holodrive demo

test: setup-dev ## run the tests (PYTEST_ARGS="-k odometry" for some)
	@$(BIN)/python -m pytest $(PYTEST_WORKERS) $(PYTEST_ARGS)

lint: setup-dev ## style, types and import layers
	@status=0; for check in "ruff check ." "ruff format --check ." mypy lint-imports; do \
		$(BIN)/$$check || status=1; done; exit $$status

bench: setup-bench ## measure what the README claims, against other programs
	@status=0; for script in benchmarks/[!_]*.py; do echo "== $$script"; \
		$(BIN)/python $$script || status=1; done; exit $$status

campaign: setup-dev ## the slow tests: more seeds, more robots
	@$(BIN)/python -m pytest $(PYTEST_WORKERS) -m campaign --hypothesis-profile=campaign $(PYTEST_ARGS)

lock: ## renew requirements*.lock from pyproject.toml (needs uv)
	@uv pip compile pyproject.toml --group build -o requirements.lock $(LOCK_ARGS)
	@uv pip compile pyproject.toml --group dev -c requirements.lock -o requirements-dev.lock $(LOCK_ARGS)
	@uv pip compile pyproject.toml --group bench -c requirements-dev.lock -o requirements-bench.lock $(LOCK_ARGS)

LOCK_ARGS := -q --upgrade --universal --python-version 3.11 --generate-hashes --no-annotate --no-header --no-emit-index-url

clean: ## remove .venv, caches and results
	@rm -rf .venv .venv.lock out build dist holodrive.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	@find . -name __pycache__ -prune -exec rm -rf {} +
