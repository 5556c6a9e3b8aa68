from ur5lib.jobs.snakemake_inside import run_all_here

# A cluster's job starts Snakemake again. snakemake-executor-plugin-slurm 2.8 does not pass on the
# groups, so each step would start another one. Local rules run inside the job, in warm processes.
if is_job_of_cluster(workflow):
    run_all_here(workflow)
