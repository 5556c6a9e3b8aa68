# A cluster's job starts Snakemake once more. It runs its steps there, as many at once as it has
# cores, in warm processes; else each step would start Snakemake anew.
if workflow.remote_exec:
    for step in workflow.rules:
        step.group = None  # which no local rule has
    workflow.localrules(*(step.name for step in workflow.rules))
    workflow.register_resource("_nodes", int(os.environ.get("SLURM_CPUS_PER_TASK", 1)))
