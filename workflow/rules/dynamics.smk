rule compute_kinematics:
    input:
        robot=result("robot.parquet"),
        arm=arm_file,
    output:
        kinematics=result("kinematics.parquet"),
    log:
        **traces("compute_kinematics", "{recording}"),
    group:
        in_cluster("read")
    params:
        code=code("compute_kinematics"),
    run:
        run_step(rule, input, output, params, log)


rule compute_torques:
    input:
        signals=result("signals.parquet"),
        motion=result("motion.parquet"),
        arm=parameter_of("arm.yaml"),
    output:
        torques=result("torques.parquet"),
        summary=result("torques.json"),
    log:
        **traces("compute_torques", "{recording}"),
    group:
        in_cluster("fits")
    params:
        code=code("compute_torques"),
        gravity=gravity_of,
        payload=payload_of,
    run:
        run_step(rule, input, output, params, log)


rule find_contradictions:
    input:
        signals=result("signals.parquet"),
        arm=parameter_of("arm.yaml"),
    output:
        contradictions=result("contradictions.json"),
    log:
        **traces("find_contradictions", "{recording}"),
    group:
        in_cluster("fits")
    params:
        code=code("find_contradictions"),
        gravity=gravity_of,
        payload=payload_of,
        tcp=tcp_of,
        role=lambda wildcards: recording_of(wildcards).role,
        cutoff_hz=SETTINGS.lowpass.currents.cutoff_hz,
    run:
        run_step(rule, input, output, params, log)
