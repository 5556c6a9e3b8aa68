rule compute_kinematics:
    input:
        robot=result("robot.parquet"),
        arm=arm_file,
        code=code("compute_kinematics"),
    output:
        kinematics=result("kinematics.parquet"),
    log:
        f"{RESULTS}/logs/compute_kinematics/{{recording}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/compute_kinematics/{{recording}}.tsv"
    script:
        "../scripts/compute_kinematics.py"


rule compute_torques:
    input:
        signals=result("signals.parquet"),
        motion=result("motion.parquet"),
        arm=parameter_of("arm.yaml"),
        code=code("compute_torques"),
    output:
        torques=result("torques.parquet"),
        summary=result("torques.json"),
    log:
        f"{RESULTS}/logs/compute_torques/{{recording}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/compute_torques/{{recording}}.tsv"
    params:
        gravity=gravity_of,
        payload=payload_of,
    script:
        "../scripts/compute_torques.py"
