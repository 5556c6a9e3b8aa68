# The value of further recordings of an arm, given its `fit` recordings.


rule rank_recordings:
    input:
        motion=results_of(fitted_on, "motion.parquet"),
        premises=results_of(fitted_on, "premises.json"),
        friction=parameter("friction.json"),
        identification=parameter("identification.json"),
        arm=parameter("arm.yaml"),
    output:
        ranking=parameter("next_recordings.csv"),
    log:
        **traces("rank_recordings", "{robot}"),
    params:
        code=code("rank_recordings"),
        gravities=gravities_of(fitted_on),
    run:
        run_step(rule, input, output, params, log)
