# make demo    a sentence and an image become two scenes under out/
# make test    everything: formatting, lints, tests, and independent programs that judge sample scenes
# make bars    the promises of the README measured in full; writes docs/results/
# make programs  the README's examples of a sample scene in every program that can be installed; gigabytes
# make fuzz    every parser of foreign bytes under libFuzzer, ten minutes each; wants a nightly toolchain
# make build   the release binary
# make studio  the page of the server, which the next build holds; `make build STUDIO=no` does without
# make dist    the release binary as an archive, with manual, completions, licenses, bill of materials and checksum
# make wheel   the Python package with that binary, for pip
# make train   synthetic images are rendered and the table network is trained on them; hours
# make train_recognizer   the same for the recognizer of objects; an hour
# make advisories  whether a known vulnerability is in Cargo.lock; asks a database on the network
# make features  whether the program compiles without its optional parts, and with each of them alone
# make pages   how old the pages of docs/results/ are: what changed since in the code they depend on
#
# Needed: a Rust toolchain, a C compiler and make. For `make demo` also Python 3.9 or later; without one the demo does
# without the server. For `make test` Python 3.11 to 3.14 with venv (from 3.12 on without the judge PyBullet, which has
# no packages there), and an OpenGL (EGL) or Vulkan driver, or TABLETOPGEN_GPU_TESTS=optional. For `make bars` and
# `make programs` Python 3.11. PostgreSQL is used where it is installed. What else is needed is fetched from the package
# registries by cargo, pip and npm, the first time only.

TARGET_DIR := $(abspath $(or $(CARGO_TARGET_DIR),target))
export CARGO_TARGET_DIR := $(TARGET_DIR)
CARGO ?= cargo
export PYTHONDONTWRITEBYTECODE := 1
# Where Python finds the package of tests and measurements.
export PYTHONPATH := $(CURDIR)/python

.PHONY: help build studio page lab wheel dist demo test programs bars train train_recognizer fuzz advisories features pages

help:
	@sed -n 's/^# //p' Makefile | head -13

# The page of the server, by Node 20.19 or later
studio:
	@scripts/studio.sh

# The same where it can be had
page:
	@[ "$(STUDIO)" = no ] || [ ! -d studio/src ] || scripts/studio.sh optional

build: page
	@scripts/prerequisites.sh build
	$(CARGO) build --release --locked --package tabletopgen

wheel: build
	@python="$$(scripts/prerequisites.sh wheel)" && "$$python" -m tabletopgen_checks.client wheel --target-dir "$(TARGET_DIR)"

dist: build
	@python="$$(scripts/prerequisites.sh wheel)" && "$$python" -m tabletopgen_checks.dist --target-dir "$(TARGET_DIR)"

# The same with the benchmarks, the generator of training images and the mock vendors
lab: page
	@scripts/prerequisites.sh build
	$(CARGO) build --release --locked --package tabletopgen --package tabletopgen-lab

demo: build
	@python="$$(scripts/prerequisites.sh demo)" && if [ -n "$$python" ]; then \
	    "$$python" -m tabletopgen_checks.demo --binary "$(TARGET_DIR)/release/tabletopgen"; else \
	    scripts/demo.sh "$(TARGET_DIR)/release/tabletopgen"; fi

test: page
	@python="$$(scripts/prerequisites.sh)" && "$$python" -m tabletopgen_checks.test --target-dir "$(TARGET_DIR)"

advisories:
	@python="$$(scripts/prerequisites.sh)" && "$$python" -m tabletopgen_checks.tools advisories --target-dir "$(TARGET_DIR)"

FEATURES ?= gpu otel postgres s3 video
features:
	@for features in "" $(FEATURES); do \
	    $(CARGO) check --locked --package tabletopgen --no-default-features --features "$$features" || exit 1; done

pages:
	@python="$$(scripts/prerequisites.sh)" && "$$python" -m tabletopgen_checks.tools pages

# FUZZ names the targets, FUZZ_SECONDS how long each runs
fuzz:
	@python="$$(scripts/prerequisites.sh fuzz)" && "$$python" -m tabletopgen_checks.fuzz --target-dir "$(TARGET_DIR)" \
	    --seconds $(or $(FUZZ_SECONDS),600) $(if $(FUZZ),--only $(FUZZ))

# After `make test`, which leaves sample scenes
programs:
	@python="$$(scripts/prerequisites.sh bars)" && "$$python" -m tabletopgen_checks.judges.programs --target-dir "$(TARGET_DIR)"
	@"$(TARGET_DIR)/judges/bin/python" tests/judges/judge.py --only readme "$(TARGET_DIR)"/sample/*/

# TRAINING is the folder of images, frames, environment and network; IMAGES is the number of training images
TRAINING ?= out/training
IMAGES ?= 20000
train: lab
	"$(TARGET_DIR)/release/tabletopgen-lab" synthesize --split validation --count 800 --out "$(TRAINING)/images"
	"$(TARGET_DIR)/release/tabletopgen-lab" synthesize --split training --count $(IMAGES) --out "$(TRAINING)/images"
	@python="$$(scripts/prerequisites.sh train)" && { test -d "$(TRAINING)/venv" || "$$python" -m venv "$(TRAINING)/venv"; }
	"$(TRAINING)/venv/bin/python" -m pip install --quiet -r training/requirements.txt
	"$(TRAINING)/venv/bin/python" training/train.py --images "$(TRAINING)/images" --out "$(TRAINING)/network"

# The recognizer of objects, from CLOSE_UPS close-ups, each of one category in turn
CLOSE_UPS ?= 18372
train_recognizer: lab
	for split in "test --count 3062" "training --count $(CLOSE_UPS)" "validation --count 1531"; do \
		"$(TARGET_DIR)/release/tabletopgen-lab" synthesize --close-ups --size-px 256 --out "$(TRAINING)/images" --split $$split || exit 1; done
	@python="$$(scripts/prerequisites.sh train)" && { test -d "$(TRAINING)/venv" || "$$python" -m venv "$(TRAINING)/venv"; }
	"$(TRAINING)/venv/bin/python" -m pip install --quiet -r training/requirements.txt
	"$(TRAINING)/venv/bin/python" training/recognizer.py --close-ups "$(TRAINING)/images/close_ups" --out "$(TRAINING)/recognizer"

# BARS names those to run, BARS_OPTIONS are options of theirs: make bars BARS=words BARS_OPTIONS="--scenes 60"
BARS ?= sentences certified generate_time determinism kill certify_time picture_time remote_kill remote_fanout words reliability contract overload tenants editing variants batches robot grasps episodes policy recordings rest categories sizes image_quality clutter
bars: lab
	@python="$$(scripts/prerequisites.sh bars)" && for bar in $(BARS); do \
	    "$$python" -m tabletopgen_checks.bars.$$bar --target-dir "$(TARGET_DIR)" $(BARS_OPTIONS) || exit 1; done
