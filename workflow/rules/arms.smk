# The fits to an arm, from its recordings.


# These take less than a second: on a cluster, they run where Snakemake was started, not as jobs.
localrules:
    describe_arm,
    pool_drifts,
    set_threshold,


rule describe_arm:
    input:
        description=lambda wildcards: of_study([robot_path(ARMS[wildcards.robot].arm)]),
        calibration=lambda wildcards: ARMS[wildcards.robot].calibration or [],
    output:
        arm=parameter("described.yaml"),
    log:
        **traces("describe_arm", "{robot}"),
    params:
        **from_study("describe_arm"),
        code=lambda wildcards: code(
            "describe_arm", JOINT_SIZES_FILE, *in_library([robot_path(ARMS[wildcards.robot].arm)])
        ),
    run:
        run_step(rule, input, output, params, log)


rule pool_drifts:
    input:
        clocks=results_of(contact_free, "own_clocks.json"),
    output:
        drifts=parameter("drifts.json"),
    log:
        **traces("pool_drifts", "{robot}"),
    params:
        **from_study("pool_drifts"),
        code=code("pool_drifts"),
    run:
        run_step(rule, input, output, params, log)


rule calibrate_imu:
    input:
        signals=results_of(fitted_on, "signals.parquet"),
        kinematics=results_of(fitted_on, "kinematics.parquet"),
        alignment=results_of(fitted_on, "alignment.json"),
        arm=parameter("described.yaml"),
    output:
        calibration=parameter("imu.json"),
    log:
        **traces("calibrate_imu", "{robot}"),
    params:
        code=code("calibrate_imu"),
        gravities=gravities_of(fitted_on),
        lowpass=design(SETTINGS.lowpass.accelerations),
    run:
        run_step(rule, input, output, params, log)


# The same step on recordings that the calibration above has not used: it judges, and corrects
# nothing. Of many recordings, it uses those that are drawn: the others would wait for each new one.
rule calibrate_imu_without_each:
    input:
        signals=results_of(SELECTION.drawn, "signals.parquet"),
        kinematics=results_of(SELECTION.drawn, "kinematics.parquet"),
        alignment=results_of(SELECTION.drawn, "alignment.json"),
        arm=parameter("described.yaml"),
    output:
        calibration=parameter("imu_without_each.json"),
    log:
        **traces("calibrate_imu_without_each", "{robot}"),
    params:
        code=code("calibrate_imu"),
        gravities=gravities_of(SELECTION.drawn),
        lowpass=design(SETTINGS.lowpass.accelerations),
    run:
        run_step("calibrate_imu", input, output, params, log)


rule identify_model:
    input:
        signals=results_of(fitted_on, "signals.parquet"),
        motion=results_of(fitted_on, "motion.parquet"),
        arm=parameter("described.yaml"),
    output:
        arm=parameter("arm.yaml"),
        urdf=parameter("arm.urdf"),
        rotors=parameter("rotor_inertia.json"),
        summary=parameter("identification.json"),
    log:
        **traces("identify_model", "{robot}"),
    params:
        **from_study("identify_model"),
        code=code("identify_model"),
    run:
        run_step(rule, input, output, params, log)


rule fit_friction:
    input:
        signals=results_of(fitted_on, "signals.parquet"),
        motion=results_of(fitted_on, "motion.parquet"),
        before=results_of(before_fitted, "motion.parquet"),
        torques=results_of(fitted_on, "torques.parquet"),
        premises=results_of(fitted_on, "premises.json"),
        quality=results_of(fitted_on, "quality.json"),
        postures=lambda wildcards: postures(
            "postures.json", SELECTION.of_arm(wildcards.robot, "fit", at_rest=True)
        ),
        arm=parameter("arm.yaml"),
    output:
        friction=parameter("friction.json"),
    log:
        **traces("fit_friction", "{robot}"),
    params:
        **from_study("fit_friction"),
        code=code("fit_friction"),
    run:
        run_step(rule, input, output, params, log)


rule fit_residuals:
    input:
        currents=results_of(fitted_on, "currents.parquet"),
        motion=results_of(fitted_on, "motion.parquet"),
        friction=parameter("friction.json"),
    output:
        residuals=parameter("residuals.json"),
    log:
        **traces("fit_residuals", "{robot}"),
    params:
        **from_study("fit_residuals"),
        code=code("fit_residuals"),
    run:
        run_step(rule, input, output, params, log)


rule set_threshold:
    input:
        further=further_forces,
        forces=results_of(fitted_on, "forces.parquet"),
        signals=results_of(fitted_on, "signals.parquet"),
        arm=parameter("described.yaml"),
    output:
        threshold=parameter("threshold.json"),
    log:
        **traces("set_threshold", "{robot}"),
    params:
        **from_study("set_threshold"),
        code=code("set_threshold"),
    run:
        run_step(rule, input, output, params, log)


rule measure_repetition:
    input:
        signals=results_of(SELECTION.drawn, "signals.parquet"),
        motion=results_of(SELECTION.drawn, "motion.parquet"),
        torques=results_of(SELECTION.drawn, "torques.parquet"),
        currents=results_of(SELECTION.drawn, "currents.parquet"),
        kinematics=results_of(SELECTION.drawn, "kinematics.parquet"),
        prediction=results_of(SELECTION.drawn, "currents.json"),
        quality=results_of(SELECTION.drawn, "quality.json"),
        friction=parameter("friction.json"),
        residuals=parameter("residuals.json"),
        arm=parameter("arm.yaml"),
    output:
        repetition=parameter("repetition.csv"),
    log:
        **traces("measure_repetition", "{robot}"),
    params:
        code=code("measure_repetition"),
        contact_force_n=SETTINGS.contact.force_n,
    run:
        run_step(rule, input, output, params, log)


rule measure_pushes:
    input:
        motion=results_of(SELECTION.drawn, "motion.parquet"),
        currents=results_of(SELECTION.drawn, "currents.parquet"),
        prediction=results_of(SELECTION.drawn, "currents.json"),
        premises=results_of(SELECTION.drawn, "premises.json"),
        kinematics=results_of(SELECTION.drawn, "kinematics.parquet"),
        forces=results_of(SELECTION.drawn, "forces.parquet"),
        friction=parameter("friction.json"),
        residuals=parameter("residuals.json"),
        threshold=parameter("threshold.json"),
        arm=parameter("described.yaml"),
    output:
        pushes=parameter("pushes.csv"),
        directions=parameter("push_directions.csv"),
        curve=parameter("push_curve.csv"),
    log:
        **traces("measure_pushes", "{robot}"),
    params:
        code=code("measure_pushes"),
        contact_force_n=SETTINGS.contact.force_n,
        trial_pushes=SETTINGS.pushes.per_arm,
    run:
        run_step(rule, input, output, params, log)
