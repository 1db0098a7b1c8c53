# Set-up, demonstration and checks. `make help` lists the targets.
#
# Everything goes into the virtual environment .venv. Each step of the set-up leaves a stamp there
# and runs again only when its dependencies have changed.
#
# The package is installed editable: commands, nodes and tests run the single copy of the code in
# the checkout, so an edit takes effect at once, the tests run the code that flies, and the kernels,
# whose cache lies beside their source, are compiled once. pip omits the data files from an
# editable installation; they are linked, as with `colcon build --symlink-install`.

VENV := .venv
STAMPS := $(VENV)/stamps
BIN := $(VENV)/bin
SHARE := $(VENV)/share
TIMES := $(STAMPS)/times
PYTHON ?=

# $(call timed,WHAT,COMMAND): print WHAT, run COMMAND, and note its time for the summary of the set-up.
timed = echo "== $(1)"; begun=$$(date +%s); $(2) && printf '%6d s  %s\n' $$(($$(date +%s) - begun)) "$(1)" >>$(TIMES)

MESSAGES := msg_defs/package.xml msg_defs/CMakeLists.txt $(wildcard msg_defs/*/*.msg msg_defs/*/*.action)
KERNELS := $(shell find spacecraft_gnc -name '_*kernels.py')

export PIP_DISABLE_PIP_VERSION_CHECK := 1
export PIP_NO_INPUT := 1

# The environment of the calling shell must not leak into this one. The wheels put their
# libraries on LD_LIBRARY_PATH; those of a sourced ROS 2 would conflict with them.
ifneq ($(AMENT_PREFIX_PATH)$(_ROS_WHEELS_BOOTSTRAP_COMPLETE),)
unexport LD_LIBRARY_PATH
endif
unexport AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH PYTHONHOME PYTHONPATH VIRTUAL_ENV
unexport _ROS_WHEELS_BOOTSTRAP_COMPLETE
# Installed modules are compiled once; a command that compiles numba's modules again takes twice as long.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help setup prepared demo test lint bench colcon lock clean

help: ## list the targets
	@sed -n 's/^\([a-z]*\):[^#]*## \(.*\)/  make \1\t\2/p' $(firstword $(MAKEFILE_LIST)) | expand -t 16

setup: ## install everything into .venv, build the messages, compile the kernels
	@$(MAKE) --no-print-directory --jobs=2 prepared
	@if [ -f $(TIMES) ]; then echo "== set up; it took"; sort -n $(TIMES); rm -f $(TIMES); fi

prepared: $(STAMPS)/messages $(STAMPS)/kernels
	@:

demo: setup ## fly a published case and a slew past two zones through the node graph, record, audit, compare, plot them
	@$(BIN)/python tools/demo.py

test: lint ## set up, check style and types, run every test
	@$(BIN)/python -m pytest --durations 10 -m graph
	@$(BIN)/python -m pytest --durations 10 -m "not graph" --numprocesses auto --maxprocesses 4 --dist loadfile

lint: setup ## check style and types
	@$(BIN)/ruff check
	@$(BIN)/ruff format --check
	@$(BIN)/mypy

bench: setup .venv-peers/installed .venv-acados/installed ## measure the speed of solver, closed loop and graph, and of other solvers
	@$(BIN)/gnc bench

colcon: setup ## build both packages with colcon into build/ and install/
	@tools/colcon_build.sh $(VENV)

COMPILE = pip compile --universal --python-version 3.10 --generate-hashes --no-emit-index-url --no-emit-find-links \
	--custom-compile-command "make lock" --quiet $(UPGRADE)
UPGRADE := --upgrade

lock: $(STAMPS)/environment ## resolve the dependencies into the lock files; UPGRADE= keeps locked versions
	@$(BIN)/python -m pip install -qq uv
	@$(BIN)/uv $(COMPILE) --extra campaign --extra export --extra reference --extra ros --extra view setup.py requirements.in --output-file requirements.lock
	@for peers in peers acados; do $(BIN)/uv $(COMPILE) benchmarks/peers/$$peers.txt --output-file benchmarks/peers/$$peers.lock; done

clean: ## remove everything that make and colcon made, except recorded flights
	rm -rf $(VENV) .venv-peers .venv-acados .venv-readers .random_problems test/readers/node_modules build install log *.egg-info .hypothesis .mypy_cache .pytest_cache .ruff_cache
	find spacecraft_gnc test -name __pycache__ -prune -exec rm -rf {} +

# An environment holds absolute paths: in a moved or copied checkout, or without its Python,
# it is created again.
ifneq ($(shell test -x $(BIN)/python && cat $(STAMPS)/environment 2>/dev/null),$(CURDIR))
.PHONY: $(STAMPS)/environment
endif

$(STAMPS)/environment:
	@python=$$(tools/prerequisites.sh "$(PYTHON)") \
		&& echo "== creating $(VENV) with $$python" \
		&& rm -rf $(VENV) && "$$python" -m venv $(VENV)
	@mkdir -p $(STAMPS) && printf '%s' "$(CURDIR)" > $@

$(STAMPS)/dependencies: requirements.lock tools/install_locked.sh $(STAMPS)/environment
	@$(call timed,installing the dependencies,tools/install_locked.sh $(VENV) requirements.lock)
	@touch $@

$(STAMPS)/messages: $(MESSAGES) tools/build_messages.sh tools/cmake/ros_wheels.cmake $(STAMPS)/dependencies
	@$(call timed,building the messages,tools/build_messages.sh $(VENV))
	@touch $@

$(STAMPS)/package: package.xml setup.py setup.cfg pyproject.toml resource/spacecraft_gnc $(STAMPS)/dependencies
	@$(call timed,installing spacecraft_gnc,$(BIN)/python -m pip install -qq --no-build-isolation --no-deps --editable .)
	@mkdir -p $(SHARE)/ament_index/resource_index/packages $(SHARE)/spacecraft_gnc
	@ln -sfn "$(CURDIR)/resource/spacecraft_gnc" $(SHARE)/ament_index/resource_index/packages/spacecraft_gnc
	@ln -sfn "$(CURDIR)/package.xml" $(SHARE)/spacecraft_gnc/package.xml
	@ln -sfn "$(CURDIR)/config" $(SHARE)/spacecraft_gnc/config
	@touch $@

# Numba detects a changed file, but not a kernel that calls one from a changed file: delete the cache.
$(STAMPS)/kernels: $(KERNELS) $(STAMPS)/dependencies | $(STAMPS)/package
	@find spacecraft_gnc -name '*.nb[ci]' -delete
	@$(call timed,compiling the kernels,$(BIN)/gnc warmup --quiet)
	@touch $@

# The solvers that `make bench` compares with are optional: one that cannot be installed is skipped and
# tried again next time. acados' wheel overwrites casadi, hence two environments.
.venv-%/installed: benchmarks/peers/%.lock tools/install_locked.sh $(STAMPS)/environment
	@echo "== installing solvers to compare with into $(@D)"
	@rm -rf $(@D) && $(BIN)/python -m venv $(@D)
	@if tools/install_locked.sh $(@D) $< >$(@D)/log 2>&1; then touch $@; \
		else echo "$< cannot be installed here: skipped; see $(@D)/log"; fi
