# The steps of a recording, in their order. A new step begins where recordings wait for each other:
# for drifts of hosts, the arm's model, friction, load in others, residuals and thresholds.


rule read_recording:
    input:
        raw=of_recording(SELECTION.raw_files),
        arm=parameter_of("described.yaml"),
    output:
        robot=result("robot.parquet"),
        force=result("force.parquet"),
        imu=result("imu.parquet"),
        kinematics=result("kinematics.parquet"),
        quality=result("quality.json"),
        clocks=result("own_clocks.json"),
    log:
        **traces("read_recording", "{recording}"),
    params:
        **from_study("read_recording"),
        code=code("read_recording"),
    run:
        run_step(rule, input, output, params, log)


# Postures at rest, without time: no other step runs for them.
rule read_postures:
    input:
        raw=of_recording(SELECTION.raw_files),
        arm=parameter_of("described.yaml"),
    output:
        postures=posture("postures.json"),
        judgement=posture("judgement.json"),
    log:
        **traces("read_postures", "{recording}"),
    params:
        **from_study("read_postures"),
        code=code("read_postures"),
    run:
        run_step(rule, input, output, params, log)


rule align_recording:
    input:
        **({"drifts": parameter_of("drifts.json")} if STUDY.hosts else {}),
        robot=result("robot.parquet"),
        force=result("force.parquet"),
        imu=result("imu.parquet"),
        clocks=result("own_clocks.json"),
    output:
        signals=result("signals.parquet"),
        motion=result("motion.parquet"),
        alignment=result("alignment.json"),
    log:
        **traces("align_recording", "{recording}"),
    params:
        code=code("align_recording"),
    run:
        run_step(rule, input, output, params, log)


rule compute_torques:
    input:
        signals=result("signals.parquet"),
        motion=result("motion.parquet"),
        arm=parameter_of("arm.yaml"),
    output:
        torques=result("torques.parquet"),
        premises=result("premises.json"),
    log:
        **traces("compute_torques", "{recording}"),
    params:
        **from_study("compute_torques"),
        code=code("compute_torques"),
    run:
        run_step(rule, input, output, params, log)


rule estimate_load:
    input:
        signals=result("signals.parquet"),
        motion=result("motion.parquet"),
        before=lambda wildcards: results("motion.parquet", SELECTION.before(wildcards.recording)),
        torques=result("torques.parquet"),
        friction=parameter_of("friction.json"),
        arm=parameter_of("arm.yaml"),
    output:
        payload=result("payload.json"),
    log:
        **traces("estimate_load", "{recording}"),
    params:
        **from_study("estimate_load"),
        code=code("estimate_load"),
    run:
        run_step(rule, input, output, params, log)


rule predict_currents:
    input:
        signals=result("signals.parquet"),
        motion=result("motion.parquet"),
        before=lambda wildcards: results("motion.parquet", SELECTION.before(wildcards.recording)),
        torques=result("torques.parquet"),
        premises=result("premises.json"),
        payload=result("payload.json"),
        unloaded=lambda wildcards: results(
            "payload.json", fitted_on(SELECTION.arm(wildcards.recording))
        ),
        friction=parameter_of("friction.json"),
        arm=parameter_of("arm.yaml"),
    output:
        currents=result("currents.parquet"),
        summary=result("currents.json"),
    log:
        **traces("predict_currents", "{recording}"),
    params:
        **from_study("predict_currents"),
        code=code("predict_currents"),
    run:
        run_step(rule, input, output, params, log)


rule estimate_forces:
    input:
        signals=result("signals.parquet"),
        kinematics=result("kinematics.parquet"),
        motion=result("motion.parquet"),
        torques=result("torques.parquet"),
        currents=result("currents.parquet"),
        premises=result("premises.json"),
        friction=parameter_of("friction.json"),
        residuals=parameter_of("residuals.json"),
        arm=parameter_of("described.yaml"),
    output:
        forces=result("forces.parquet"),
    log:
        **traces("estimate_forces", "{recording}"),
    params:
        **from_study("estimate_forces"),
        code=code("estimate_forces"),
    run:
        run_step(rule, input, output, params, log)


# Independent of the forces, whose steps do not need the IMU.
rule compare_accelerations:
    input:
        quality=result("quality.json"),
        imu=result("imu.parquet"),
        kinematics=result("kinematics.parquet"),
        signals=result("signals.parquet"),
        motion=result("motion.parquet"),
        alignment=result("alignment.json"),
        arm=parameter_of("arm.yaml"),
        calibration=parameter_of("imu.json"),
        calibration_without_each=parameter_of("imu_without_each.json"),
    output:
        fused=result("fused_motion.parquet"),
        accelerations=result("accelerations.parquet"),
        comparison=result("imu_comparison.json"),
        errors=result("acceleration_mae.csv"),
        innovations=result("innovations.csv"),
    log:
        **traces("compare_accelerations", "{recording}"),
    params:
        code=code("compare_accelerations"),
        name="{recording}",
        gravity=of_recording(SELECTION.gravity),
        lowpass=design(SETTINGS.lowpass.accelerations),
    run:
        run_step(rule, input, output, params, log)


rule judge_sensor:
    input:
        further=further_forces,
        quality=result("quality.json"),
        force=result("force.parquet"),
        kinematics=result("kinematics.parquet"),
        signals=result("signals.parquet"),
        motion=result("motion.parquet"),
        alignment=result("alignment.json"),
        premises=result("premises.json"),
        currents=result("currents.parquet"),
        forces=result("forces.parquet"),
        arm=parameter_of("arm.yaml"),
        friction=parameter_of("friction.json"),
    output:
        sensor=result("sensor.parquet"),
        compared=result("beside_sensor.json"),
    log:
        **traces("judge_sensor", "{recording}"),
    params:
        code=code("judge_sensor"),
        role=lambda wildcards: RECORDINGS[wildcards.recording].role,
        gravity=of_recording(SELECTION.gravity),
        mounting=of_recording(SELECTION.sensor_mounting),
        bias_window_s=SETTINGS.sensor.bias_window_s,
        min_singular_value=SETTINGS.singularities.min_singular_value,
    run:
        run_step(rule, input, output, params, log)


rule judge_contacts:
    input:
        further=further_forces,
        kinematics=result("kinematics.parquet"),
        signals=result("signals.parquet"),
        motion=result("motion.parquet"),
        premises=result("premises.json"),
        currents=result("currents.parquet"),
        forces=result("forces.parquet"),
        sensor=result("sensor.parquet"),
        prediction=result("currents.json"),
        compared=result("beside_sensor.json"),
        arm=parameter_of("arm.yaml"),
        friction=parameter_of("friction.json"),
        residuals=parameter_of("residuals.json"),
        threshold=parameter_of("threshold.json"),
    output:
        contacts=result("contacts.json"),
    log:
        **traces("judge_contacts", "{recording}"),
    params:
        code=code("judge_contacts"),
        role=lambda wildcards: RECORDINGS[wildcards.recording].role,
        gravity=of_recording(SELECTION.gravity),
        contact_force_n=SETTINGS.contact.force_n,
    run:
        run_step(rule, input, output, params, log)


rule judge_recording:
    input:
        quality=result("quality.json"),
        signals=result("signals.parquet"),
        motion=result("motion.parquet"),
        before=lambda wildcards: results(
            "motion.parquet", SELECTION.before(wildcards.recording)[-1:]
        ),
        alignment=result("alignment.json"),
        torques=result("torques.parquet"),
        premises=result("premises.json"),
        currents=result("currents.parquet"),
        prediction=result("currents.json"),
        friction=parameter_of("friction.json"),
        residuals=parameter_of("residuals.json"),
    output:
        judgement=result("judgement.json"),
    log:
        **traces("judge_recording", "{recording}"),
    params:
        code=code("judge_recording"),
        cutoff_hz=SETTINGS.lowpass.currents.cutoff_hz,
    run:
        run_step(rule, input, output, params, log)
