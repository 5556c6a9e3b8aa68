# Only for a study with published values: the thesis's methods, figures and numbers.
from ur5lib.topics.thesis.reference import read_reference

if not STUDY.reference:
    LEFT_OUT |= {path.stem for path in PACKAGE.glob("topics/thesis/*.py")}

if STUDY.reference:
    try:
        PRINTED = read_reference(STUDY.reference)
    except InputError as error:
        raise WorkflowError(f"the study has errors\n`reference`: {error}")

    recorded = RECORDINGS.keys()
    ALL_PRINTED = sorted(PRINTED.recordings() & recorded)
    EXPLAINED = sorted(PRINTED.explained() & recorded)
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
