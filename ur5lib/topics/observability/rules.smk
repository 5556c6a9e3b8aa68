# Observability on an arm, from its contact-free recordings.


rule measure_observability:
    input:
        motion=results_of(SELECTION.drawn, "motion.parquet"),
        currents=results_of(SELECTION.drawn, "currents.parquet"),
        predictions=results_of(SELECTION.drawn, "currents.json"),
        friction=parameter("friction.json"),
    output:
        observability=parameter("observability.csv"),
    log:
        **traces("measure_observability", "{robot}"),
    params:
        code=code("measure_observability"),
    run:
        run_step(rule, input, output, params, log)
