rule rebuild_forces:
    input:
        signals=result("signals.parquet"),
        motion=result("motion.parquet"),
        torques=result("torques.parquet"),
        kinematics=result("kinematics.parquet"),
        contradictions=result("contradictions.json"),
        friction=parameter_of("friction.json"),
        arm=arm_file,
    output:
        forces=result("published_forces.parquet"),
        constants=result("published_constants.json"),
    log:
        **traces("rebuild_forces", "{recording}"),
    group:
        in_cluster("forces")
    params:
        **SETTINGS.lowpass.published_forces.model_dump(),
        code=code("rebuild_forces"),
        min_singular_value=SETTINGS.singularities.min_singular_value,
    run:
        run_step(rule, input, output, params, log)


rule fit_residuals:
    input:
        currents=results_of(fitted_on, "currents.parquet"),
        motion=results_of(fitted_on, "motion.parquet"),
        friction=parameter("friction.json"),
    output:
        residuals=parameter("residuals.json"),
    log:
        **traces("fit_residuals", "{robot}"),
    group:
        in_cluster("fits")
    params:
        code=code("fit_residuals"),
        cutoff_hz=SETTINGS.lowpass.currents.cutoff_hz,
    run:
        run_step(rule, input, output, params, log)


rule estimate_forces:
    input:
        motion=result("motion.parquet"),
        currents=result("currents.parquet"),
        kinematics=result("kinematics.parquet"),
        residuals=parameter_of("residuals.json"),
        friction=parameter_of("friction.json"),
        contradictions=result("contradictions.json"),
        signals=result("signals.parquet"),
        torques=result("torques.parquet"),
        arm=arm_file,
    output:
        forces=result("forces.parquet"),
    log:
        **traces("estimate_forces", "{recording}"),
    group:
        in_cluster("forces")
    params:
        **SETTINGS.lowpass.currents.model_dump(),
        code=code("estimate_forces"),
        contact_force_n=SETTINGS.contact.force_n,
    run:
        run_step(rule, input, output, params, log)


rule compare_forces:
    input:
        signals=result("signals.parquet"),
        force=result("force.parquet"),
        quality=result("quality.json"),
        clocks=result("clocks.json"),
        load=result("torques.json"),
        kinematics=result("kinematics.parquet"),
        motion=result("motion.parquet"),
        published=result("published_forces.parquet"),
        forces=result("forces.parquet"),
        arm=arm_file,
    output:
        sensor=result("sensor.parquet"),
        summary=result("forces.json"),
    log:
        **traces("compare_forces", "{recording}"),
    group:
        in_cluster("forces")
    params:
        code=code("compare_forces"),
        gravity=gravity_of,
        mounting=sensor_mounting_of,
        bias_window_s=SETTINGS.sensor.bias_window_s,
        min_singular_value=SETTINGS.singularities.min_singular_value,
    run:
        run_step(rule, input, output, params, log)


rule audit_sensor:
    input:
        signals=result("signals.parquet"),
        kinematics=result("kinematics.parquet"),
        motion=result("motion.parquet"),
        load=result("torques.json"),
        contradictions=result("contradictions.json"),
        currents=result("currents.json"),
        quality=result("quality.json"),
        arm=arm_file,
    output:
        audit=result("audit.json"),
    log:
        **traces("audit_sensor", "{recording}"),
    group:
        in_cluster("forces")
    params:
        code=code("audit_sensor"),
        gravity=gravity_of,
    run:
        run_step(rule, input, output, params, log)


rule set_threshold:
    input:
        forces=results_of(fitted_on, "forces.parquet"),
        published=results_of(fitted_on, "published_forces.parquet"),
    output:
        threshold=parameter("threshold.json"),
    log:
        **traces("set_threshold", "{robot}"),
    group:
        in_cluster("document")
    params:
        code=code("set_threshold"),
        false_alarms_per_min=SETTINGS.alarms.false_per_min,
    run:
        run_step(rule, input, output, params, log)


rule detect_contacts:
    input:
        forces=result("forces.parquet"),
        published=result("published_forces.parquet"),
        sensor=result("sensor.parquet"),
        motion=result("motion.parquet"),
        currents=result("currents.parquet"),
        kinematics=result("kinematics.parquet"),
        regressor=result("load_regressor.parquet"),
        residuals=parameter_of("residuals.json"),
        threshold=parameter_of("threshold.json"),
        arm=arm_file,
    output:
        detection=result("detection.json"),
    log:
        **traces("detect_contacts", "{recording}"),
    group:
        in_cluster("document")
    params:
        code=code("detect_contacts"),
        tries=is_tried,
        contact_force_n=SETTINGS.contact.force_n,
    run:
        run_step(rule, input, output, params, log)


rule measure_observability:
    input:
        motion=results_of(drawn, "motion.parquet"),
        currents=results_of(drawn, "currents.parquet"),
        kinematics=results_of(drawn, "kinematics.parquet"),
        forces=results_of(drawn, "forces.parquet"),
        loads=results_of(drawn, "currents.json"),
        friction=parameter("friction.json"),
        residuals=parameter("residuals.json"),
        threshold=parameter("threshold.json"),
    output:
        observability=parameter("observability.csv"),
    log:
        **traces("measure_observability", "{robot}"),
    group:
        in_cluster("document")
    params:
        code=code("measure_observability"),
        recordings=drawn,
        contact_force_n=SETTINGS.contact.force_n,
    run:
        run_step(rule, input, output, params, log)


rule draw_observability:
    input:
        observability=parameter("observability.csv"),
    output:
        **drawn_by("draw_observability", "{robot}"),
    log:
        **traces("draw_observability", "{robot}"),
    group:
        in_cluster("document")
    params:
        code=code("draw_observability"),
    run:
        run_step(rule, input, output, params, log)
