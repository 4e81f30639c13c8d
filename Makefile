# make demo: set up and run the main job.  make test: set up and check everything.  make help: the rest.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/ready
SUDO := $(if $(filter 0,$(shell id -u)),,sudo)
# Our matrices are small: threads of the linear algebra only get in each other's way.
export OPENBLAS_NUM_THREADS ?= 1

.PHONY: help setup demo test lint types format bench twins recordings clean

help:  ## list the commands
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*## /\t/'

# Debian's python3 cannot make virtual environments until python3-venv is there.
$(READY): pyproject.toml constraints.txt
	@$(PYTHON) -m venv $(VENV) > /dev/null 2>&1 \
		|| { echo "installing python3-venv"; $(SUDO) apt-get -qq update && $(SUDO) apt-get -qq install -y python3-venv > /dev/null; \
			$(PYTHON) -m venv $(VENV); } \
		|| { echo "$(PYTHON) cannot make virtual environments: install python3-venv, or set PYTHON=..."; exit 1; }
	@echo "setting up $(VENV) (a minute or two, once)"
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[test]'
	@touch $@

setup: $(READY)  ## install everything into .venv

demo: $(READY)  ## learn give, show and hide from the shipped recordings
	@$(BIN)/taskgist demo

lint: $(READY)  ## linters
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(READY)  ## strict types
	$(BIN)/mypy

test: lint types  ## linters, types and tests
	$(BIN)/pytest -n auto

format: $(READY)  ## format the code and mend what the linter can mend
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

bench: $(READY)  ## speed, as ratios against peers
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[bench]'
	$(BIN)/python -m benchmarks

twins: $(READY)  ## compare fast and slow answers of perspective in COUNT random rooms
	$(BIN)/python -m tools.twins --count $(or $(COUNT),200)

recordings: $(READY)  ## make the shipped recordings anew; KTH=FOLDER for the real ones too
	$(BIN)/python tools/make_recordings.py $(if $(KTH),--kth $(KTH))

clean:  ## remove what setup made
	rm -rf $(VENV) build dist
