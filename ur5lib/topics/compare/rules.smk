# A study's results compared with those of the studies in its `compare_with`.
COMPARED = [
    "quality",
    "parameters",
    "rotor_inertia",
    "friction",
    "payload",
    "current_rmse",
    "force_mae",
]


rule compare_studies:
    input:
        own=tables_of([STUDY.study], COMPARED if STUDY.compare_with else []),
        others=tables_of(STUDY.compare_with, COMPARED),
    output:
        **tables(["changes"]),
    log:
        **traces("compare_studies"),
    params:
        code=code("compare_studies"),
    run:
        run_step(rule, input, output, params, log)
