# `make demo` shows what the toolkit does, `make test` proves it. Both install what a fresh Debian 12 machine lacks.

SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help

# The software Vulkan driver, and what a window needs on X11.
PACKAGES := mesa-vulkan-drivers libvulkan1 libxkbcommon-x11-0 libxkbcommon0 libx11-xcb1 libxcursor1 libxi6 libxrandr2 libgl1 libegl1
# What only the tests need: a display without a screen, and hands to use it.
TEST_PACKAGES := xvfb xdotool nodejs npm
SUDO := $(shell [ "$$(id -u)" = 0 ] || echo sudo)

.PHONY: help demo test packages test-packages bench

help:
	@echo "make demo    build, convert a model, render demo/demo.png, open it if there is a display"
	@echo "make test    formatting, lints, documentation and every test"
	@echo "make bench   the benchmarks, each a ratio in one run"

define install
	@missing=""; for package in $(1); do \
		dpkg-query -W -f='$${Status}' $$package 2>/dev/null | grep -q 'ok installed' || missing="$$missing $$package"; \
	done; \
	for program in node:nodejs npm:npm; do \
		if command -v $${program%%:*} >/dev/null; then missing="$$(echo "$$missing " | sed "s/ $${program##*:} / /")"; fi; \
	done; \
	missing="$$(echo $$missing)"; \
	if [ -n "$$missing" ]; then \
		if command -v apt-get >/dev/null; then \
			echo "installing: $$missing"; \
			$(SUDO) apt-get update -qq && $(SUDO) env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $$missing >/dev/null; \
		else \
			echo "please install the equivalents of: $$missing"; \
		fi; \
	fi
endef

packages:
	$(call install,$(PACKAGES))

test-packages: packages
	$(call install,$(TEST_PACKAGES))

demo: packages
	cargo build --locked
	mkdir -p demo
	target/debug/aam convert fixtures/assets/crate.gltf demo/crate.aam
	target/debug/aam info demo/crate.aam
	target/debug/aam render demo/crate.scene.toml --view "Demo Camera" -o demo/demo.png --size 1280x800
	@echo "demo/demo.png is the picture"
	@if [ -n "$${DISPLAY:-}$${WAYLAND_DISPLAY:-}" ]; then target/debug/aam view demo/crate.scene.toml; else echo "no display: run 'target/debug/aam view demo/crate.scene.toml' where there is one"; fi

test: test-packages
	cargo fmt --all --check
	cargo clippy --locked --workspace --all-targets -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --locked --workspace --no-deps
	cargo test --locked --workspace

bench:
	cargo bench --locked --workspace
