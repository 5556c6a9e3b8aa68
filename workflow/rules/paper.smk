# One figure as a paper needs it, made by `ur5 figure` alone: drawn by the same step as the report's.
# Its file's name states width and size of letters, by which it is laid out.
STEP_OF_PAPER = {}  # rule: the step that draws its figure


def for_paper(figure):
    """Return the path of a figure for a paper, by that of the report's."""
    path = figure.replace(f"{RESULTS}/figures", f"{RESULTS}/paper").removesuffix(".svg")
    return path + r"_{width,[\d.]+}mm_{size,[\d.]+}pt.{format,\w+}"


for drawing in [step for step in workflow.rules if step.name.startswith("draw_")]:
    for figure, path in drawing.output.items():
        if path.endswith(".svg"):
            STEP_OF_PAPER[f"paper_{figure}"] = drawing.name
            names = [*drawing.wildcard_names, "width", "size", "format"]
            job = "_".join(map("{{{}}}".format, names))

            rule:
                name:
                    f"paper_{figure}"
                input:
                    **dict(drawing.input.items()),
                output:
                    **{figure: for_paper(path)},
                log:
                    **traces(f"paper_{figure}", job),
                params:
                    **dict(drawing.params.items()),
                run:
                    run_step(STEP_OF_PAPER[rule], input, output, params, log)
