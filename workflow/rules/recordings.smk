rule repair_frames:
    input:
        raw=raw_files,
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
        folder=lambda wildcards: recording_of(wildcards).folder,
        format=lambda wildcards: recording_of(wildcards).format,
        max_gap_s=SETTINGS.repair_frames.max_gap_s,
    script:
        "../scripts/repair_frames.py"
