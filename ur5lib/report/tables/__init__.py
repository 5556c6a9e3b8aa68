"""The tables of results, one module a table: its columns, and `rows` of a study's results.

Tidy: one value a row, SI units, joints 1 to 6. What a module `x` declares is tables/x.csv.
"""
