.PHONY: test rust page build environment lint bench bench-report

# Every test the project has. Release, because the mathematics is slow without it.
test:
	$(MAKE) --jobs=2 build environment
	$(MAKE) rust
	$(MAKE) page

rust:
	cargo test --release --locked

# Of the reports, in a browser.
page:
	./assets/report/test/page

build:
	cargo test --release --locked --no-run

# Of Python: the reference solvers, with which some tests compare, and Snakemake, which runs what tests write.
environment:
	./experiments/reference/run python -c pass
	./tests/cli/experiment/snakemake --version

lint:
	cargo fmt --all --check
	rustfmt --edition 2024 --check src/solver/*.rs src/solver/chambolle_pock/mod.rs
	cargo clippy --release --locked --all-targets -- -D warnings
	cargo clippy --release --locked --no-default-features --lib -- -D warnings

bench:
	cargo bench --locked

# The same, as a page: results/bench/README.md.
bench-report: bench
	cargo run --release --locked --example bench-report
