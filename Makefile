.PHONY: test lint bench bench-report

# Every test the project has. Release, because the mathematics is slow without it.
test:
	cargo test --release --locked
	./assets/report/test/page

lint:
	cargo fmt --all --check
	cargo clippy --release --locked --all-targets -- -D warnings

bench:
	cargo bench --locked

# The same, as a page: results/bench/README.md.
bench-report: bench
	cargo run --release --locked --example bench-report
