.PHONY: test rust python page build environment lint bench bench-report paper reproduce

# All tests of the project, in release mode, because the numerical code is slow without optimization.
test:
	$(MAKE) --jobs=2 build environment
	$(MAKE) rust
	$(MAKE) python
	$(MAKE) page

rust:
	cargo test --release --locked

# The tests of the Python package, which is installed in an environment of its own.
python:
	./python/test

# The tests of the report page, in a browser.
page:
	./assets/report/test/page

build:
	cargo test --release --locked --no-run

# Python environments: the reference solvers, for tests that compare with them, Snakemake, for the workflows that tests
# write, and what the tests of the Python package need.
environment:
	./experiments/reference/run python -c pass
	./tests/cli/experiment/snakemake --version
	./python/test environment

lint:
	cargo fmt --all --check
	rustfmt --edition 2024 --check src/solver/*.rs src/solver/chambolle_pock/mod.rs
	cargo clippy --release --locked --all-targets -- -D warnings
	cargo clippy --release --locked --no-default-features --lib -- -D warnings

bench:
	CARGO_INCREMENTAL=0 cargo bench --locked

# The benchmarks as a page: results/bench/README.md.
bench-report: bench
	cargo run --release --locked --example bench-report

# paper/meshseg.pdf, from the committed results; paper/README.md names what this needs.
paper:
	./paper/build

# The runs of the paper again, then the paper, in target/reproduce: QUICK=1 in about 10 minutes, FULL=1 in about an hour.
reproduce:
	cargo build --release --locked
	./paper/reproduce $(if $(FULL),full,$(if $(QUICK),quick))
