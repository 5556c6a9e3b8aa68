FIGURES = [
    "torques",
    "torque_errors",
    *(
        f"{figure}_{kind}"
        for kind in ("printed", "corrected")
        for figure in ("forces", "forces_friction", "force_errors")
    ),
]
TABLES = ["quality", "clocks", "torque_mae", "force_mae"]


rule draw_figures:
    input:
        signals=result("signals.parquet"),
        torques=result("torques.parquet"),
        forces=result("forces.parquet"),
        arm=arm_file,
        code=code("draw_figures"),
    output:
        **{name: f"{RESULTS}/figures/{{recording}}/{name}.svg" for name in FIGURES},
    log:
        f"{RESULTS}/logs/draw_figures/{{recording}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/draw_figures/{{recording}}.tsv"
    script:
        "../scripts/draw_figures.py"


rule make_tables:
    input:
        **REFERENCE,
        quality=results("quality.json"),
        clocks=results("clocks.json"),
        signals=results("signals.parquet"),
        torques=results("torques.parquet"),
        forces=results("forces.json"),
        code=code("make_tables"),
    output:
        **{name: f"{RESULTS}/tables/{name}.csv" for name in TABLES},
    log:
        f"{RESULTS}/logs/make_tables.log",
    benchmark:
        f"{RESULTS}/benchmarks/make_tables.tsv"
    params:
        recordings=list(RECORDINGS),
    script:
        "../scripts/make_tables.py"


rule write_report:
    input:
        **REFERENCE,
        tables=rules.make_tables.output,
        quality=results("quality.json"),
        figures=expand(rules.draw_figures.output, recording=RECORDINGS),
        templates=[
            "ur5lib/report/templates/report.html.jinja",
            "ur5lib/report/templates/report.typ",
        ],
        code=code("write_report"),
    output:
        html=f"{RESULTS}/report.html",
        pdf=f"{RESULTS}/report.pdf",
    log:
        f"{RESULTS}/logs/write_report.log",
    benchmark:
        f"{RESULTS}/benchmarks/write_report.tsv"
    params:
        study=STUDY_YAML,
    script:
        "../scripts/write_report.py"
