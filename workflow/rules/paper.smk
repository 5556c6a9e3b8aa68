# What a paper takes over from a study, made by `snakemake paper` alone: the report's figures, drawn
# by the same scripts as PDF of the width of a column; its tables; methods and references.
PAPER = f"{RESULTS}/paper"


use rule draw_figures as draw_figures_for_paper with:
    output:
        **columns(f"{PAPER}/figures/{{recording}}", FIGURES),
    log:
        **traces("draw_figures_for_paper", "{recording}"),


use rule draw_tracking as draw_tracking_for_paper with:
    output:
        **columns(f"{PAPER}/figures/{{recording}}", TRACKING_FIGURES),
    log:
        **traces("draw_tracking_for_paper", "{recording}"),


use rule draw_filtered_first as draw_filtered_first_for_paper with:
    output:
        **columns(f"{PAPER}/figures/{{recording}}", ["accelerations_filtered_first"]),
    log:
        **traces("draw_filtered_first_for_paper", "{recording}"),


use rule draw_older_model as draw_older_model_for_paper with:
    output:
        **columns(f"{PAPER}/figures/{{recording}}", OLDER_FIGURES),
    log:
        **traces("draw_older_model_for_paper", "{recording}"),


use rule draw_published_forces as draw_published_forces_for_paper with:
    output:
        **columns(f"{PAPER}/figures/{{recording}}", PUBLISHED_FIGURES),
    log:
        **traces("draw_published_forces_for_paper", "{recording}"),


use rule draw_current_torque as draw_current_torque_for_paper with:
    output:
        **columns(f"{PAPER}/figures/{{recording}}", CURRENT_FIGURES),
    log:
        **traces("draw_current_torque_for_paper", "{recording}"),


use rule draw_friction as draw_friction_for_paper with:
    output:
        **columns(f"{PAPER}/figures/{{robot}}", FRICTION_FIGURES),
    log:
        **traces("draw_friction_for_paper", "{robot}"),


use rule draw_health as draw_health_for_paper with:
    output:
        **columns(f"{PAPER}/figures/{{robot}}", ["health"]),
    log:
        **traces("draw_health_for_paper", "{robot}"),


use rule draw_observability as draw_observability_for_paper with:
    output:
        **columns(f"{PAPER}/figures/{{robot}}", ["observability"]),
    log:
        **traces("draw_observability_for_paper", "{robot}"),


use rule draw_models as draw_models_for_paper with:
    output:
        **columns(f"{PAPER}/figures/{{robot}}", MODEL_FIGURES),
    log:
        **traces("draw_models_for_paper", "{robot}"),


use rule draw_filters as draw_filters_for_paper with:
    output:
        **columns(f"{PAPER}/figures", ["filters"]),
    log:
        **traces("draw_filters_for_paper"),


use rule draw_calibration as draw_calibration_for_paper with:
    output:
        **columns(f"{PAPER}/figures", ["calibration"]),
    log:
        **traces("draw_calibration_for_paper"),


rule write_paper:
    input:
        **REFERENCE,
        tables=outputs_in("tables"),
        figures=outputs_in("figures"),
        columns=[
            path.replace(f"{RESULTS}/figures", f"{PAPER}/figures").replace(".svg", ".pdf")
            for path in outputs_in("figures")
            if path.endswith(".svg")
        ],
        contents=["ur5lib/report/contents.yaml", "ur5lib/report/sentences.yaml"],
        templates=[
            "ur5lib/report/templates/paper.tex.jinja",
            "ur5lib/report/templates/methods.tex.jinja",
            "ur5lib/report/templates/references.bib",
        ],
    output:
        document=f"{PAPER}/paper.tex",
        methods=f"{PAPER}/methods.tex",
        references=f"{PAPER}/references.bib",
        tables=directory(f"{PAPER}/tables"),
    log:
        **traces("write_paper"),
    params:
        code=code("write_paper"),
        study=study_text(STUDY),
    run:
        run_step(rule, input, output, params, log)
