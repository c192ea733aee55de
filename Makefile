# `make demo` and `make test` each do all the set-up that they need; `make help` lists the rest.
#
# The set-up is five steps, each with a stamp file that is written last, so that one that was
# interrupted is done again and one that is finished costs nothing:
#   venv      .venv with what requirements.lock pins; made anew when a lock, the Python or the
#             place of the checkout has changed
#   standard  the types of simulation_interfaces, tf2_msgs and control_msgs, which are no wheels
#   messages  flexsim_msgs; all are generated and built from msgs_schema/ and installed into the venv
#   project   this checkout, editable

PYTHON ?= python3
MAKEFLAGS += --no-builtin-rules
.DELETE_ON_ERROR:
.DEFAULT_GOAL := help

# A sourced ROS, or a Python of another venv that started us, must not leak in: the venv is whole.
unexport _ROS_WHEELS_BOOTSTRAP_COMPLETE AMENT_PREFIX_PATH CMAKE_PREFIX_PATH LD_LIBRARY_PATH
unexport PYTHONHOME PYTHONPATH

VENV := .venv
VENV_STAMP := $(VENV)/stamps/venv
STANDARD_STAMP := $(VENV)/stamps/standard
# Types of ROS packages that are no wheels.
STANDARD := simulation_interfaces tf2_msgs control_msgs
MESSAGES_STAMP := $(VENV)/stamps/messages
PROJECT_STAMP := $(VENV)/stamps/project
KERNELS_STAMP := $(VENV)/stamps/kernels
TEST_STAMP := $(VENV)/stamps/test
DOCS_STAMP := $(VENV)/stamps/docs

CORES := -n auto --maxprocesses 4 --dist loadfile
PIP_INSTALL := $(VENV)/bin/python -m pip --disable-pip-version-check install --quiet --no-deps

# The venv knows where it is and, if the caller names a Python, is checked against it.
ifneq ($(origin PYTHON),file)
python_changed = ! "$(PYTHON)" -c 'import sys; print(*sys.version_info[:3])' 2>/dev/null | cmp -s - $(VENV)/stamps/python
else
python_changed = false
endif
stale := $(shell [ -e $(VENV_STAMP) ] && { [ "$$(cat $(VENV)/stamps/place)" != "$$(pwd -P)" ] || $(python_changed); } && echo stale)

.PHONY: help demo test nightly lint docs setup lock clean stale
.NOTPARALLEL:
.SILENT: $(VENV_STAMP) $(STANDARD_STAMP) $(MESSAGES_STAMP) $(PROJECT_STAMP) $(KERNELS_STAMP) $(TEST_STAMP) $(DOCS_STAMP)

help:  ## this list
	@sed -n 's/^\([a-z]*\):.*## /  make \1\t/p' Makefile

demo: setup  ## the main job: a robot, a controller, a bag, pictures
	$(VENV)/bin/flexsim demo

test: setup $(TEST_STAMP)  ## the tests
	NUMBA_DISABLE_JIT=1 $(VENV)/bin/python -m pytest $(CORES) -m "equations and not nightly"
	$(VENV)/bin/python -m pytest $(CORES) -m "not equations and not alone and not nightly"
	$(VENV)/bin/python -m pytest -m "alone and not nightly"

# One after the other: each has the machine to itself, as a user has.
nightly: setup $(TEST_STAMP)  ## the tests that take long: every documented example, studies and all (hours)
	$(VENV)/bin/python -m pytest -m nightly

lint: setup $(TEST_STAMP)  ## ruff, mypy, import rules
	$(VENV)/bin/ruff check .
	$(VENV)/bin/ruff format --check --quiet .
	$(VENV)/bin/mypy
	$(VENV)/bin/lint-imports --no-logo

# What does not fit a page, a link that leads nowhere among it, is a warning, and ends this.
docs: $(PROJECT_STAMP) $(DOCS_STAMP)  ## the documentation and a reference as a site in out/docs, links checked
	rm -rf out/docs
	PYTHONPATH="$$PWD/$(VENV)/docs" $(VENV)/bin/python -m sphinx -q -W --keep-going -c docs/site . out/docs
	@echo "out/docs/index.html"

setup: $(VENV_STAMP) $(STANDARD_STAMP) $(MESSAGES_STAMP) $(PROJECT_STAMP) $(KERNELS_STAMP)  ## only the set-up, without tests' tools

lock:  ## pin anew what pyproject.toml asks for
	rm -rf .venv-lock && $(PYTHON) -m venv .venv-lock && .venv-lock/bin/pip install --quiet uv
	.venv-lock/bin/uv pip compile --quiet --universal --python-version 3.10 --generate-hashes \
	    --fork-strategy fewest --no-annotate --no-header --upgrade \
	    --extra messages pyproject.toml --output-file .venv-lock/requirements.lock
	.venv-lock/bin/uv pip compile --quiet --universal --python-version 3.10 --generate-hashes \
	    --fork-strategy fewest --no-annotate --no-header --constraints .venv-lock/requirements.lock \
	    --extra messages --extra test pyproject.toml --output-file .venv-lock/all.lock
	grep -vxFf .venv-lock/requirements.lock .venv-lock/all.lock > requirements-test.lock
	cp .venv-lock/requirements.lock requirements.lock
	.venv-lock/bin/uv pip compile --quiet --universal --python-version 3.10 --generate-hashes \
	    --fork-strategy fewest --no-annotate --no-header --upgrade \
	    --group docs --output-file requirements-docs.lock
	# Only this platform is locked for (pyproject.toml, tool.uv), so its markers say nothing.
	sed -i "s/ and sys_platform == 'linux'//; s/ ; platform_machine == 'x86_64'\( .$$\)/\1/; \
	    s/ and platform_machine == 'x86_64'//; s/platform_machine == 'x86_64' and //" requirements.lock requirements-test.lock
	sed -i "s/ ; platform_machine == 'x86_64' and sys_platform == 'linux'//; \
	    s/ and platform_machine == 'x86_64' and sys_platform == 'linux'//" requirements-docs.lock

clean:  ## remove what make has made
	rm -rf $(VENV) .venv-lock .pytest_cache .mypy_cache .ruff_cache flexsim.egg-info

$(VENV_STAMP): requirements.lock requirements-test.lock $(stale)
	"$(PYTHON)" -c 'import sys; sys.exit(not (3, 10) <= sys.version_info < (3, 14))' 2>/dev/null \
	    || { command -v "$(PYTHON)" >/dev/null && found="$$("$(PYTHON)" --version 2>&1)"; \
	         echo "flexsim needs Python 3.10 to 3.13; $(PYTHON) is $${found:-not there}. Say which: make PYTHON=python3.12 ..." >&2; exit 1; }
	"$(PYTHON)" -c 'import ensurepip, venv' 2>/dev/null \
	    || { echo "$(PYTHON) has no venv module: install it (Debian and Ubuntu: apt install python3-venv)" >&2; exit 1; }
	for compiler in "$${CC:-cc}" "$${CXX:-c++}"; do command -v "$$compiler" >/dev/null \
	    || { echo "flexsim needs a C and C++ compiler, $$compiler is not there (Debian and Ubuntu: apt install build-essential)" >&2; exit 1; }; done
	"$(PYTHON)" -c 'import os, sys, sysconfig; sys.exit(not os.path.exists(sysconfig.get_path("include") + "/Python.h"))' \
	    || { echo "$(PYTHON) has no headers: install them (Debian and Ubuntu: apt install python3-dev)" >&2; exit 1; }
	echo "set-up 1/5: packages into $(VENV) (a few minutes the first time)"
	rm -rf $(VENV)
	"$(PYTHON)" -m venv $(VENV)
	mkdir $(VENV)/stamps
	# The pinned setuptools first: it builds what comes as source, so nothing unpinned takes part.
	sed -n '/^setuptools==/,/[^\\]$$/p' requirements.lock > $(VENV)/stamps/setuptools.lock
	$(PIP_INSTALL) -r $(VENV)/stamps/setuptools.lock
	$(PIP_INSTALL) --no-build-isolation --use-pep517 -r requirements.lock
	# The message wheels export include folders of the machine that built them; CMake refuses them.
	sed -i 's#"/opt/python/[^"]*"#""#' $(VENV)/share/*/cmake/*__rosidl_generator_pyExport.cmake
	pwd -P > $(VENV)/stamps/place
	$(VENV)/bin/python -c 'import sys; print(*sys.version_info[:3])' > $(VENV)/stamps/python
	touch $@

# Every Python of the venv finds the venv's ROS packages, as after sourcing a ROS set-up file. And
# the wheels' own start-up file, which runs after this one, is asked again where another venv's
# Python started us, because that one's library path is not ours.
$(STANDARD_STAMP): $(VENV_STAMP) $(shell find $(STANDARD:%=msgs_schema/%) -type f)
	echo "set-up 2/5: $(STANDARD) (a minute or two)"
	printf '%s\n' \
	    "import os, sys; p = os.environ.get('AMENT_PREFIX_PATH', ''); os.environ['AMENT_PREFIX_PATH'] = p if sys.prefix in p.split(':') else sys.prefix + ':' * bool(p) + p" \
	    "import os, sys; sys.prefix + '/lib' in os.environ.get('LD_LIBRARY_PATH', '').split(':') or os.environ.pop('_ROS_WHEELS_BOOTSTRAP_COMPLETE', None)" \
	    > "$$($(VENV)/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')/ament_prefix_path.pth"
	# Not optimised, which is half of the compiler's time: its services are asked now and then.
	$(call build_types,simulation_interfaces,msgs_schema/simulation_interfaces,None)
	$(call build_types,tf2_msgs,msgs_schema/tf2_msgs,None)
	$(call build_types,control_msgs,msgs_schema/control_msgs,None)
	touch $@

$(MESSAGES_STAMP): $(STANDARD_STAMP) msgs_schema/CMakeLists.txt msgs_schema/package.xml $(shell find msgs_schema/msg -type f)
	echo "set-up 3/5: flexsim_msgs"
	$(call build_types,flexsim_msgs,msgs_schema,Release)
	touch $@

# $(call build_types,PACKAGE,FOLDER,BUILD_TYPE): generate, build and install a package of types.
define build_types
rm -rf $(VENV)/build/$(1) $(VENV)/lib/lib$(1)__* $(VENV)/share/$(1) $(VENV)/include/$(1) \
	    $(VENV)/lib/python3.*/site-packages/$(1)*
	mkdir -p $(VENV)/build
	$(VENV)/bin/cmake -S $(2) -B $(VENV)/build/$(1) -DCMAKE_BUILD_TYPE=$(3) \
	    -DCMAKE_INSTALL_PREFIX="$$PWD/$(VENV)" -DCMAKE_PREFIX_PATH="$$PWD/$(VENV)" \
	    -DPython3_EXECUTABLE="$$PWD/$(VENV)/bin/python" -DPython3_FIND_VIRTUALENV=ONLY \
	    -DBUILD_TESTING=OFF -DINSTALL_FLEXSIM_ROS=OFF > $(VENV)/build/$(1).log 2>&1 \
	    && $(VENV)/bin/cmake --build $(VENV)/build/$(1) --parallel 2 >> $(VENV)/build/$(1).log 2>&1 \
	    && $(VENV)/bin/cmake --install $(VENV)/build/$(1) >> $(VENV)/build/$(1).log 2>&1 \
	    || { tail -30 $(VENV)/build/$(1).log; echo "$(1) did not build: $(VENV)/build/$(1).log" >&2; exit 1; }
endef

$(PROJECT_STAMP): $(VENV_STAMP) pyproject.toml msgs_schema/flexsim_ros/first_instant.py
	echo "set-up 4/5: flexsim, editable"
	$(PIP_INSTALL) --no-build-isolation --editable .
	# Our programs answer signals while Python itself starts, which the wheels have executed anew.
	$(VENV)/bin/python -m flexsim_ros.first_instant
	touch $@

# The robot's kernels, in space and in the plane, and the door's, so that no run waits for the compiler.
KERNELS := simulate config/delta.yaml --duration 0.01 \
    | simulate config/anthropomorphic.yaml --duration 0.01 --set initial.shape=static \
    | simulate config/four_bar.yaml --duration 0.01 \
    | simulate config/planar_double_pendulum.yaml --duration 0.01 --set initial.shape=static \
    | door simulate config/thesis_door_column.yaml --duration 1

$(KERNELS_STAMP): $(PROJECT_STAMP) $(shell find flexsim_node thermal_node -name '*.py' 2>/dev/null)
	echo "set-up 5/5: compiled kernels (some minutes)"
	echo "$(KERNELS)" | tr '|' '\n' | xargs -P 2 -I{} sh -c '$(VENV)/bin/flexsim {} --json > /dev/null'
	touch $@

$(TEST_STAMP): $(VENV_STAMP) requirements-test.lock
	echo "set-up: the tests' tools"
	$(PIP_INSTALL) --no-build-isolation --use-pep517 --ignore-installed -r requirements-test.lock
	touch $@

# Beside the venv and not in it: the site's builder brings versions of its own of what the project uses.
$(DOCS_STAMP): $(VENV_STAMP) requirements-docs.lock
	echo "set-up: what builds the site"
	rm -rf $(VENV)/docs
	$(PIP_INSTALL) --target $(VENV)/docs -r requirements-docs.lock
	touch $@
