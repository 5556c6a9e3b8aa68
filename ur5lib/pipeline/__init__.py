"""The workflow's steps on typed records of the tables in results/."""
