# make setup        what is missing: apt packages (where it may; CPM_APT=no leaves them to you), .venv, cpm in it
# make demo         the paper's room, homogeneous and curved, at full size, to build/demo
# make test         set-up, C tests, Python tests: minutes (CONTRIBUTING.md, TESTING.md)
# make test-long    the tests marked long too
# make test-deep    sanitizers and fuzzers
# make bench        every program of bench/, to RESULTS (results/; RESULTS=docs/results publishes)
# make abi          the public ABI against docs/abi; make abi-baseline writes it anew
# make format       clang-format, ruff;  make clean

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
BUILD ?= build/c
JOBS ?= $(shell nproc)
CTEST := ctest --output-on-failure --no-tests=error
# A fuzzer's seconds.
FUZZ_SECONDS ?= 60
# Where benchmarks write.
RESULTS ?= results

SOURCES := $(shell find CMakeLists.txt cmake bindings cl libcpm spectral python/cpm LICENSE README.md -type f \
	-not -name '*.pyc' 2>/dev/null)
C_FILES := $(shell find bindings bench cl examples libcpm spectral tests -name '*.[ch]' -o -name '*.cpp' -o -name '*.cl')

.PHONY: setup demo test test-c test-python test-long test-deep sanitize fuzz bench abi abi-baseline format clean

# --- set-up: three stamps, so that a second run costs nothing --------------------------------------------------------

setup: $(VENV)/stamp-package

build/stamp-apt: packages-debian.txt tools/apt.sh
	@mkdir -p build
	sh tools/apt.sh packages-debian.txt
	@touch $@

$(VENV)/stamp-venv: pyproject.toml tools/build_requires.py | build/stamp-apt
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --upgrade pip
	$(BIN)/python tools/build_requires.py | xargs -d '\n' $(BIN)/python -m pip install --quiet --disable-pip-version-check
	@touch $@

# Not editable: what is tested is what a user gets. The build tree is kept, so that only what changed is compiled.
$(VENV)/stamp-package: $(VENV)/stamp-venv $(SOURCES)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-build-isolation \
		--config-settings=build-dir=build/wheel '.[test]'
	@touch $@

# --- demo ------------------------------------------------------------------------------------------------------------

demo: setup
	$(BIN)/python examples/demo.py --output build/demo

# --- tests -----------------------------------------------------------------------------------------------------------

$(BUILD)/build.ninja: | build/stamp-apt
	cmake -S . -B $(BUILD) -G Ninja -DCPM_BUILD_TESTS=ON -DCPM_BUILD_EXAMPLES=ON

test-c: $(BUILD)/build.ninja
	cmake --build $(BUILD) -j $(JOBS)
	$(CTEST) --test-dir $(BUILD)

# ctest's and pytest's closing lines come last, each after its own run.
test: setup test-c
	$(BIN)/python -m pytest tests -m "not long"

test-long: setup test-c
	$(BIN)/python -m pytest tests --long

test-deep: sanitize fuzz

# No -Werror: under -fsanitize=undefined gcc sees conversions in the code that it itself inserts.
sanitize: | build/stamp-apt
	cmake -S . -B build/sanitize -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCPM_BUILD_TESTS=ON \
		-DCPM_SANITIZE=address,undefined
	cmake --build build/sanitize -j $(JOBS)
	$(CTEST) --test-dir build/sanitize

fuzz: | build/stamp-apt
	cmake -S . -B build/fuzz -G Ninja -DCMAKE_C_COMPILER=clang-14 -DCMAKE_BUILD_TYPE=RelWithDebInfo \
		-DCPM_BUILD_FUZZERS=ON -DCPM_SANITIZE=address,undefined
	cmake --build build/fuzz -j $(JOBS)
	sh tests/fuzz/run.sh build/fuzz/tests/fuzz $(FUZZ_SECONDS)

# --- benchmarks, ABI, format -----------------------------------------------------------------------------------------

bench: setup
	for program in $(filter-out bench/_%,$(wildcard bench/*.py)); do echo "== $$program"; $(BIN)/python $$program --results $(RESULTS) || exit 1; done

# Debug information carries the types. Needs abigail-tools.
build/abi/libcpm.so.0: $(SOURCES) | build/stamp-apt
	cmake -S . -B build/abi -G Ninja -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS=-ffile-prefix-map=$(CURDIR)=.
	cmake --build build/abi -j $(JOBS)

abi: build/abi/libcpm.so.0
	sh tools/abi.sh check build/abi/libcpm.so.0 libcpm/include docs/abi

abi-baseline: build/abi/libcpm.so.0
	sh tools/abi.sh write build/abi/libcpm.so.0 libcpm/include docs/abi

format:
	clang-format-14 -i --style=file $(C_FILES)
	test ! -x $(BIN)/ruff || $(BIN)/ruff format python tests bench examples

clean:
	rm -rf build $(VENV) dist
