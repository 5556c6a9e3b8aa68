# The steps of recordings and of arms: a rule for each, by what it declares next to its function;
# `python -m ur5lib.jobs.declared <step>` prints what it reads. Work is cut into steps where a job
# has to wait for other recordings: for drifts of hosts, the arm's model, its friction, loads found
# in other recordings, residuals and thresholds.


# These take less than a second: on a cluster, they run where Snakemake was started, not as jobs.
localrules:
    describe_arm,
    pool_drifts,
    set_threshold,


for step in STEPS:
    if step.name in LEFT_OUT:
        continue
    chosen = SELECTION.at_rest if step.of == "posture" else among(SELECTION, step.recordings)
    RUNS_FOR.setdefault(step.name, chosen)

    rule:
        name:
            step.name
        input:
            **inputs(step),
        output:
            **outputs(step),
        log:
            **traces(step.name, WILDCARDS[step.of]),
        priority: PRIORITY.get(step.name, 0)
        params:
            **settings(step),
            code=code_of(step),
        run:
            run_step(rule, input, output, params, log)


# The same step on recordings that the calibration has not used: it judges, and corrects nothing.
# Of many recordings, it uses those that are drawn: the others would wait for each new one.
rule calibrate_imu_without_each:
    input:
        **inputs(CALIBRATE_IMU._replace(recordings="drawn")),
    output:
        calibration=parameter("imu_without_each.json"),
    log:
        **traces("calibrate_imu_without_each", "{robot}"),
    params:
        **settings(CALIBRATE_IMU._replace(recordings="drawn")),
        code=code("calibrate_imu"),
    run:
        run_step("calibrate_imu", input, output, params, log)
