"""The page's table of the link that was touched, from results/contact_link.csv."""

from itertools import pairwise

import pandas as pd

from benchmarks.harness.page import markdown

EDGES = (5, 10, 20, 40, 80)  # N
COLUMNS = ["contact", "contacts", "named right", "named wrong", "cannot tell",
           "likeliest link: stated probability", "right", "likely links", "hold it"]  # fmt: skip


def link_table(table: pd.DataFrame) -> str:
    """Return a row for each range of forces and for each link, and one for all."""
    rows = [
        cells(f"{low} to {high} N", own)
        for low, high in pairwise(EDGES)
        if len(own := table[table["force"].between(low, high, inclusive="left")])
    ]
    rows += [cells(f"on link {link}", own) for link, own in table.groupby("link")]
    return markdown(COLUMNS, [*rows, cells("all", table)])


def cells(title: str, own: pd.DataFrame) -> list[str]:
    """Return the cells of some contacts."""
    named, right, held = (own[name].astype(bool) for name in ("named", "right", "held"))
    counts = (len(own), (named & right).sum(), (named & ~right).sum(), (~named).sum())
    shares = f"{own['stated'].mean():.0%}", f"{right.mean():.0%}"
    return [title, *map(str, counts), *shares, f"{own['likely'].mean():.1f}", f"{held.mean():.0%}"]
