"""The tables in results/ as typed records: one module a table."""
