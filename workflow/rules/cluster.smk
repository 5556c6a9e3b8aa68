# A cluster's job starts Snakemake again. snakemake-executor-plugin-slurm 2.8 does not pass on the
# groups, so each step would start another one. Local rules run inside the job, in warm processes.
if workflow.remote_exec:
    workflow.localrules(*(step.name for step in workflow.rules))
