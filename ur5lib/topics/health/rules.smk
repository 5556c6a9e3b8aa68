# The health of an arm, by its contact-free recordings.
RUNS_FOR["examine_joints"] = [name for robot in ROBOTS for name in contact_free(robot)]


rule examine_joints:
    input:
        quality=result("quality.json"),
        signals=result("signals.parquet"),
        motion=result("motion.parquet"),
        torques=result("torques.parquet"),
        prediction=result("currents.json"),
        friction=parameter_of("friction.json"),
        arm=parameter_of("arm.yaml"),
    output:
        checkup=result("checkup.json"),
    log:
        **traces("examine_joints", "{recording}"),
    params:
        code=code("examine_joints"),
        name="{recording}",
        date=of_recording(SELECTION.date),
        lowpass=design(SETTINGS.lowpass.currents),
    run:
        run_step(rule, input, output, params, log)


rule track_health:
    input:
        checkups=results_of(contact_free, "checkup.json"),
        motion=results_of(contact_free, "motion.parquet"),
    output:
        health=parameter("health.csv"),
        changes=parameter("health_changes.csv"),
    log:
        **traces("track_health", "{robot}"),
    priority: 1  # first, since it takes long for thousands of recordings
    params:
        code=code("track_health"),
    run:
        run_step(rule, input, output, params, log)


rule draw_health:
    input:
        arm=parameter("described.yaml"),
        health=parameter("health.csv"),
        changes=parameter("health_changes.csv"),
    output:
        **drawn("{robot}", "health"),
    log:
        **traces("draw_health", "{robot}"),
    params:
        code=code("draw_health"),
    run:
        run_step(rule, input, output, params, log)


rule judge_health:
    input:
        health=parameter("health.csv"),
        changes=parameter("health_changes.csv"),
    output:
        verdicts=parameter("health.verdicts.csv"),
    log:
        **traces("judge_health", "{robot}"),
    params:
        code=code("judge_health"),
    run:
        run_step(rule, input, output, params, log)
