# What contact-free recordings of an arm let one observe.


rule measure_observability:
    input:
        motion=results_of(SELECTION.drawn, "motion.parquet"),
        currents=results_of(SELECTION.drawn, "currents.parquet"),
        predictions=results_of(SELECTION.drawn, "currents.json"),
        kinematics=results_of(SELECTION.drawn, "kinematics.parquet"),
        forces=results_of(SELECTION.drawn, "forces.parquet"),
        friction=parameter("friction.json"),
        residuals=parameter("residuals.json"),
        threshold=parameter("threshold.json"),
        arm=parameter("described.yaml"),
    output:
        observability=parameter("observability.csv"),
    log:
        **traces("measure_observability", "{robot}"),
    params:
        code=code("measure_observability"),
        contact_force_n=SETTINGS.contact.force_n,
    run:
        run_step(rule, input, output, params, log)


rule draw_observability:
    input:
        observability=parameter("observability.csv"),
    output:
        **drawn_by("draw_observability", "{robot}"),
    log:
        **traces("draw_observability", "{robot}"),
    params:
        code=code("draw_observability"),
    run:
        run_step(rule, input, output, params, log)
