"""Shared parts of the benchmarks: inputs, drawn studies, scores, pages and figures."""
