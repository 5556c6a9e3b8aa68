# The report's figures for a paper, made by `snakemake paper` alone: drawn by the same scripts as PDF
# of the width of a column.
for drawing in [step for step in workflow.rules if step.name.startswith("draw_")]:

    rule:
        name:
            f"{drawing.name}_for_paper"
        input:
            **dict(drawing.input.items()),
        output:
            **{
                name: as_wide_as_a_column(figure)
                for name, figure in drawing.output.items()
                if figure.endswith(".svg")
            },
        log:
            **traces(f"{drawing.name}_for_paper", *map("{{{}}}".format, drawing.wildcard_names)),
        group:
            drawing.ruleinfo.group
        params:
            **dict(drawing.params.items()),
        run:
            run_step(rule, input, output, params, log)
