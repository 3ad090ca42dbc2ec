# make demo    a sentence and a picture become two scenes under out/
# make test    everything: formatting, lints, tests, and independent programs that judge sample scenes
# make bars    the promises of the README measured in full; writes docs/results/
# make programs  the README's examples of a sample scene in every program that can be installed; gigabytes
# make fuzz    every parser of foreign bytes under libFuzzer, ten minutes each; wants a nightly toolchain
# make build   the release binary
# make train   pictures are painted and the network that reads pictures is trained on them; hours
#
# Needed: a Rust toolchain, a C compiler, make, Python 3.11 with venv; for `make test` an OpenGL (EGL) or Vulkan driver,
# or TABLETOPGEN_GPU_TESTS=optional. What else is needed is fetched from
# the package registries by cargo, pip and npm, the first time only.

TARGET_DIR := $(abspath $(or $(CARGO_TARGET_DIR),target))
export CARGO_TARGET_DIR := $(TARGET_DIR)
CARGO ?= cargo
export PYTHONDONTWRITEBYTECODE := 1

.PHONY: help build demo test programs bars train fuzz

help:
	@sed -n 's/^# //p' Makefile | head -7

build:
	@scripts/prerequisites.sh demo >/dev/null
	$(CARGO) build --release --locked

demo: build
	@python="$$(scripts/prerequisites.sh demo)" && "$$python" scripts/demo.py --binary "$(TARGET_DIR)/release/tabletopgen"

test:
	@python="$$(scripts/prerequisites.sh)" && "$$python" scripts/test.py --target-dir "$(TARGET_DIR)"

# FUZZ names the targets, FUZZ_SECONDS how long each runs
fuzz:
	@python="$$(scripts/prerequisites.sh demo)" && "$$python" scripts/fuzz.py --target-dir "$(TARGET_DIR)" \
	    --seconds $(or $(FUZZ_SECONDS),600) $(if $(FUZZ),--only $(FUZZ))

# After `make test`, which leaves sample scenes
programs:
	@sh tests/judges/setup.sh
	@tests/judges/programs.sh
	@"$(TARGET_DIR)/judges/bin/python" tests/judges/judge.py --only readme "$(TARGET_DIR)"/sample/*/

# TRAINING is where pictures, frames, environment and network go; PICTURES how many are learned from
TRAINING ?= out/training
PICTURES ?= 20000
train: build
	"$(TARGET_DIR)/release/tabletopgen" paint-pictures --split validation --count 800 --out "$(TRAINING)/painted"
	"$(TARGET_DIR)/release/tabletopgen" paint-pictures --split training --count $(PICTURES) --out "$(TRAINING)/painted"
	@python="$$(scripts/prerequisites.sh demo)" && { test -d "$(TRAINING)/venv" || "$$python" -m venv "$(TRAINING)/venv"; }
	"$(TRAINING)/venv/bin/python" -m pip install --quiet -r training/requirements.txt
	"$(TRAINING)/venv/bin/python" training/train.py --painted "$(TRAINING)/painted" --out "$(TRAINING)/network"

# BARS names those to run
BARS ?= sentences certified generate_time determinism kill certify_time picture_time remote_kill remote_fanout
bars: build
	@python="$$(scripts/prerequisites.sh)" && for bar in $(BARS); do \
	    "$$python" -m bars.$$bar --target-dir "$(TARGET_DIR)" || exit 1; done
bars: export PYTHONPATH := scripts
