# Only for a study with published values: the thesis's methods, figures and numbers.
from ur5lib.topics.thesis.reference import read_reference

if STUDY.reference:
    try:
        PRINTED = read_reference(STUDY.reference)
    except InputError as error:
        raise WorkflowError(f"the study has errors\n`reference`: {error}")

    recorded = RECORDINGS.keys()
    ALL_PRINTED = sorted(PRINTED.recordings() & recorded)
    EXPLAINED = sorted(PRINTED.explained() & recorded)
    FURTHER_FORCES.append("published_forces.parquet")
    shown = {*SELECTION.illustrated, *ALL_PRINTED}
    RUNS_FOR |= {
        "draw_figures": [name for name in RECORDINGS if name in shown],
        "draw_tracking": sorted(PRINTED.recordings("closed_loop_q", "closed_loop_qd") & recorded)
        or SELECTION.illustrated,
        "draw_filtered_first": sorted(PRINTED.explained_accelerations().keys() & recorded),
        "draw_older_model": sorted(PRINTED.of_older_model() & recorded),
        "draw_current_torque": sorted(PRINTED.recordings("current_torque") & recorded),
        "draw_published_accelerations": sorted(PRINTED.recordings("acceleration_mae") & recorded),
        "draw_published_forces": sorted(PRINTED.recordings("force_mae", "force_max") & recorded),
    }

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
            published=result("published_forces.parquet"),
            errors=result("closed_loop_mae.csv"),
            gains=result("gains.csv"),
            published_gains=result("published_gains.csv"),
            constants=result("published_constants.csv"),
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
            **drawn("{recording}", "positions", "velocities"),
        log:
            **traces("draw_tracking", "{recording}"),
        params:
            code=code("draw_tracking"),
        run:
            run_step(rule, input, output, params, log)

    rule draw_filtered_first:
        input:
            reference=STUDY.reference,
            signals=result("signals.parquet"),
            kinematics=result("kinematics.parquet"),
            imu=result("imu.parquet"),
            quality=result("quality.json"),
            arm=parameter_of("described.yaml"),
        output:
            **drawn("{recording}", "accelerations_filtered_first"),
        log:
            **traces("draw_filtered_first", "{recording}"),
        params:
            code=code("draw_filtered_first"),
            name="{recording}",
            gravity=of_recording(SELECTION.gravity),
        run:
            run_step(rule, input, output, params, log)

    rule draw_published_filters:
        output:
            **drawn("", "filters_published"),
        log:
            **traces("draw_published_filters"),
        params:
            code=code("draw_published_filters"),
            order=SETTINGS.lowpass.published_forces.order,
            cutoff=SETTINGS.lowpass.published_forces.cutoff_hz,
        run:
            run_step(rule, input, output, params, log)

    rule draw_older_model:
        input:
            reference=STUDY.reference,
            signals=result("signals.parquet"),
            closed_loop=result("closed_loop.parquet"),
            arm=parameter_of("arm.yaml"),
        output:
            **drawn("{recording}", "positions_older", "velocities_older", "torques_older"),
        log:
            **traces("draw_older_model", "{recording}"),
        params:
            code=code("draw_older_model"),
            recording="{recording}",
        run:
            run_step(rule, input, output, params, log)

    rule draw_published_accelerations:
        input:
            accelerations=result("accelerations.parquet"),
        output:
            **drawn("{recording}", "accelerations_published"),
        log:
            **traces("draw_published_accelerations", "{recording}"),
        params:
            code=code("draw_published_accelerations"),
        run:
            run_step(rule, input, output, params, log)

    rule draw_published_forces:
        input:
            published=result("published_forces.parquet"),
            sensor=result("sensor.parquet"),
        output:
            **drawn(
                "{recording}",
                "forces_printed",
                "forces_friction_printed",
                "forces_corrected",
                "forces_friction_corrected",
            ),
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
            **drawn("{recording}", "current_torque_printed", "current_torque_friction_printed"),
        log:
            **traces("draw_current_torque", "{recording}"),
        params:
            code=code("draw_current_torque"),
        run:
            run_step(rule, input, output, params, log)

    rule compare_with_print:
        input:
            reference=STUDY.reference,
            tables=tables_of([STUDY.study], PRINTED.tables()),
            signals=results("signals.parquet", EXPLAINED),
            kinematics=results("kinematics.parquet", EXPLAINED),
            imu=results("imu.parquet", EXPLAINED),
            quality=results("quality.json", EXPLAINED),
            arms=parameters("described.yaml"),
        output:
            **tables(["printed", "errata"]),
        log:
            **traces("compare_with_print"),
        params:
            code=code("compare_with_print"),
            arm_of={name: SELECTION.arm(name) for name in EXPLAINED},
            gravities=SELECTION.gravities(EXPLAINED),
        run:
            run_step(rule, input, output, params, log)

    rule list_printed_friction:
        input:
            friction=parameter("friction.json"),
            arm=parameter("described.yaml"),
        output:
            rows=parameter("printed_friction.csv"),
        log:
            **traces("list_printed_friction", "{robot}"),
        params:
            code=code("list_printed_friction"),
        run:
            run_step(rule, input, output, params, log)

    STEPS_THAT_DRAW = [one for one in RUNS_FOR if one.startswith("draw_") and one != "draw_figures"]

    rule write_published:
        input:
            described=parameters("described.yaml"),
            tables=lambda wildcards: [
                *rules.compare_with_print.output,
                *rules.make_tables.output,
                *rules.judge_study.output,
            ],
            figures=lambda wildcards: [
                *rules.draw_published_filters.output,
                *(
                    path
                    for step in STEPS_THAT_DRAW
                    for path in expand(getattr(rules, step).output, recording=RUNS_FOR[step])
                ),
            ],
        output:
            html=update(f"{RESULTS}/published.html"),
        log:
            **traces("write_published"),
        params:
            code=code("write_published", *PAGE),
            study=lambda wildcards: STUDY_TEXT,
        run:
            run_step(rule, input, output, params, log)
