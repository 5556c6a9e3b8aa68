# The audit of the force sensor in an arm's wrist; of many recordings, only the selected ones.
RUNS_FOR["audit_sensor"] = [name for name in RECORDINGS if name in SELECTION.examined]


rule audit_sensor:
    input:
        quality=result("quality.json"),
        signals=result("signals.parquet"),
        kinematics=result("kinematics.parquet"),
        motion=result("motion.parquet"),
        premises=result("premises.json"),
        prediction=result("currents.json"),
        arm=parameter_of("arm.yaml"),
    output:
        audit=result("audit.csv"),
    log:
        **traces("audit_sensor", "{recording}"),
    params:
        code=code("audit_sensor"),
        gravity=of_recording(SELECTION.gravity),
    run:
        run_step(rule, input, output, params, log)
