# make        sets up and starts the lab
# make setup  only sets up
# make test   checks everything: format, lint, types, import contract, tests

# The newest Python there is, 3.11 or later.
PYTHON ?= $(shell for p in python3 python3.14 python3.13 python3.12 python3.11 python; do \
	"$$p" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && { echo "$$p"; break; }; done)
BIN := .venv/bin
export PIP_DISABLE_PIP_VERSION_CHECK := 1

.PHONY: lab setup test lint browser clean

lab: setup
	@$(BIN)/pounce lab

setup: .venv/.installed

test: .venv/.installed-test browser lint
	$(BIN)/python -m pytest -n auto --dist loadfile --no-loadscope-reorder

lint: .venv/.installed-test
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/lint-imports --no-cache
	$(BIN)/basedpyright --pythonpath $(BIN)/python

# Chromium from the system's package manager, where that is allowed; tests say so where it is not.
browser:
	@sh .ci/browser

.venv/bin/python:
	@test -n "$(PYTHON)" || { echo "pounce needs Python 3.11 or later, and found none."; exit 1; }
	@$(PYTHON) -m venv .venv || { rm -rf .venv; echo "This Python cannot make virtual environments:\
	 install its venv package (python3-venv on Debian and Ubuntu)."; exit 1; }

.venv/.installed: pyproject.toml .venv/bin/python
	@echo "Installing pounce into .venv (a minute, the first time only) ..."
	@$(BIN)/python -m pip install -qq --editable '.[bench]'
	@echo "Compiling the learner ..."
	@$(BIN)/pounce run timed --trials 1 --json > /dev/null
	@touch $@

.venv/.installed-test: .venv/.installed
	@$(BIN)/python -m pip install -qq --editable '.[test]'
	@touch $@

clean:
	rm -rf .venv
