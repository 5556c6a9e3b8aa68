"""The steps of the workflow, a module each: a typed function from records to records.

A rule of the same name in `workflow/rules` names the files of these records; `ur5lib.jobs` reads
and writes them by the types of the signature.
"""
