"""A recording as a folder of CSV files, and units.csv with the units of their columns."""

from pathlib import Path

import pandas as pd

from ur5lib.exporting.contents import Contents
from ur5lib.tables import write_csv

DIGITS = 12


def write_csv_folder(contents: Contents, folder: Path) -> None:
    """Write <table>.csv for each table, `time` [s] first, and units.csv: table, column, unit.

    A cell is empty where a value is unknown. Raises InputError where a file cannot be written.
    """
    for name, table in contents.tables.items():
        flags = dict.fromkeys(table.select_dtypes(bool), int)  # 0 and 1: every program reads them
        write_csv(table.astype(flags).reset_index(), folder / f"{name}.csv", DIGITS)
    units = [
        (name, column, unit)
        for name, table in contents.tables.items()
        for column, unit in table.attrs["units"].items()
    ]
    write_csv(pd.DataFrame(units, columns=["table", "column", "unit"]), folder / "units.csv")
