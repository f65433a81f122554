# The two commands that do everything on a fresh machine with Rust and a C compiler:
#
#   make run     opens the window (where there is no display: draws it into a PNG and lists the features)
#   make test    runs all tests
#
# On Debian-like systems both first install the system packages that are missing, and say which. Elsewhere they install nothing:
# a desktop's usual libraries are enough for the window, and Vulkan (Mesa's lavapipe will do) for the tests of it.

CARGO ?= cargo
PACKAGES_BUILD = gcc libc6-dev
# Mesa's Vulkan drivers, lavapipe among them: the window can be drawn without a graphics card.
PACKAGES_DRAW = mesa-vulkan-drivers
# A virtual display, and the libraries that a window loads while it opens.
PACKAGES_WINDOW = xvfb libxcursor1 libxi6 libxkbcommon-x11-0

.PHONY: run test packages

run: packages
	$(CARGO) run --release

test: packages
	$(CARGO) test --workspace

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
