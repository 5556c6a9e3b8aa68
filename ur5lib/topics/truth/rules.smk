# Estimates compared with the truth, for simulated recordings.
if TRUTHS:

    rule compare_with_truth:
        input:
            truth=[f"{truth}.parquet" for truth in TRUTHS.values()],
            truth_summary=[f"{truth}.json" for truth in TRUTHS.values()],
            alignment=results("alignment.json", TRUTHS),
            motion=results("motion.parquet", TRUTHS),
            fused=results("fused_motion.parquet", TRUTHS),
            accelerations=results("accelerations.parquet", TRUTHS),
            forces=results("forces.parquet", TRUTHS),
            described=parameters("described.yaml"),
            identified=parameters("arm.yaml"),
            rotors=parameters("rotor_inertia.json"),
            identification=parameters("identification.json"),
            calibration=parameters("imu.json"),
            friction=parameters("friction.json"),
        output:
            truth=f"{RESULTS}/tables/truth.csv",
        log:
            **traces("compare_with_truth"),
        params:
            code=code("compare_with_truth"),
            simulated=[*TRUTHS],
            lowpass=design(SETTINGS.lowpass.accelerations),
        run:
            run_step(rule, input, output, params, log)
