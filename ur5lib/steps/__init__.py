"""The steps of the workflow, a module each: a typed function from records to records.

A rule of the same name in `workflow/rules` says which files they are; `ur5lib.jobs` reads and
writes them by the types of the signature.
"""
