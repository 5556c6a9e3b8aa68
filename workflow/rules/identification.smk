rule estimate_gains:
    input:
        signals=result("signals.parquet"),
        arm=arm_file,
    output:
        closed_loop=result("closed_loop.parquet"),
        gains=result("gains.json"),
    log:
        **traces("estimate_gains", "{recording}"),
    group:
        in_cluster("motion")
    params:
        code=code("estimate_gains"),
        gravity=gravity_of,
    run:
        run_step(rule, input, output, params, log)


rule fit_rotor_inertia:
    input:
        signals=results_of(fitted_on, "signals.parquet"),
        motion=results_of(fitted_on, "motion.parquet"),
        arm=arm_file,
    output:
        rotors=parameter("rotor_inertia.json"),
    log:
        **traces("fit_rotor_inertia", "{robot}"),
    group:
        in_cluster("fits")
    params:
        **SETTINGS.lowpass.motion.model_dump(),
        code=code("fit_rotor_inertia"),
        recordings=fitted_on,
        gravities=gravities_of(fitted_on),
    run:
        run_step(rule, input, output, params, log)


rule identify_model:
    input:
        signals=results_of(fitted_on, "signals.parquet"),
        motion=results_of(fitted_on, "motion.parquet"),
        arm=arm_file,
        rotors=parameter("rotor_inertia.json"),
    output:
        arm=parameter("arm.yaml"),
        urdf=parameter("arm.urdf"),
        summary=parameter("identification.json"),
    log:
        **traces("identify_model", "{robot}"),
    group:
        in_cluster("fits")
    params:
        **SETTINGS.lowpass.motion.model_dump(),
        code=code("identify_model"),
        recordings=fitted_on,
        gravities=gravities_of(fitted_on),
    run:
        run_step(rule, input, output, params, log)


rule fit_friction:
    input:
        signals=results_of(fitted_on, "signals.parquet"),
        motion=results_of(fitted_on, "motion.parquet"),
        torques=results_of(fitted_on, "torques.parquet"),
        contradictions=results_of(fitted_on, "contradictions.json"),
        quality=results_of(fitted_on, "quality.json"),
        postures=postures_of,
        arm=parameter("arm.yaml"),
    output:
        friction=parameter("friction.json"),
    log:
        **traces("fit_friction", "{robot}"),
    group:
        in_cluster("fits")
    params:
        **SETTINGS.lowpass.currents.model_dump(),
        code=code("fit_friction"),
        recordings=fitted_on,
        dates=lambda wildcards: [date_of(name) for name in fitted_on(wildcards)],
    run:
        run_step(rule, input, output, params, log)


rule rank_recordings:
    input:
        motion=results_of(fitted_on, "motion.parquet"),
        loads=results_of(fitted_on, "torques.json"),
        friction=parameter("friction.json"),
        identification=parameter("identification.json"),
        arm=parameter("arm.yaml"),
    output:
        ranking=parameter("next_recordings.csv"),
    log:
        **traces("rank_recordings", "{robot}"),
    group:
        in_cluster("fits")
    params:
        code=code("rank_recordings"),
        recordings=fitted_on,
        gravities=gravities_of(fitted_on),
    run:
        run_step(rule, input, output, params, log)


rule estimate_payload:
    input:
        signals=result("signals.parquet"),
        motion=result("motion.parquet"),
        torques=result("torques.parquet"),
        friction=parameter_of("friction.json"),
        arm=parameter_of("arm.yaml"),
    output:
        payload=result("payload.json"),
        regressor=result("load_regressor.parquet"),
    log:
        **traces("estimate_payload", "{recording}"),
    group:
        in_cluster("fits")
    params:
        **SETTINGS.lowpass.currents.model_dump(),
        code=code("estimate_payload"),
        recording="{recording}",
        gravity=gravity_of,
    run:
        run_step(rule, input, output, params, log)


rule predict_currents:
    input:
        signals=result("signals.parquet"),
        motion=result("motion.parquet"),
        torques=result("torques.parquet"),
        load=result("torques.json"),
        contradictions=result("contradictions.json"),
        payload=result("payload.json"),
        regressor=result("load_regressor.parquet"),
        unloaded=results_of(fitted_on, "payload.json"),
        friction=parameter_of("friction.json"),
        arm=parameter_of("arm.yaml"),
    output:
        currents=result("currents.parquet"),
        summary=result("currents.json"),
    log:
        **traces("predict_currents", "{recording}"),
    group:
        in_cluster("fits")
    params:
        **SETTINGS.lowpass.currents.model_dump(),
        code=code("predict_currents"),
        recording="{recording}",
        role=lambda wildcards: recording_of(wildcards).role,
        untouched=lambda wildcards: recording_of(wildcards).untouched,
    run:
        run_step(rule, input, output, params, log)


rule examine_joints:
    input:
        quality=result("quality.json"),
        signals=result("signals.parquet"),
        motion=result("motion.parquet"),
        torques=result("torques.parquet"),
        currents=result("currents.json"),
        friction=parameter_of("friction.json"),
        arm=parameter_of("arm.yaml"),
    output:
        checkup=result("checkup.json"),
    log:
        **traces("examine_joints", "{recording}"),
    group:
        in_cluster("fits")
    params:
        **SETTINGS.lowpass.currents.model_dump(),
        code=code("examine_joints"),
        recording="{recording}",
        date=lambda wildcards: date_of(wildcards.recording),
    run:
        run_step(rule, input, output, params, log)


rule track_health:
    input:
        checkups=results_of(contact_free, "checkup.json"),
        motion=results_of(contact_free, "motion.parquet"),
    output:
        health=parameter("health.csv"),
        changes=parameter("health_changes.csv"),
    log:
        **traces("track_health", "{robot}"),
    priority: 1  # beside batches that need nothing of it: of thousands of recordings, it takes long
    group:
        in_cluster("fits")
    params:
        code=code("track_health"),
    run:
        run_step(rule, input, output, params, log)


rule draw_health:
    input:
        arm=parameter("described.yaml"),
        health=parameter("health.csv"),
        changes=parameter("health_changes.csv"),
    output:
        **drawn_by("draw_health", "{robot}"),
    log:
        **traces("draw_health", "{robot}"),
    group:
        in_cluster("fits")
    params:
        code=code("draw_health"),
    run:
        run_step(rule, input, output, params, log)
