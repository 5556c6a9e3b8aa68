# A cluster's job runs Snakemake again, without a profile: what must hold there, too, is set here.
import sys

# Only threads of this process reach the warm processes in which steps run.
if workflow.execution_settings:
    workflow.execution_settings.use_threads = True

# All steps of a cluster's job run in one go: else each would start Snakemake once more.
if workflow.remote_exec:
    workflow.group_settings.overwrite_groups = {step.name: "job" for step in workflow.rules}
    workflow.group_settings.group_components = {"job": sys.maxsize}
