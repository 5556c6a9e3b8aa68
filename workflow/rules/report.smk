WRITTEN = outputs_in("parameters") + outputs_in("recordings")  # by the steps above
OF_TOPICS = [path for path in WRITTEN if path.endswith(".verdicts.csv")]
PARTS = [path for path in WRITTEN if path.endswith(".csv") and path not in OF_TOPICS]  # of tables


rule draw_filters:
    output:
        **drawn("", "filters"),
    log:
        **traces("draw_filters"),
    params:
        code=code("draw_filters"),
        lowpass={name: design(one) for name, one in SETTINGS.lowpass},
    run:
        run_step(rule, input, output, params, log)


# Thousands of inputs are given as functions: Snakemake checks each path of a list when it parses.
rule make_tables:
    input:
        judgements=lambda wildcards: results("judgement.json")
        + postures("judgement.json", SELECTION.at_rest),
        comparison=lambda wildcards: results("imu_comparison.json"),
        compared=lambda wildcards: results("beside_sensor.json"),
        contacts=lambda wildcards: results("contacts.json"),
        identified=parameters("arm.yaml"),
        rotors=parameters("rotor_inertia.json"),
        identification=parameters("identification.json"),
        calibration=parameters("imu.json"),
        friction=parameters("friction.json"),
        residuals=parameters("residuals.json"),
        parts=lambda wildcards: PARTS,
    output:
        **tables([*TABLES, *sorted({Path(path).stem for path in PARTS})]),
    log:
        **traces("make_tables"),
    params:
        code=code("make_tables"),
        roles=lambda wildcards: {name: one.role for name, one in RECORDINGS.items()},
    run:
        run_step(rule, input, output, params, log)


rule judge_study:
    input:
        tables=rules.make_tables.output,
        described=parameters("described.yaml"),
        of_topics=OF_TOPICS,
    output:
        **tables(JUDGED),
    log:
        **traces("judge_study"),
    params:
        code=code("judge_study"),
        study=lambda wildcards: STUDY_TEXT,
    run:
        run_step(rule, input, output, params, log)


rule draw_calibration:
    input:
        errors=rules.make_tables.output.force_mae,
    output:
        **drawn("", "calibration"),
    log:
        **traces("draw_calibration"),
    params:
        code=code("draw_calibration"),
    run:
        run_step(rule, input, output, params, log)


BENCHMARKS = outputs_in("benchmarks", "log")


rule time_steps:
    input:
        benchmarks=lambda wildcards: BENCHMARKS,
    output:
        **tables(["run_times"]),
    log:
        **traces("time_steps"),
    params:
        code=code("time_steps"),
    run:
        run_step(rule, input, output, params, log)


rule write_report:
    input:
        described=parameters("described.yaml"),
        tables=outputs_in("tables"),
        figures=outputs_in("figures"),
    output:
        # `update` keeps the last results, which are read first, if the page has an error
        html=update(f"{RESULTS}/report.html"),
        details=update(f"{RESULTS}/details.html"),
        pdf=update(f"{RESULTS}/report.pdf"),
        study=update(f"{RESULTS}/configuration.yaml"),
        results=update(f"{RESULTS}/results.json"),
        schema=update(f"{RESULTS}/results.schema.json"),
        archive=update(f"{RESULTS}/tables.zip"),
    log:
        **traces("write_report"),
    params:
        code=code("write_report", *PAGE),
        last=lambda wildcards, output: output.results,
        study=lambda wildcards: STUDY_TEXT,
    run:
        run_step(rule, input, output, params, log)


# A recording's own page, on demand: `snakemake results/<study>/runs/<recording>.html`.
rule write_run:
    input:
        described=parameter_of("described.yaml"),
        tables=[*rules.make_tables.output, *rules.judge_study.output],
        figures=lambda wildcards: expand(rules.draw_figures.output, recording=wildcards.recording),
    output:
        html=f"{RESULTS}/runs/{{recording}}.html",
    log:
        **traces("write_run", "{recording}"),
    params:
        code=code("write_run", *PAGE),
        study=lambda wildcards: STUDY_TEXT,
        recording="{recording}",
    run:
        run_step(rule, input, output, params, log)


rule describe_run:
    input:
        report=rules.write_report.output[:5],
        raw=lambda wildcards: [
            path for name in SELECTION.entries for path in SELECTION.raw_files(name)
        ],
        extensions=[str(path) for path in source_files({own.file() for own in KINDS.values()})],
        files=rules.make_tables.output.files,
        tables=rules.write_report.input.tables,
        figures=rules.write_report.input.figures,
    output:
        crate=f"{RESULTS}/ro-crate-metadata.json",
        workflow=f"{RESULTS}/Snakefile",
    log:
        **traces("describe_run"),
    params:
        code=code("describe_run", SNAKEFILE, CITATION),
        title=lambda wildcards: STUDY.title,
    run:
        run_step(rule, input, output, params, log)
