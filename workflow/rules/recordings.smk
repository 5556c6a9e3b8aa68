rule repair_frames:
    input:
        raw=lambda wildcards: raw_files(wildcards.recording),
        arm=arm_file,
    output:
        robot=result("robot.parquet"),
        force=result("force.parquet"),
        imu=result("imu.parquet"),
        quality=result("quality.json"),
    log:
        **traces("repair_frames", "{recording}"),
    group:
        in_cluster("read")
    params:
        code=code("repair_frames"),
        recording=what_was_recorded,
        max_gap_s=SETTINGS.frames.max_gap_s,
    run:
        run_step(rule, input, output, params, log)
