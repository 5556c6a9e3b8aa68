COMPARED = [
    "quality",
    "parameters",
    "rotor_inertia",
    "friction",
    "payload",
    "current_rmse",
    "force_mae",
]
REPORT = PACKAGE / "report"
COLUMNS = REPORT / "tables" / "columns.yaml"
TABLES = [name for tables in read_yaml(COLUMNS).values() for name in tables]
PARTS = parts_of_tables()  # of the steps above
CONTENTS = REPORT / "page" / "contents.yaml", REPORT / "page" / "sentences.yaml"
TEMPLATES = REPORT / "page" / "templates"
PAGE = *CONTENTS, *(TEMPLATES / name for name in ("report.html.jinja", "lines.js", "zoom.js"))


rule draw_figures:
    input:
        signals=result("signals.parquet"),
        torques=result("torques.parquet"),
        accelerations=result("accelerations.parquet"),
        currents=result("currents.parquet"),
        kinematics=result("kinematics.parquet"),
        sensor=result("sensor.parquet"),
        forces=result("forces.parquet"),
        arm=parameter_of("arm.yaml"),
    output:
        **drawn_by("draw_figures", "{recording}"),
    log:
        **traces("draw_figures", "{recording}"),
    group:
        in_cluster("forces")
    params:
        code=code("draw_figures"),
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
    group:
        in_cluster("fits")
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
        arm=arm_file,
    output:
        **drawn_by("draw_filtered_first", "{recording}"),
    log:
        **traces("draw_filtered_first", "{recording}"),
    group:
        in_cluster("forces")
    params:
        code=code("draw_filtered_first"),
        gravity=gravity_of,
        recording="{recording}",
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
    group:
        in_cluster("forces")
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
    group:
        in_cluster("forces")
    params:
        code=code("draw_published_forces"),
    run:
        run_step(rule, input, output, params, log)


rule draw_current_torque:
    input:
        signals=result("signals.parquet"),
        torques=result("torques.parquet"),
        arm=arm_file,
    output:
        **drawn_by("draw_current_torque", "{recording}"),
    log:
        **traces("draw_current_torque", "{recording}"),
    group:
        in_cluster("fits")
    params:
        code=code("draw_current_torque"),
    run:
        run_step(rule, input, output, params, log)


rule tabulate_recording:
    input:
        **REFERENCE,
        quality=result("quality.json"),
        clocks=result("clocks.json"),
        signals=result("signals.parquet"),
        torques=result("torques.parquet"),
        contradictions=result("contradictions.json"),
        closed_loop=result_if_made("closed_loop.parquet", "estimate_gains"),
        gains=result_if_made("gains.json", "estimate_gains"),
        motion=result("motion.json"),
        fused=result("fused_motion.json"),
        forces=result("forces.json"),
        constants=result("published_constants.json"),
        currents=result("currents.json"),
        detection=result("detection.json"),
        audit=result_if_made("audit.json", "audit_sensor"),
    output:
        rows=result("rows.json"),
    log:
        **traces("tabulate_recording", "{recording}"),
    group:
        in_cluster("document")
    params:
        code=code("tabulate_recording", COLUMNS, TEMPLATES / "findings.yaml"),
    run:
        run_step(rule, input, output, params, log)


rule tabulate_postures:
    input:
        raw=lambda wildcards: raw_files(wildcards.recording),
        arm=arm_file,
    output:
        postures=f"{RESULTS}/postures/{{recording}}/postures.json",
        rows=f"{RESULTS}/postures/{{recording}}/rows.json",
    log:
        **traces("tabulate_postures", "{recording}"),
    group:
        in_cluster("read")
    params:
        code=code("tabulate_postures", COLUMNS, TEMPLATES / "findings.yaml"),
        name="{recording}",
        recording=what_was_recorded,
        gravity=gravity_of,
        payload=payload_of,
        tcp=tcp_of,
    run:
        run_step(rule, input, output, params, log)


# Thousands of inputs are given as functions: of a list, Snakemake weighs each path when it parses.
rule make_tables:
    input:
        **REFERENCE,
        **PARTS,
        rows=lambda wildcards: results("rows.json") + postures("rows.json", AT_REST),
        accelerations=lambda wildcards: results("accelerations.json"),
        rotors=parameters("rotor_inertia.json"),
        identification=parameters("identification.json"),
        calibration=parameters("imu.json"),
        friction=parameters("friction.json"),
        residuals=parameters("residuals.json"),
        arm=parameters("arm.yaml"),
    output:
        **tables([*TABLES, *PARTS]),
    log:
        **traces("make_tables"),
    group:
        in_cluster("document")
    params:
        code=code("make_tables", COLUMNS, TEMPLATES / "findings.yaml"),
    run:
        run_step(rule, input, output, params, log)


rule draw_friction:
    input:
        signals=results_of(fitted_on, "signals.parquet"),
        motion=results_of(fitted_on, "motion.parquet"),
        torques=results_of(fitted_on, "torques.parquet"),
        friction=parameter("friction.json"),
        arm=parameter("arm.yaml"),
    output:
        **drawn_by("draw_friction", "{robot}"),
    log:
        **traces("draw_friction", "{robot}"),
    group:
        in_cluster("fits")
    params:
        **SETTINGS.lowpass.currents.model_dump(),
        code=code("draw_friction"),
        recordings=fitted_on,
    run:
        run_step(rule, input, output, params, log)


rule draw_filters:
    input:
        **REFERENCE,
    output:
        **drawn_by("draw_filters"),
    log:
        **traces("draw_filters"),
    group:
        in_cluster("document")
    params:
        code=code("draw_filters"),
        lowpass=SETTINGS.lowpass.model_dump(),
    run:
        run_step(rule, input, output, params, log)


rule draw_models:
    input:
        arm=parameter("arm.yaml"),
    output:
        **drawn_by("draw_models", "{robot}"),
    log:
        **traces("draw_models", "{robot}"),
    group:
        in_cluster("fits")
    params:
        code=code("draw_models"),
    run:
        run_step(rule, input, output, params, log)


rule draw_calibration:
    input:
        errors=rules.make_tables.output.force_mae,
    output:
        **drawn_by("draw_calibration"),
    log:
        **traces("draw_calibration"),
    group:
        in_cluster("document")
    params:
        code=code("draw_calibration"),
    run:
        run_step(rule, input, output, params, log)


if REFERENCE:

    rule compare_with_print:
        input:
            **REFERENCE,
            tables=[f"{RESULTS}/tables/{name}.csv" for name in PUBLISHED.tables()],
            signals=results("signals.parquet", EXPLAINED),
            kinematics=results("kinematics.parquet", EXPLAINED),
            imu=results("imu.parquet", EXPLAINED),
            quality=results("quality.json", EXPLAINED),
            arm=[described(RECORDINGS[name].arm.known_as) for name in EXPLAINED],
        output:
            **tables(["printed"]),
        log:
            **traces("compare_with_print"),
        group:
            in_cluster("document")
        params:
            code=code("compare_with_print"),
            recordings=EXPLAINED,
            gravities=gravities(EXPLAINED),
        run:
            run_step(rule, input, output, params, log)


rule compare_studies:
    input:
        own=tables_of([STUDY.study], COMPARED if STUDY.compare_with else []),
        others=tables_of(STUDY.compare_with, COMPARED),
    output:
        **tables(["changes"]),
    log:
        **traces("compare_studies"),
    group:
        in_cluster("document")
    params:
        code=code("compare_studies"),
    run:
        run_step(rule, input, output, params, log)


BENCHMARKS = [path for path in of_every_job("log") if path.endswith(".tsv")]


rule time_steps:
    input:
        benchmarks=lambda wildcards: BENCHMARKS,
    output:
        **tables(["run_times"]),
    log:
        **traces("time_steps"),
    group:
        in_cluster("document")
    params:
        code=code("time_steps"),
    run:
        run_step(rule, input, output, params, log)


rule write_report:
    input:
        **REFERENCE,
        described=[described(robot) for robot in ROBOTS],
        tables=outputs_in("tables"),
        figures=outputs_in("figures"),
    output:
        html=report(f"{RESULTS}/report.html", caption="../captions/report.rst", category="Report"),
        pdf=report(f"{RESULTS}/report.pdf", caption="../captions/report.rst", category="Report"),
        study=f"{RESULTS}/configuration.yaml",
        results=f"{RESULTS}/results.json",
        schema=f"{RESULTS}/results.schema.json",
    log:
        **traces("write_report"),
    group:
        in_cluster("document")
    params:
        code=code("write_report", *PAGE, TEMPLATES / "report.typ"),
        study=lambda wildcards: STUDY_TEXT,
    run:
        run_step(rule, input, output, params, log)


# A recording's own page, on demand: `snakemake results/<study>/runs/<recording>.html`.
rule write_run:
    input:
        described=arm_file,
        tables=rules.make_tables.output,
        figures=figures_of_run,
    output:
        html=f"{RESULTS}/runs/{{recording}}.html",
    log:
        **traces("write_run", "{recording}"),
    group:
        in_cluster("document")
    params:
        code=code("write_run", *PAGE),
        study=lambda wildcards: STUDY_TEXT,
        recording="{recording}",
    run:
        run_step(rule, input, output, params, log)


rule describe_run:
    input:
        report=rules.write_report.output[:4],
        raw=lambda wildcards: [path for name in ENTRIES for path in raw_files(name)],
        extensions=[str(path) for path in source_files({own.file() for own in KINDS.values()})],
        files=rules.make_tables.output.files,
        tables=rules.write_report.input.tables,
        figures=rules.write_report.input.figures,
    output:
        crate=f"{RESULTS}/ro-crate-metadata.json",
        workflow=f"{RESULTS}/Snakefile",
    log:
        **traces("describe_run"),
    group:
        in_cluster("document")
    params:
        code=code("describe_run", SNAKEFILE, CITATION),
        title=lambda wildcards: STUDY.title,
    run:
        run_step(rule, input, output, params, log)
