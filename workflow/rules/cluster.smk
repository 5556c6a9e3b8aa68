# A cluster's job starts Snakemake once more, which snakemake-executor-plugin-slurm 2.8 does not tell the
# groups: it would start it yet again for each step. Local rules run where they are, in warm processes.
if workflow.remote_exec:
    workflow.localrules(*(step.name for step in workflow.rules))
