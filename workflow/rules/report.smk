FIGURES = [
    "positions",
    "velocities",
    "torques",
    "accelerations",
    "accelerations_published",
    "currents",
    "forces_estimated",
    "forces_printed",
    "forces_friction_printed",
    "forces_corrected",
    "forces_friction_corrected",
]
FRICTION_FIGURES = ["current_torque", "current_torque_friction", "friction", "residuals"]
TABLES = sorted(path.stem for path in Path("ur5lib/report/tables").glob("[!_]*.py"))


rule draw_figures:
    input:
        signals=result("signals.parquet"),
        torques=result("torques.parquet"),
        closed_loop=result("closed_loop.parquet"),
        accelerations=result("accelerations.parquet"),
        currents=result("currents.parquet"),
        kinematics=result("kinematics.parquet"),
        published=result("published_forces.parquet"),
        sensor=result("sensor.parquet"),
        forces=result("forces.parquet"),
        arm=parameter_of("arm.yaml"),
        code=code("draw_figures"),
    output:
        **drawings(f"{RESULTS}/figures/{{recording}}", FIGURES),
    log:
        f"{RESULTS}/logs/draw_figures/{{recording}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/draw_figures/{{recording}}.tsv"
    params:
        min_singular_value=SETTINGS.singularities.min_singular_value,
    script:
        "../scripts/draw_figures.py"


rule make_tables:
    input:
        **REFERENCE,
        quality=results("quality.json"),
        clocks=results("clocks.json"),
        signals=results("signals.parquet"),
        torques=results("torques.parquet"),
        closed_loop=results("closed_loop.parquet"),
        gains=results("gains.json"),
        accelerations=results("accelerations.json"),
        motion=results("motion.json"),
        fused=results("fused_motion.json"),
        forces=results("forces.json"),
        rotors=parameters("rotor_inertia.json"),
        identification=parameters("identification.json"),
        calibration=parameters("imu.json"),
        friction=parameters("friction.json"),
        residuals=parameters("residuals.json"),
        arm=parameters("arm.yaml"),
        currents=results("currents.json"),
        detection=results("detection.json"),
        ablation=results("ablation.json", TOUCHED),
        modules=[f"ur5lib/report/tables/{name}.py" for name in TABLES],
        code=code("make_tables"),
    output:
        **tables(TABLES),
    log:
        f"{RESULTS}/logs/make_tables.log",
    benchmark:
        f"{RESULTS}/benchmarks/make_tables.tsv"
    script:
        "../scripts/make_tables.py"


rule draw_friction:
    input:
        signals=fitted_results("signals.parquet"),
        motion=fitted_results("motion.parquet"),
        torques=fitted_results("torques.parquet"),
        friction=parameter("friction.json"),
        arm=parameter("arm.yaml"),
        code=code("draw_friction"),
    output:
        **drawings(f"{RESULTS}/figures/{{robot}}", FRICTION_FIGURES),
    log:
        f"{RESULTS}/logs/draw_friction/{{robot}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/draw_friction/{{robot}}.tsv"
    params:
        **SETTINGS.lowpass.currents.model_dump(),
        recordings=fitted_on,
    script:
        "../scripts/draw_friction.py"


rule draw_filters:
    input:
        code=code("draw_filters"),
    output:
        **drawings(f"{RESULTS}/figures", ["filters"]),
    log:
        f"{RESULTS}/logs/draw_filters.log",
    benchmark:
        f"{RESULTS}/benchmarks/draw_filters.tsv"
    params:
        lowpass=SETTINGS.lowpass.model_dump(),
    script:
        "../scripts/draw_filters.py"


rule draw_models:
    input:
        arm=parameter("arm.yaml"),
        code=code("draw_models"),
    output:
        **drawings(f"{RESULTS}/figures/{{robot}}", ["models"]),
    log:
        f"{RESULTS}/logs/draw_models/{{robot}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/draw_models/{{robot}}.tsv"
    script:
        "../scripts/draw_models.py"


rule draw_calibration:
    input:
        errors=rules.make_tables.output.force_mae,
        code=code("draw_calibration"),
    output:
        **drawings(f"{RESULTS}/figures", ["calibration"]),
    log:
        f"{RESULTS}/logs/draw_calibration.log",
    benchmark:
        f"{RESULTS}/benchmarks/draw_calibration.tsv"
    script:
        "../scripts/draw_calibration.py"


rule time_steps:
    input:
        benchmarks=of_every_job("benchmark"),
        logs=of_every_job("log"),
        code=code("time_steps"),
    output:
        **tables(["run_times"]),
    log:
        f"{RESULTS}/logs/time_steps.log",
    benchmark:
        f"{RESULTS}/benchmarks/time_steps.tsv"
    script:
        "../scripts/time_steps.py"


rule write_report:
    input:
        **REFERENCE,
        tables=outputs_in("tables"),
        figures=outputs_in("figures"),
        contents="ur5lib/report/contents.yaml",
        templates=[
            "ur5lib/report/templates/report.html.jinja",
            "ur5lib/report/templates/report.typ",
        ],
        code=code("write_report"),
    output:
        html=report(f"{RESULTS}/report.html", caption="../captions/report.rst", category="Report"),
        pdf=report(f"{RESULTS}/report.pdf", caption="../captions/report.rst", category="Report"),
        study=f"{RESULTS}/configuration.yaml",
    log:
        f"{RESULTS}/logs/write_report.log",
    benchmark:
        f"{RESULTS}/benchmarks/write_report.tsv"
    params:
        study=STUDY_YAML,
    script:
        "../scripts/write_report.py"
