# The force that the live estimator would have stated, and the contacts that it finds.


rule fit_live:
    input:
        signals=results_of(fitted_on, "signals.parquet"),
        premises=results_of(fitted_on, "premises.json"),
        friction=parameter("friction.json"),
        residuals=parameter("residuals.json"),
        arm=parameter("arm.yaml"),
    output:
        live=parameter("live.json"),
    log:
        **traces("fit_live", "{robot}"),
    params:
        code=code("fit_live"),
        gravities=gravities_of(fitted_on),
        false_alarms_per_min=SETTINGS.alarms.false_per_min,
        contact_force_n=SETTINGS.contact.force_n,
    run:
        run_step(rule, input, output, params, log)


rule estimate_live:
    input:
        signals=result("signals.parquet"),
        premises=result("premises.json"),
        prediction=result("currents.json"),
        friction=parameter_of("friction.json"),
        live=parameter_of("live.json"),
        arm=parameter_of("arm.yaml"),
    output:
        forces=result("live_forces.parquet"),
    log:
        **traces("estimate_live", "{recording}"),
    params:
        code=code("estimate_live"),
        name="{recording}",
        gravity=of_recording(SELECTION.gravity),
        contact_force_n=SETTINGS.contact.force_n,
    run:
        run_step(rule, input, output, params, log)


rule measure_live_pushes:
    input:
        signals=results_of(SELECTION.drawn, "signals.parquet"),
        motion=results_of(SELECTION.drawn, "motion.parquet"),
        currents=results_of(SELECTION.drawn, "currents.parquet"),
        kinematics=results_of(SELECTION.drawn, "kinematics.parquet"),
        prediction=results_of(SELECTION.drawn, "currents.json"),
        premises=results_of(SELECTION.drawn, "premises.json"),
        friction=parameter("friction.json"),
        residuals=parameter("residuals.json"),
        live=parameter("live.json"),
        arm=parameter("arm.yaml"),
    output:
        pushes=parameter("live_pushes.csv"),
    log:
        **traces("measure_live_pushes", "{robot}"),
    params:
        code=code("measure_live_pushes"),
        gravities=gravities_of(SELECTION.drawn),
        contact_force_n=SETTINGS.contact.force_n,
        trial_pushes=SETTINGS.pushes.per_arm,
    run:
        run_step(rule, input, output, params, log)


rule count_live_contacts:
    input:
        live=result("live_forces.parquet"),
        sensor=result("sensor.parquet"),
        contacts=result("contacts.json"),
    output:
        detection=result("live_detection.csv"),
    log:
        **traces("count_live_contacts", "{recording}"),
    params:
        code=code("count_live_contacts"),
    run:
        run_step(rule, input, output, params, log)


rule judge_live:
    input:
        detection=results_of(recordings_of, "live_detection.csv"),
        quality=results_of(recordings_of, "quality.json"),
        prediction=results_of(recordings_of, "currents.json"),
        compared=results_of(recordings_of, "beside_sensor.json"),
    output:
        verdicts=parameter("live.verdicts.csv"),
        false_alarms=parameter("live_false_alarms.csv"),
    log:
        **traces("judge_live", "{robot}"),
    params:
        code=code("judge_live"),
        roles=lambda wildcards: {
            name: RECORDINGS[name].role for name in recordings_of(wildcards.robot)
        },
        dates=lambda wildcards: {
            name: SELECTION.date(name) for name in recordings_of(wildcards.robot)
        },
    run:
        run_step(rule, input, output, params, log)
