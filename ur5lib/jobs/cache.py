"""Where Snakemake keeps its cache."""

import os
import tempfile
from pathlib import Path

from ur5lib.jobs.snakemake_inside import cache_folder


def keep_cache_where_it_can_be_written() -> None:
    """Let Snakemake keep its cache in .snakemake where the home folder cannot be written.

    Otherwise it would end in a traceback, as in a container that another user runs.
    """
    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        os.environ["XDG_CACHE_HOME"] = str(Path(".snakemake", "cache").absolute())
