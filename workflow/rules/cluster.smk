# A cluster's job starts Snakemake once more, which is not told the groups. The plugin would start it
# yet again for each step of the group; as local rules, they run where they are, in warm processes.
if workflow.remote_exec:
    workflow.localrules(*(step.name for step in workflow.rules))
