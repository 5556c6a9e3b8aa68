"""Whether two records of the pipeline hold the same samples."""

from collections.abc import Mapping
from dataclasses import fields

import numpy as np

from ur5lib.pipeline.records.table import Table


def same(own: Table, other: Table) -> None:
    assert type(own) is type(other)
    for field in fields(own):
        values = [getattr(record, field.name) for record in (own, other)]
        by_key = [dict(value) if isinstance(value, Mapping) else value for value in values]
        np.testing.assert_equal(*by_key)
