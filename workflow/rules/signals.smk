rule estimate_clocks:
    input:
        robot=result("robot.parquet"),
        force=result("force.parquet"),
        imu=result("imu.parquet"),
        quality=result("quality.json"),
        kinematics=result("kinematics.parquet"),
        code=code("estimate_clocks"),
    output:
        clocks=result("own_clocks.json"),
    log:
        f"{RESULTS}/logs/estimate_clocks/{{recording}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/estimate_clocks/{{recording}}.tsv"
    script:
        "../scripts/estimate_clocks.py"


rule pool_drifts:
    input:
        clocks=free_results("own_clocks.json"),
        code=code("pool_drifts"),
    output:
        drifts=parameter("drifts.json"),
    log:
        f"{RESULTS}/logs/pool_drifts/{{robot}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/pool_drifts/{{robot}}.tsv"
    params:
        recordings=contact_free,
        hosts=STUDY.devices_of_hosts(),
    script:
        "../scripts/pool_drifts.py"


rule align_signals:
    input:
        **({"drifts": parameter_of("drifts.json")} if STUDY.hosts else {}),
        robot=result("robot.parquet"),
        force=result("force.parquet"),
        imu=result("imu.parquet"),
        clocks=result("own_clocks.json"),
        code=code("align_signals"),
    output:
        signals=result("signals.parquet"),
        clocks=result("clocks.json"),
    log:
        f"{RESULTS}/logs/align_signals/{{recording}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/align_signals/{{recording}}.tsv"
    script:
        "../scripts/align_signals.py"


rule calibrate_imu:
    input:
        signals=fitted_results("signals.parquet"),
        kinematics=fitted_results("kinematics.parquet"),
        clocks=fitted_results("clocks.json"),
        arm=arm_file,
        code=code("calibrate_imu"),
    output:
        calibration=parameter("imu.json"),
    log:
        f"{RESULTS}/logs/calibrate_imu/{{robot}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/calibrate_imu/{{robot}}.tsv"
    params:
        **SETTINGS.lowpass.accelerations.model_dump(),
        recordings=fitted_on,
        gravities=fitted_gravities,
    script:
        "../scripts/calibrate_imu.py"


rule smooth_motion:
    input:
        signals=result("signals.parquet"),
        code=code("smooth_motion"),
    output:
        motion=result("motion.parquet"),
        summary=result("motion.json"),
    log:
        f"{RESULTS}/logs/smooth_motion/{{recording}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/smooth_motion/{{recording}}.tsv"
    script:
        "../scripts/smooth_motion.py"


rule fuse_imu:
    input:
        signals=result("signals.parquet"),
        kinematics=result("kinematics.parquet"),
        clocks=result("clocks.json"),
        calibration=parameter_of("imu.json"),
        arm=arm_file,
        code=code("fuse_imu"),
    output:
        motion=result("fused_motion.parquet"),
        summary=result("fused_motion.json"),
    log:
        f"{RESULTS}/logs/fuse_imu/{{recording}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/fuse_imu/{{recording}}.tsv"
    params:
        recording="{recording}",
        gravity=gravity_of,
    script:
        "../scripts/fuse_imu.py"


rule compare_accelerations:
    input:
        signals=result("signals.parquet"),
        kinematics=result("kinematics.parquet"),
        motion=result("motion.parquet"),
        fused=result("fused_motion.parquet"),
        clocks=result("clocks.json"),
        imu=result("imu.parquet"),
        quality=result("quality.json"),
        other_signals=contact_free_results("signals.parquet"),
        other_kinematics=contact_free_results("kinematics.parquet"),
        other_clocks=contact_free_results("clocks.json"),
        arm=arm_file,
        code=code("compare_accelerations"),
    output:
        accelerations=result("accelerations.parquet"),
        summary=result("accelerations.json"),
    log:
        f"{RESULTS}/logs/compare_accelerations/{{recording}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/compare_accelerations/{{recording}}.tsv"
    params:
        **SETTINGS.lowpass.accelerations.model_dump(),
        gravity=gravity_of,
        others=other_contact_free,
        other_gravities=lambda wildcards: gravities(other_contact_free(wildcards)),
    script:
        "../scripts/compare_accelerations.py"
