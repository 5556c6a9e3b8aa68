# What a paper takes over from a study, made by `snakemake paper` alone: the report's figures, drawn
# by the same scripts as PDF of the width of a column; its tables; methods and references.
PAPER = f"{RESULTS}/paper"


for drawing in [step for step in workflow.rules if step.name.startswith("draw_")]:

    rule:
        name:
            f"{drawing.name}_for_paper"
        input:
            **dict(drawing.input.items()),
        output:
            **as_wide_as_a_column(drawing.output),
        log:
            **traces(f"{drawing.name}_for_paper", *map("{{{}}}".format, drawing.wildcard_names)),
        group:
            drawing.ruleinfo.group
        params:
            **dict(drawing.params.items()),
        run:
            run_step(rule, input, output, params, log)


rule write_paper:
    input:
        **REFERENCE,
        described=[described(robot) for robot in ROBOTS],
        tables=outputs_in("tables"),
        figures=outputs_in("figures"),
        columns=[
            path.replace(f"{RESULTS}/figures", f"{PAPER}/figures").replace(".svg", ".pdf")
            for path in outputs_in("figures")
            if path.endswith(".svg")
        ],
    output:
        document=f"{PAPER}/paper.tex",
        methods=f"{PAPER}/methods.tex",
        references=f"{PAPER}/references.bib",
        tables=directory(f"{PAPER}/tables"),
    log:
        **traces("write_paper"),
    group:
        in_cluster("document")
    params:
        code=code(
            "write_paper",
            *CONTENTS,
            TEMPLATES / "paper.tex.jinja",
            TEMPLATES / "methods.tex.jinja",
            TEMPLATES / "references.bib",
        ),
        study=lambda wildcards: STUDY_TEXT,
    run:
        run_step(rule, input, output, params, log)
