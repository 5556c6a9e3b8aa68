rule align_signals:
    input:
        robot=result("robot.parquet"),
        force=result("force.parquet"),
        imu=result("imu.parquet"),
        quality=result("quality.json"),
        kinematics=result("kinematics.parquet"),
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


rule filter_signals:
    input:
        signals=result("signals.parquet"),
        code=code("filter_signals"),
    output:
        filtered=result("filtered.parquet"),
    log:
        f"{RESULTS}/logs/filter_signals/{{recording}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/filter_signals/{{recording}}.tsv"
    params:
        order=SETTINGS.filter_signals.order,
        cutoff_hz=SETTINGS.filter_signals.cutoff_hz,
    script:
        "../scripts/filter_signals.py"


rule smooth_motion:
    input:
        filtered=result("filtered.parquet"),
        code=code("smooth_motion"),
    output:
        motion=result("motion.parquet"),
    log:
        f"{RESULTS}/logs/smooth_motion/{{recording}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/smooth_motion/{{recording}}.tsv"
    script:
        "../scripts/smooth_motion.py"
