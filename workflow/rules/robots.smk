rule describe_arm:
    input:
        description=lambda wildcards: str(robot_path(ARMS[wildcards.robot].arm)),
        sizes="ur5lib/robots/joint_sizes.yaml",
        calibration=lambda wildcards: ARMS[wildcards.robot].calibration or [],
        code=code("describe_arm"),
    output:
        arm=parameter("described.yaml"),
    log:
        f"{RESULTS}/logs/describe_arm/{{robot}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/describe_arm/{{robot}}.tsv"
    params:
        robot="{robot}",
        override=lambda wildcards: json.dumps(ARMS[wildcards.robot].override or {}),
    script:
        "../scripts/describe_arm.py"
