# It takes less than a second: on a cluster it is no job, but runs where Snakemake was started.
localrules:
    describe_arm,


rule describe_arm:
    input:
        description=lambda wildcards: own(robot_path(ARMS[wildcards.robot].arm)),
        calibration=lambda wildcards: ARMS[wildcards.robot].calibration or [],
    output:
        arm=parameter("described.yaml"),
    log:
        **traces("describe_arm", "{robot}"),
    params:
        code=lambda wildcards: code(
            "describe_arm", JOINT_SIZES_FILE, *shipped(robot_path(ARMS[wildcards.robot].arm))
        ),
        arm=lambda wildcards: ARMS[wildcards.robot].arm,
        robot="{robot}",
        override=lambda wildcards: json.dumps(ARMS[wildcards.robot].override or {}),
    run:
        run_step(rule, input, output, params, log)
