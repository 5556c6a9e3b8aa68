"""What ends a doubt: each row to be checked names the next candidate and an option."""

import re
from dataclasses import replace

from ur5lib.channels import CHANNELS, MEASURED_EFFORTS
from ur5lib.importing.identity import ORDER
from ur5lib.importing.stated_units import remedy
from ur5lib.records.account import NOTHING, AccountRow

REMEDY = re.compile(r"--[a-z]+|`[a-z_]+|ur5 describe|otherwise write")
OF_FILE = {  # what else it may be, and what tells, by the subject of a row on the whole file
    "robot": "another arm: --robot names it",
    ORDER: "another order: --joints names the joints, or that of each column, as 3,2,1,4,5,6",
    "role": "a fit, if nothing touches the arm: then write `role: fit`",
    "recording": "other columns than their names say: --columns names them",
    "efforts": "in one unit with those: --unit names it",
    "columns": "others than their names say: --columns names them",
}
OF_BLOCKS = {  # the same by the channel of columns
    "actual_q": f"in another unit: {remedy('actual_q', ['deg'])}; in the entry "
    "`units: {actual_q: […]}`; or no angles: --columns names others",
    "actual_qd": f"in another unit: {remedy('actual_qd', ['deg/s'])}; or --columns names them",
}
OF_SIGN = "with its sign turned: `units: {{{channel}: opposite}}` in the entry"
ANYTHING = "something else: --columns names it"


def with_remedy(row: AccountRow) -> AccountRow:
    """Return a row; one to be checked with the next candidate and an option."""
    if row.confidence != "check" or REMEDY.search(row.reason):
        return row
    return replace(row, reason="; ".join(filter(None, (row.reason, f"or {_else(row)}"))))


def _else(row: AccountRow) -> str:
    channel = row.taken_for.partition(" ")[0]
    if row.subject in OF_FILE or channel in OF_BLOCKS:
        return OF_FILE.get(row.subject) or OF_BLOCKS[channel]
    if channel not in CHANNELS or channel == NOTHING:
        return ANYTHING
    unit = CHANNELS[channel].unit
    if channel in MEASURED_EFFORTS:
        return f"in another unit: {remedy(channel)}"
    of_unit = f"in another unit: --unit {channel}={unit}, if it is right"
    return of_unit if unit in ("A", "Nm") else OF_SIGN.format(channel=channel)
