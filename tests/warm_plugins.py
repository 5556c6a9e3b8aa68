"""Loads what Snakemake loads for each plan: its plugins, by their options, and their packages."""

import smart_open  # noqa: F401
from snakemake.cli import get_argument_parser

get_argument_parser()
