"""The tables of results: `columns.yaml` names them, a function of the same name makes the rows.

Its parameters name the kinds of results that it needs, of one recording or arm: only those with the
first kind have rows, others are None where there are none. `published` and `every`, the results of
the first kind by recording, may follow.
"""
