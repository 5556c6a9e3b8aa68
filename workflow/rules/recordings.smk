rule repair_frames:
    input:
        raw=lambda wildcards: raw_files(wildcards.recording),
        arm=arm_file,
        code=code("repair_frames"),
    output:
        robot=result("robot.parquet"),
        force=result("force.parquet"),
        imu=result("imu.parquet"),
        quality=result("quality.json"),
    log:
        f"{RESULTS}/logs/repair_frames/{{recording}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/repair_frames/{{recording}}.tsv"
    params:
        recording=what_was_recorded,
        max_gap_s=SETTINGS.frames.max_gap_s,
        role=lambda wildcards: recording_of(wildcards).role,
        gravity=gravity_of,
        payload=payload_of,
    script:
        "../scripts/repair_frames.py"
