# The report's figures for a paper, made by `snakemake paper` alone: drawn by the same steps as PDF
# of the width of a column.
def as_wide_as_a_column(figure):
    """Return the path of a figure for a paper, as wide as its columns, by that of the report's."""
    return figure.replace(f"{RESULTS}/figures", f"{RESULTS}/paper/figures").replace(".svg", ".pdf")


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
        params:
            **dict(drawing.params.items()),
        run:
            run_step(rule, input, output, params, log)
