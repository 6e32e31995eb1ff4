# make                   sets up and starts the lab
# make setup             only sets up
# make check             format, lint, imports and types
# make test              everything: make check and all tests
# make test AREA=charts  one folder of tests, and nothing else
# make replication       runs all experiments of the replication and rewrites its pages
# make baseline          lists anew what old files get wrong in types

# The newest Python there is, 3.11 or later.
PYTHON ?= $(shell for p in python3 python3.14 python3.13 python3.12 python3.11 python; do \
	"$$p" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && { echo "$$p"; break; }; done)
BIN := .venv/bin
export PIP_DISABLE_PIP_VERSION_CHECK := 1

.PHONY: lab setup test check format lint imports types baseline replication browser clean

lab: setup
	@$(BIN)/pounce lab

setup: .venv/.installed

ifdef AREA
test: .venv/.installed-test
	@test -d tests/$(AREA) || { echo "There is no folder tests/$(AREA)."; exit 2; }
	$(BIN)/python -m pytest -n auto --dist loadfile tests/$(AREA)
else
test: .venv/.installed-test browser check
	$(BIN)/python -m pytest -n auto --dist loadfile --no-loadscope-reorder
endif

# All four at once, since one of them takes nearly all of the time.
check: .venv/.installed-test
	@$(MAKE) --no-print-directory --jobs=4 --keep-going format lint imports types

format:
	@$(BIN)/ruff format --check .

lint:
	@$(BIN)/ruff check .

imports:
	@$(BIN)/lint-imports --no-cache

# A baseline that lists more than is still wrong is no error, here and in continuous integration.
types:
	@$(BIN)/basedpyright --pythonpath $(BIN)/python --baselinemode=discard

replication: setup
	@$(BIN)/pounce replicate --force --docs docs

baseline: .venv/.installed-test
	-@$(BIN)/basedpyright --pythonpath $(BIN)/python --writebaseline > /dev/null
	@git --no-pager diff --stat .basedpyright

# Chromium from the system's package manager, where that is allowed; tests say so where it is not.
browser: .venv/.installed
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
