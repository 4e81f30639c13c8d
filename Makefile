# make demo: set up and run the main job.  make test: set up and check everything.  make help: the rest.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# Each worker begins with a half of the tests in their order, so that what files share is made once.
PYTEST := $(BIN)/pytest -n auto --dist worksteal
READY := $(VENV)/ready
SUDO := $(if $(filter 0,$(shell id -u)),,sudo)
# Our matrices are small: threads of the linear algebra only get in each other's way.
export OPENBLAS_NUM_THREADS ?= 1
# MkDocs' theme advertises its successor.
export NO_MKDOCS_2_WARNING := 1

# Folders and files of tests that say in half a minute whether something essential broke.
QUICK := $(addprefix tests/, test_architecture.py facts learning language store recognition pipeline/test_symmetries.py \
	perspective/test_perspective_laws.py perspective/test_perspective_queries.py cli/test_query.py cli/test_surface.py)

.PHONY: help setup demo test quick coverage lint types format docs wheel bench record twins fuzz recordings clean

help:  ## list the commands
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*## /\t/' | expand -t 12

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
	@$(BIN)/taskgist demo --replace

lint: $(READY)  ## linters
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(READY)  ## strict types
	$(BIN)/mypy -n auto

test: lint types  ## linters, types and tests
	$(PYTEST)

quick: $(READY)  ## laws, facts, learning, and one question of each kind, in under half a minute
	$(PYTEST) $(QUICK)

coverage: $(READY)  ## how much of the code the tests run (compiled loops cannot be traced), and which lines they do not
	$(PYTEST) --cov --cov-report=term:skip-covered --cov-report=html:build/coverage

format: $(READY)  ## format the code and mend what the linter can mend
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

docs: $(READY)  ## the pages as a site in build/site; a warning is an error
	@$(BIN)/python -m tools.reference_pages
	$(BIN)/mkdocs build --strict --quiet
	@echo "built: build/site/index.html"

wheel: $(READY)  ## build the wheel, and run it installed elsewhere, by another user
	$(BIN)/python -m tools.installed

bench: $(READY)  ## speed, as ratios against peers and against what was recorded
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[bench]'
	$(BIN)/python -m benchmarks

record: $(READY)  ## keep the ratios of the last bench as those that the next one is compared with
	$(BIN)/python -m benchmarks.record

twins: $(READY)  ## compare fast and slow answers of perspective in COUNT random rooms
	$(BIN)/python -m tools.twins --count $(or $(COUNT),200)

fuzz: $(READY)  ## spoil inputs of every kind, CASES of them (10,000) from SEED on, and look what commands make of them
	$(BIN)/python -m tools.fuzz --cases $(or $(CASES),10000) --seed $(or $(SEED),0)

recordings: $(READY)  ## make the shipped recordings anew; KTH=FOLDER for the real ones too
	$(BIN)/python tools/make_recordings.py $(if $(KTH),--kth $(KTH))

clean:  ## remove what setup made
	rm -rf $(VENV) build dist
