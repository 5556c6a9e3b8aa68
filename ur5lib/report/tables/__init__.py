"""The tables of results: `columns.yaml` names them, a function of the same name makes the rows."""
