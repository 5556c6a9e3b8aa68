rule estimate_clocks:
    input:
        robot=result("robot.parquet"),
        force=result("force.parquet"),
        imu=result("imu.parquet"),
        quality=result("quality.json"),
        kinematics=result("kinematics.parquet"),
    output:
        clocks=result("own_clocks.json"),
    log:
        **traces("estimate_clocks", "{recording}"),
    group:
        in_cluster("read")
    params:
        code=code("estimate_clocks"),
    run:
        run_step(rule, input, output, params, log)


# It takes less than a second: on a cluster it is no job, but runs where Snakemake was started.
localrules:
    pool_drifts,


rule pool_drifts:
    input:
        clocks=results_of(contact_free, "own_clocks.json"),
    output:
        drifts=parameter("drifts.json"),
    log:
        **traces("pool_drifts", "{robot}"),
    params:
        code=code("pool_drifts"),
        recordings=contact_free,
        hosts=STUDY.devices_of_hosts(),
    run:
        run_step(rule, input, output, params, log)


rule align_signals:
    input:
        **({"drifts": parameter_of("drifts.json")} if STUDY.hosts else {}),
        robot=result("robot.parquet"),
        force=result("force.parquet"),
        imu=result("imu.parquet"),
        clocks=result("own_clocks.json"),
    output:
        signals=result("signals.parquet"),
        clocks=result("clocks.json"),
    log:
        **traces("align_signals", "{recording}"),
    group:
        in_cluster("motion")
    params:
        code=code("align_signals"),
    run:
        run_step(rule, input, output, params, log)


rule calibrate_imu:
    input:
        signals=results_of(fitted_on, "signals.parquet"),
        kinematics=results_of(fitted_on, "kinematics.parquet"),
        clocks=results_of(fitted_on, "clocks.json"),
        arm=arm_file,
    output:
        calibration=parameter("imu.json"),
    log:
        **traces("calibrate_imu", "{robot}"),
    group:
        in_cluster("fits")
    params:
        **SETTINGS.lowpass.accelerations.model_dump(),
        code=code("calibrate_imu"),
        recordings=fitted_on,
        gravities=gravities_of(fitted_on),
    run:
        run_step(rule, input, output, params, log)


# The same step, on recordings that no calibration above has seen: it judges, and corrects nothing. Of
# many, those drawn do: each new one would let all others wait.
rule calibrate_imu_without_each:
    input:
        signals=results_of(drawn, "signals.parquet"),
        kinematics=results_of(drawn, "kinematics.parquet"),
        clocks=results_of(drawn, "clocks.json"),
        arm=arm_file,
    output:
        calibration=parameter("imu_without_each.json"),
    log:
        **traces("calibrate_imu_without_each", "{robot}"),
    group:
        in_cluster("fits")
    params:
        **SETTINGS.lowpass.accelerations.model_dump(),
        code=code("calibrate_imu"),
        recordings=drawn,
        gravities=gravities_of(drawn),
    run:
        run_step("calibrate_imu", input, output, params, log)


rule smooth_motion:
    input:
        signals=result("signals.parquet"),
    output:
        motion=result("motion.parquet"),
        noise=result("motion_noise.parquet"),
        summary=result("motion.json"),
    log:
        **traces("smooth_motion", "{recording}"),
    group:
        in_cluster("motion")
    params:
        code=code("smooth_motion"),
    run:
        run_step(rule, input, output, params, log)


rule fuse_imu:
    input:
        signals=result("signals.parquet"),
        kinematics=result("kinematics.parquet"),
        clocks=result("clocks.json"),
        motion=result("motion.parquet"),
        noise=result("motion_noise.parquet"),
        account=result("motion.json"),
        calibration=parameter_of("imu.json"),
        arm=arm_file,
    output:
        fused=result("fused_motion.parquet"),
        summary=result("fused_motion.json"),
    log:
        **traces("fuse_imu", "{recording}"),
    group:
        in_cluster("forces")
    params:
        code=code("fuse_imu"),
        recording="{recording}",
        gravity=gravity_of,
    run:
        run_step(rule, input, output, params, log)


rule compare_accelerations:
    input:
        signals=result("signals.parquet"),
        kinematics=result("kinematics.parquet"),
        motion=result("motion.parquet"),
        fused=result("fused_motion.parquet"),
        clocks=result("clocks.json"),
        imu=result("imu.parquet"),
        quality=result("quality.json"),
        calibration=parameter_of("imu_without_each.json"),
        arm=arm_file,
    output:
        accelerations=result("accelerations.parquet"),
        summary=result("accelerations.json"),
    log:
        **traces("compare_accelerations", "{recording}"),
    group:
        in_cluster("forces")
    params:
        **SETTINGS.lowpass.accelerations.model_dump(),
        code=code("compare_accelerations"),
        gravity=gravity_of,
        recording="{recording}",
    run:
        run_step(rule, input, output, params, log)
