# What only a study with published values has: the thesis's methods, its figures, its numbers.
rule rebuild_thesis:
    input:
        signals=result("signals.parquet"),
        motion=result("motion.parquet"),
        torques=result("torques.parquet"),
        kinematics=result("kinematics.parquet"),
        premises=result("premises.json"),
        friction=parameter_of("friction.json"),
        arm=parameter_of("described.yaml"),
    output:
        closed_loop=result("closed_loop.parquet"),
        gains=result("gains.json"),
        published=result("published_forces.parquet"),
        constants=result("published_constants.json"),
    log:
        **traces("rebuild_thesis", "{recording}"),
    params:
        code=code("rebuild_thesis"),
        gravity=of_recording(SELECTION.gravity),
        lowpass=design(SETTINGS.lowpass.published_forces),
        min_singular_value=SETTINGS.singularities.min_singular_value,
    run:
        run_step(rule, input, output, params, log)


rule draw_tracking:
    input:
        signals=result("signals.parquet"),
        closed_loop=result("closed_loop.parquet"),
        arm=parameter_of("arm.yaml"),
    output:
        **drawn_by("draw_tracking", "{recording}"),
    log:
        **traces("draw_tracking", "{recording}"),
    params:
        code=code("draw_tracking"),
    run:
        run_step(rule, input, output, params, log)


rule draw_filtered_first:
    input:
        **REFERENCE,
        signals=result("signals.parquet"),
        kinematics=result("kinematics.parquet"),
        imu=result("imu.parquet"),
        quality=result("quality.json"),
        arm=parameter_of("described.yaml"),
    output:
        **drawn_by("draw_filtered_first", "{recording}"),
    log:
        **traces("draw_filtered_first", "{recording}"),
    params:
        code=code("draw_filtered_first"),
        recording="{recording}",
        gravity=of_recording(SELECTION.gravity),
    run:
        run_step(rule, input, output, params, log)


rule draw_older_model:
    input:
        **REFERENCE,
        signals=result("signals.parquet"),
        closed_loop=result("closed_loop.parquet"),
        arm=parameter_of("arm.yaml"),
    output:
        **drawn_by("draw_older_model", "{recording}"),
    log:
        **traces("draw_older_model", "{recording}"),
    params:
        code=code("draw_older_model"),
        recording="{recording}",
    run:
        run_step(rule, input, output, params, log)


rule draw_published_forces:
    input:
        published=result("published_forces.parquet"),
        sensor=result("sensor.parquet"),
    output:
        **drawn_by("draw_published_forces", "{recording}"),
    log:
        **traces("draw_published_forces", "{recording}"),
    params:
        code=code("draw_published_forces"),
    run:
        run_step(rule, input, output, params, log)


rule draw_current_torque:
    input:
        signals=result("signals.parquet"),
        torques=result("torques.parquet"),
        arm=parameter_of("described.yaml"),
    output:
        **drawn_by("draw_current_torque", "{recording}"),
    log:
        **traces("draw_current_torque", "{recording}"),
    params:
        code=code("draw_current_torque"),
    run:
        run_step(rule, input, output, params, log)


rule compare_with_print:
    input:
        **REFERENCE,
        tables=tables_of([STUDY.study], SELECTION.published.tables()),
        signals=results("signals.parquet", SELECTION.explained()),
        kinematics=results("kinematics.parquet", SELECTION.explained()),
        imu=results("imu.parquet", SELECTION.explained()),
        quality=results("quality.json", SELECTION.explained()),
        arms=parameters("described.yaml"),
    output:
        **tables(["printed"]),
    log:
        **traces("compare_with_print"),
    params:
        code=code("compare_with_print"),
        arm_of={name: SELECTION.arm(name) for name in SELECTION.explained()},
        gravities=SELECTION.gravities(SELECTION.explained()),
    run:
        run_step(rule, input, output, params, log)
