# The two commands that do everything on a fresh machine with Rust and a C compiler:
#
#   make run     opens the window (where there is no display: draws it into a PNG and lists the features)
#   make test    runs all tests
#
# What is typed every day, which installs nothing:
#
#   make check         formats, lints and builds the documentation
#   make test-core     tests the library and the measuring bench
#   make test-window   tests the window
#   make accept        accepts what the tests of the window show: look at screenshots/*.new.png first
#   make pictures      draws the pictures of the documents anew, for a release
#   make bench         times the stages of the detector
#   make measurements  writes the tables of the documents from docs/measurements
#   make measure       measures them anew first, for hours; NAMES=charts,accuracy for some
#   make fuzz          reads damaged input; CASES=1000000 for a night of it
#
# For Python (3.10 or newer with venv; what it needs is installed into target/python, from the package index):
#
#   make wheel         builds the wheel with the detector, the commands and the window
#   make test-python   installs it, and tests it with its types and notebooks
#   make notebooks     runs the notebooks and keeps what they show
#   make keywords      writes the keywords of the functions from the program's own table
#   make dist          wheel, .deb and portable .tar.gz in target/dist; `make try-dist` starts each in a bare system
#
# On Debian-like systems both first install the system packages that are missing, and say which. Elsewhere they install nothing:
# a desktop's usual libraries are enough for the window, and Vulkan (Mesa's lavapipe will do) for the tests of it.

CARGO ?= cargo
PACKAGES_BUILD = gcc libc6-dev
# Mesa's Vulkan drivers, lavapipe among them: the window can be drawn without a graphics card.
PACKAGES_DRAW = mesa-vulkan-drivers
# A virtual display, and the libraries that a window loads while it opens.
PACKAGES_WINDOW = xvfb libxcursor1 libxi6 libxkbcommon-x11-0

# Damaged inputs that each test of `make fuzz` gets.
CASES ?= 20000

# Stored results of docs/measurements that `make measure` measures anew.
NAMES ?= all

# The tools of Python, and where the wheel and the packages go.
PYTHON ?= python3
VENV = target/python
DIST = target/dist
# Profile of the wheel: release, or dev for a quick build.
PROFILE ?= release

.PHONY: run test check test-core test-window accept pictures bench measurements measure fuzz packages wheel test-python notebooks keywords dist try-dist

# What is made for use names its commit; elsewhere each commit would build the program anew.
run wheel dist: export BURSTSCOPE_COMMIT ?= $(shell git rev-parse --short=9 HEAD 2>/dev/null)

run: packages
	$(CARGO) run --release

test: packages
	$(CARGO) test --workspace

check:
	$(CARGO) fmt --all
	$(CARGO) clippy --workspace --all-targets -- -D warnings
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --workspace --no-deps

test-core:
	$(CARGO) test -p burstscope-core -p burstscope-lab

test-window:
	$(CARGO) test --test window

accept:
	UPDATE_SNAPSHOTS=1 $(CARGO) test --test window

pictures:
	UPDATE_SNAPSHOTS=force $(CARGO) test --test window

bench:
	$(CARGO) bench --bench stages

measurements:
	BURSTSCOPE_UPDATE_DOCS=1 $(CARGO) test --test commands tables_of_measurements

measure:
	BURSTSCOPE_MEASURE=$(NAMES) BURSTSCOPE_UPDATE_DOCS=1 $(CARGO) test --test commands tables_of_measurements

fuzz:
	PROPTEST_CASES=$(CASES) $(CARGO) test -p burstscope-core --test files -- parsers fuzz
	PROPTEST_CASES=$(CASES) $(CARGO) test -p burstscope-core --lib -- no_header_panics damaged_records
	PROPTEST_CASES=$(CASES) $(CARGO) test --test commands lessons_and_sessions

wheel: $(VENV)/made
	rm -f $(DIST)/burstscope-*.whl
	$(VENV)/bin/maturin build --profile $(PROFILE) --locked --strip --interpreter $(VENV)/bin/python --manifest-path python/Cargo.toml --out $(DIST)
	@ls -l $(DIST)/*.whl

# The tests are of the wheel that users install, and of no other files.
$(VENV)/installed: wheel
	$(VENV)/bin/pip install --quiet --disable-pip-version-check --no-deps --force-reinstall $(DIST)/burstscope-*.whl
	@touch $@

test-python: $(VENV)/installed
	cd python && ../$(VENV)/bin/mypy
	cd python/tests && MYPYPATH= ../../$(VENV)/bin/stubtest burstscope --mypy-config-file ../pyproject.toml --allowlist stubtest.txt
	$(VENV)/bin/pytest python

notebooks: $(VENV)/installed
	$(VENV)/bin/python python/tools/run_notebooks.py

keywords: $(VENV)/installed
	BURSTSCOPE_UPDATE_DOCS=1 $(VENV)/bin/python python/tools/write_keywords.py

$(VENV)/made: python/requirements.txt
	@$(PYTHON) -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 10))' || { \
		echo "Python: 3.10 or newer with venv is needed, but $(PYTHON) has no such; on Debian-like systems: apt-get install python3-venv; or set PYTHON="; \
		exit 1; \
	}
	$(PYTHON) -m venv $(VENV)
	$(VENV)/bin/pip install --quiet --disable-pip-version-check --requirement python/requirements.txt
	@touch $@

dist: wheel
	$(CARGO) build --release --locked
	packaging/dist.sh $(DIST)

try-dist:
	packaging/try.sh $(DIST)

packages:
	@if ! command -v apt-get >/dev/null 2>&1 || ! command -v dpkg-query >/dev/null 2>&1; then \
		echo "packages: no apt here, so nothing is installed; needed are a C compiler and, for the window, the desktop's libraries and Vulkan"; \
		exit 0; \
	fi; \
	missing=""; \
	for package in $(PACKAGES_BUILD) $(PACKAGES_DRAW) $(PACKAGES_WINDOW); do \
		dpkg-query -W -f='$${Status}' "$$package" 2>/dev/null | grep -q "ok installed" || missing="$$missing $$package"; \
	done; \
	if [ -z "$$missing" ]; then \
		echo "packages: all there"; \
		exit 0; \
	fi; \
	echo "packages: installing$$missing"; \
	sudo=""; \
	if [ "$$(id -u)" != 0 ]; then \
		if ! command -v sudo >/dev/null 2>&1; then \
			echo "packages: neither root nor sudo; going on without. To install them: apt-get install$$missing"; \
			exit 0; \
		fi; \
		sudo="sudo"; \
	fi; \
	$$sudo apt-get update -qq && $$sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $$missing </dev/null >/dev/null || { \
		echo "packages: the installation failed; going on without, the build will say what it misses"; \
	}
