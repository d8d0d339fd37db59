# `make help` lists the targets; each sets up what it needs first.
VENV := .venv
PYTHON := $(VENV)/bin/python
STAMP := $(VENV)/complete
COMPILED := $(VENV)/compiled
FULL ?=
LONG ?=
SIMULATOR ?=
RELEASE ?=

# .venv stands alone, whatever the shell has sourced; and each process of many finds what others compiled.
unexport PYTHONPATH PYTHONHOME PYTHONDONTWRITEBYTECODE _ROS_WHEELS_BOOTSTRAP_COMPLETE
ifneq ($(ROS_DISTRO)$(_ROS_WHEELS_BOOTSTRAP_COMPLETE),)
unexport LD_LIBRARY_PATH
endif
export AMENT_PREFIX_PATH := $(CURDIR)/$(VENV)
export RMW_IMPLEMENTATION := rmw_fastrtps_cpp
export ROS_AUTOMATIC_DISCOVERY_RANGE := LOCALHOST
export FULL TRUNK_PYTHON

.PHONY: help setup demo test pytest lint graph rest coverage fuzz bench proof docs lock clean

help:
	@sed -n 's/^\([a-z]*\):.*## /make \1\t/p' $(MAKEFILE_LIST) | expand -t 16

setup: $(STAMP)  ## .venv with all packages at the versions of the lock

$(STAMP): requirements/lock.txt setup.py setup.cfg package.xml tools/make_venv
	@tools/make_venv
	@touch $@

# SIMULATOR=mujoco: a user's own MuJoCo arm in the place of ours.
demo: setup  ## drives an arm with hidden physics, records it, diagnoses it (SIMULATOR=mujoco: a MuJoCo arm)
	$(PYTHON) -m $(if $(filter mujoco,$(SIMULATOR)),test.concealed.simulators.demo,test.concealed.demo)

# Tests of the graph wait for processes most of the time: the rest goes on meanwhile, and yields to them; only
# so much that other work on the machine does not stop it.
YIELDING := nice -n 3
test: setup  ## lint, types, tests (LONG=1: also those that take long)
	@+$(MAKE) --no-print-directory --jobs 3 lint graph rest

pytest: setup
	@+$(MAKE) --no-print-directory --jobs 2 graph rest

lint: setup  ## ruff and mypy
	$(YIELDING) $(PYTHON) -m ruff check .
	$(YIELDING) $(PYTHON) -m mypy

PYTEST := -m pytest -q --timeout 300 --dist loadfile --no-loadscope-reorder $(if $(LONG),,-m 'not long')
GRAPH := test/nodes test/concealed/test_demo.py test/packaging/test_colcon.py
graph rest $(COMPILED): export OMP_NUM_THREADS := 1
graph rest $(COMPILED): export OPENBLAS_NUM_THREADS := 1

# Beside lint, before many processes would each compile the same; what goes wrong here the tests say better.
$(COMPILED): $(STAMP) $(shell find trunk_ros -name '*.py')
	-$(PYTHON) -m test.compiled
	@touch $@

# They start many processes, so only two of them run at a time.
graph: $(COMPILED)
	$(PYTHON) $(PYTEST) -n 2 $(GRAPH)

rest: $(COMPILED)
	$(YIELDING) $(PYTHON) $(PYTEST) -n auto --maxprocesses 4 $(GRAPH:%=--ignore %)

# Lines and branches that the tests without nodes run: coverage.xml, and htmlcov/ to look at.
coverage: setup  ## lines and branches that the tests run; htmlcov/index.html
	$(PYTHON) -m coverage run -m pytest -q --timeout 300 --ignore test/nodes --ignore test/packaging
	$(PYTHON) -m coverage combine -q
	$(PYTHON) -m coverage xml -q
	$(PYTHON) -m coverage html -q
	$(PYTHON) -m coverage report --skip-covered --sort=cover

# A bounded part, with other means, is among the tests: test/recording/test_fuzz.py and test/fuzz.
fuzz: setup  ## hostile files (FULL=1: for hours)
	$(PYTHON) -m test.fuzz

# RELEASE=1 keeps the figures in test/bench/releases/, for later versions to be compared with.
bench: setup  ## speed and memory, compared with the last release (RELEASE=1: writes one)
	$(PYTHON) -m test.bench --output bench.json --compare last $(if $(RELEASE),--release)

# effects.md and its pictures, from the effects themselves.
docs: setup  ## the page of effects, from the code
	$(PYTHON) docs/make_effects.py

proof: setup  ## the diagnosis on concealed arms; takes long (FULL=1: hours)
	$(PYTHON) -m test.concealed.proof
	$(PYTHON) -m test.space_proof $(if $(FULL),,--seconds 100)

# Pins what setup.py and requirements/dev.in ask for. One lock for every CPython: it is made for the oldest.
lock: setup  ## pins the requirements anew
	$(PYTHON) -m pip install --quiet uv
	$(PYTHON) -m uv pip compile setup.py requirements/dev.in --extra ros --extra fleet --extra mujoco --extra tables --extra show --upgrade --quiet --no-header \
		--no-emit-index-url --no-emit-find-links --generate-hashes \
		--python-version 3.11 --python-platform x86_64-manylinux_2_28 --output-file requirements/lock.txt

# proof/ and fuzz/ stay: they take hours.
clean:  ## removes .venv and what was made, but for proof/ and fuzz/
	rm -rf $(VENV) build dist install log *.egg-info .mypy_cache .pytest_cache .ruff_cache .hypothesis demo-output bench.json .coverage* coverage.xml htmlcov
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
