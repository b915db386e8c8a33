# Two commands matter: `make demo` and `make test`. Each does all of its own set-up, once, in .venv.
# Needs Linux on x86_64, python3.11 or python3.12 and its venv module; or a sourced ROS 2 Jazzy.

SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help
MAKEFLAGS += --no-builtin-rules

VENV := .venv
PYTHON := $(VENV)/bin/python
STAMPS := $(VENV)/.stamps

# A sourced ROS is used as it is: its Python, its rclpy. Without one, the wheels of the extra `ros` stand in.
# env -u: the variables of another wheel environment must not leak into the one made here.
CLEAN := env -u _ROS_WHEELS_BOOTSTRAP_COMPLETE
ROS := $(if $(AMENT_PREFIX_PATH),$(shell python3 -c 'import rclpy; print("sourced")' 2>/dev/null))
ifeq ($(ROS),sourced)
  CANDIDATES := python3
  VENV_FLAGS := --system-site-packages
  # Its numpy (1.26 on Ubuntu 24.04) stays, and so does everything ROS; the pandas of constraints.txt needs numpy 2.
  NOT_PINNED := -e '^numpy==' -e '^pandas==' -e '^setuptools==' -e '^ros-'
  FIRST := 'numpy<2'
  EXTRA :=
  KIND := sourced-ros
else
  CANDIDATES := python3.12 python3.11 python3
  VENV_FLAGS :=
  NOT_PINNED := -e '^$$'
  FIRST := setuptools
  EXTRA := [ros]
  KIND := wheels
endif
COMPANIONS := $(addprefix --editable companions/drill_twin_,rig dashboard studies)
PIP := $(CLEAN) $(PYTHON) -m pip install --disable-pip-version-check -qq -c $(STAMPS)/constraints.txt

.PHONY: help setup setup-test demo docs quick test test-long nightly evidence faults faults-seeded kills soak fuzz day damage random-scenes fit-coverage sub-onsets browser bench bounds map-boundary advice-loop peers check clean

help:
	@echo 'make demo       the paper'"'"'s drillstring over DDS: four nodes, a bag, a report in out/demo/'
	@echo 'make docs       the documentation as a site in out/docs/html'
	@echo 'make quick      the short tests that neither start a process nor compile a kernel'
	@echo 'make test       the test suite'
	@echo 'make test-long  variants, soaks and large random samples, and one variant of each test in evidence/'
	@echo 'make nightly    the variants that `make test-long` leaves to the night'
	@echo 'make evidence   the tests of what shows that the twin is right (evidence/), all variants'
	@echo 'make faults     faults of a rig, applied to real processes; prints a table of the results'
	@echo 'make kills      kill -9 of each node, KILLS=50 times, while recording; needs a quiet machine'
	@echo 'make faults-seeded  small faults put into a copy of the package: each is caught by a test of its room'
	@echo 'make soak       an hour of all nodes, with checks of memory and file handles'
	@echo 'make fuzz       10 000 damaged scenes, tables, bags and checkpoints, 12 000 truncations and flips, bombs'
	@echo 'make damage     2 000 truncations and 10 000 flips of bags, checkpoints and metadata; prints a table'
	@echo 'make random-scenes  10 000 random scenes: finite, in the hole, energy accounted for; goes on where it was broken off'
	@echo 'make day        a day of simulated rotation; goes on where it was broken off'
	@echo 'make fit-coverage  90 % intervals of 300 random twins; goes on where it was broken off'
	@echo 'make sub-onsets  onsets from one sub beside their true times, 330 random scenes and motions'
	@echo 'make browser    the pages of drill-twin watch in a headless Chromium'
	@echo 'make bench      speed of the kernel: by effect, by elements, and against earlier runs'
	@echo 'make bounds     the suite without ROS with the lowest and the newest versions of what setup.py asks for'
	@echo 'make map-boundary  error of a map against dense grids of runs; goes on where it was broken off'
	@echo 'make advice-loop  50 random scenes in closed loop with the advice; goes on where it was broken off'
	@echo 'make peers      drill_twin beside PyElastica, Exudyn and MuJoCo (installs them; half an hour)'
	@echo 'make check      lint, types, layers'
	@echo 'make setup      the virtual environment in $(VENV) (the others call it)'
	@echo 'make clean      removes what is generated, except $(VENV) and out/'

$(STAMPS)/venv-$(KIND):
	@found=''; wanted=''; \
	for python in $(CANDIDATES); do \
	  $$python -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 12))' 2>/dev/null || continue; \
	  wanted="$${wanted:-$$python}"; \
	  $$python -c 'import venv, ensurepip' 2>/dev/null || continue; \
	  found=$$python; break; \
	done; \
	if [ -z "$$wanted" ]; then \
	  echo 'error: Python 3.11 or 3.12 is needed; found neither python3.12, python3.11 nor a python3 of that age' >&2; exit 2; \
	elif [ -z "$$found" ]; then \
	  echo "error: $$wanted has no venv module; on Debian and Ubuntu: sudo apt install $$($$wanted -c 'import sys; print("python%d.%d-venv" % sys.version_info[:2])')" >&2; exit 2; \
	fi; \
	if [ $(KIND) = wheels ] && [ "$$(uname -s)/$$(uname -m)" != Linux/x86_64 ]; then \
	  echo "error: the ROS wheels are made for Linux on x86_64, this is $$(uname -s) on $$(uname -m); source a ROS 2 Jazzy and try again" >&2; exit 2; \
	fi; \
	if [ -e $(PYTHON) ] && [ -e $(STAMPS) ] && [ ! -e $@ ]; then \
	  echo 'error: $(VENV) was made $(if $(filter wheels,$(KIND)),with a sourced ROS,without ROS) and does not fit now; remove it: rm -rf $(VENV)' >&2; exit 2; \
	fi; \
	[ -e $(PYTHON) ] || { echo "making $(VENV) with $$($$found --version)"; $(CLEAN) $$found -m venv $(VENV_FLAGS) $(VENV); }
	@mkdir -p $(STAMPS) && touch $(VENV)/COLCON_IGNORE $@

$(STAMPS)/run-$(KIND): $(STAMPS)/venv-$(KIND) constraints.txt setup.py setup.cfg evidence/setup.py $(wildcard companions/*/setup.py)
	@echo 'installing what the twin needs (0.9 GB, a minute or two)'
	@grep -v $(NOT_PINNED) constraints.txt > $(STAMPS)/constraints.txt
	@$(PIP) $(FIRST)
	@$(PIP) --no-build-isolation --editable '.$(EXTRA)' $(COMPANIONS) --editable evidence
	@echo "compiling the physics of the paper's scene (about a minute)"
	@$(PYTHON) -c "from drill_twin.scene import load_scene; from drill_twin.runs import Session; Session(load_scene('pa6_bench'))"
	@touch $@

$(STAMPS)/test-$(KIND): $(STAMPS)/run-$(KIND)
	@echo 'installing what the tests need'
	@$(PIP) --no-build-isolation --editable '.[test]'
	@touch $@

$(STAMPS)/bench-$(KIND): $(STAMPS)/run-$(KIND)
	@echo 'installing what the benchmarks need, the peers included'
	@$(PIP) --no-build-isolation --editable . --editable 'evidence[bench]'
	@touch $@

$(STAMPS)/docs-$(KIND): $(STAMPS)/run-$(KIND)
	@echo 'installing what the documentation needs'
	@$(PIP) --no-build-isolation --editable '.[docs]'
	@touch $@

setup: $(STAMPS)/run-$(KIND)

setup-test: $(STAMPS)/test-$(KIND)

demo: setup
	@$(PYTHON) -m drill_twin.ros demo --out out/demo --replace

# Spelling of pages, help texts and messages (typos); then terms and sentences (docs/style.py) with the site.
# A warning is an error, a reference to nothing too. No network: no inventory of another site is fetched.
docs: $(STAMPS)/docs-$(KIND)
	@$(VENV)/bin/typos README.md CONTRIBUTING.md CHANGELOG.rst QUALITY_DECLARATION.md docs drill_twin companions evidence
	@$(PYTHON) -m sphinx --quiet --builder html --nitpicky --fail-on-warning --keep-going docs out/docs/html
	@echo 'out/docs/html/index.html'

KILLS := 50

# Field checks: a message refuses an int where a float belongs, which the wheels would send as rubbish.
PYTEST := ROS_PYTHON_CHECK_FIELDS=1 $(PYTHON) -m pytest

# Two workers share the files, and three those of the nodes (WITH_ROS), which run beside them with more right to the processor: they wait for
# processes half of their time, which the others fill. A job in the background would ignore Ctrl-C, which some tests send (env).
# A test of processes that fails, or whose worker dies, is run once more and reported as such: a machine that others use may keep a node from its processor for seconds.
# Files in the order of their names, not of their numbers of tests: the few that compile most are then not the last.
# `make test` runs the tests of the package; those of the evidence (`testpaths` has both) go with the long ones.
ROS_PYTEST := $(PYTEST) --reruns 1 --reruns-delay 3 -rR
BESIDE := out/test_without_ros.log
BESIDE_LONG := out/test_long_without_ros.log
WITH_ROS := test/ros $(wildcard companions/*/test/ros)

test: setup-test
	@mkdir -p out; found=0; echo 'with ROS; the tests without ROS run beside these and are shown when both are over'; \
	nice -n 5 env --default-signal=INT $(PYTEST) -n 2 --dist loadfile --no-loadscope-reorder $(addprefix --ignore=,$(WITH_ROS)) test companions > $(BESIDE) 2>&1 & \
	$(ROS_PYTEST) -n 3 --dist loadfile $(WITH_ROS) || found=$$?; \
	wait $$! || found=$$?; \
	cat $(BESIDE); \
	exit $$found

# Tests that neither start a process nor compile, of less than a second each: what one wants after an edit. Who takes longer is listed, and marked slow.
quick: setup-test
	@$(PYTEST) -q $(addprefix --ignore=,$(WITH_ROS)) -m 'not long and not nightly and not slow and not process and not compiles' --durations=5 test companions

# The long tests of nodes wait for most of their time: the others run beside them, with less right to the processor.
test-long: setup-test
	@mkdir -p out; found=0; echo 'long tests with ROS; the others run beside these and are shown when all are over'; \
	( failed=0; \
	  nice -n 5 env --default-signal=INT $(PYTEST) -n 2 --dist loadfile $(addprefix --ignore=,$(WITH_ROS)) -m long test companions || failed=$$?; \
	  nice -n 5 env --default-signal=INT $(PYTEST) -n 2 --dist loadfile evidence/test || failed=$$?; \
	  exit $$failed ) > $(BESIDE_LONG) 2>&1 & \
	$(ROS_PYTEST) -n 2 --dist loadfile $(WITH_ROS) -m long || found=$$?; \
	wait $$! || found=$$?; \
	cat $(BESIDE_LONG); \
	exit $$found

# Variants of the long tests that differ from those in numbers: a change is guarded by some of each, and each night by all.
nightly: setup-test
	@found=0; $(PYTEST) -n 2 --dist loadfile $(addprefix --ignore=,$(WITH_ROS)) -m nightly test companions || found=$$?; \
	$(ROS_PYTEST) -n 2 --dist loadfile $(WITH_ROS) -m nightly || found=$$?; \
	exit $$found

evidence: setup-test
	@$(PYTEST) -n 2 --dist loadfile evidence/test -m 'long or not long'

faults: setup-test
	@DRILL_TWIN_FAULTS=1 $(PYTEST) test/ros -q -m 'fault and (long or not long)'

kills: setup-test
	@DRILL_TWIN_KILLS=$(KILLS) $(PYTEST) test/ros/test_kills.py -q -s -m long

faults-seeded: setup-test
	@$(PYTHON) -m drill_twin_evidence.benchmarks.faults_seeded --page evidence/docs/faults_seeded.md

soak: setup-test
	@DRILL_TWIN_SOAK=3600 $(PYTEST) test/ros/test_faults.py -q -s -m 'long' -k soak

fuzz: setup-test
	@DRILL_TWIN_FUZZ=10000 DRILL_TWIN_DAMAGE=12000 $(PYTHON) -m pytest test/fuzz -q -s -m 'long or not long'

damage: setup-test
	@DRILL_TWIN_DAMAGE=12000 $(PYTHON) -m pytest test/fuzz/test_damage.py -q -s

random-scenes: setup-test
	@nice $(PYTHON) evidence/test/stress/campaign.py --scenes 10000

day: setup-test
	@nice $(PYTHON) evidence/test/stress/day.py

fit-coverage: setup-test
	@nice $(PYTHON) -m drill_twin_evidence.foreign_rigs.interval_coverage 300 out/fit_coverage.jsonl

sub-onsets: setup-test
	@nice $(PYTHON) -m drill_twin_evidence.detection.sub_onsets 330 out/sub_onsets.jsonl

browser: setup-test
	@$(PYTEST) companions/drill_twin_dashboard/test/ros/test_live_page.py companions/drill_twin_dashboard/test/front -q -m 'long or not long'

bench: $(STAMPS)/bench-$(KIND)
	@$(PYTHON) -m pytest evidence/test/benchmarks/kernel_speed.py -q --benchmark-autosave --benchmark-storage=file://.benchmarks
	@$(PYTHON) -m drill_twin_evidence.benchmarks.kernel machine
	@$(PYTHON) -m drill_twin_evidence.benchmarks.kernel growth
	@$(PYTHON) -m drill_twin_evidence.benchmarks.kernel effects

bounds:
	@nice .ci/bounds lowest
	@nice .ci/bounds newest

map-boundary: setup
	@nice $(PYTHON) -m drill_twin_evidence.benchmarks.map_boundary

advice-loop: setup
	@nice $(PYTHON) -m drill_twin_evidence.benchmarks.advice_loop

peers: $(STAMPS)/bench-$(KIND)
	@$(PYTHON) -m drill_twin_evidence.benchmarks.peers

check: setup-test
	@$(PYTHON) -m ruff check .
	@$(PYTHON) -m ruff format --check .
	@$(PYTHON) -m mypy
	@$(VENV)/bin/lint-imports
	@$(PYTHON) .ci/ratchet.py

clean:
	@rm -rf build install log *.egg-info evidence/*.egg-info companions/*/*.egg-info companions/*/build .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
	@find drill_twin companions evidence test config -name __pycache__ -type d -prune -exec rm -rf {} +
