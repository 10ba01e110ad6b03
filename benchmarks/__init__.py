"""The benchmark suite: `python -m benchmarks`. What it measures, and how to read it, stands in docs/benchmarks.md."""
