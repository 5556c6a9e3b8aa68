# One rule for each simulated recording: which files it has depends on what is simulated.
for recording in SELECTION.simulated:

    rule:
        name:
            f"simulate_recording_{recording}"
        input:
            **way_points(recording),
            arm=f"{RESULTS}/parameters/{SELECTION.arm(recording)}/described.yaml",
        output:
            raw=SELECTION.raw_files(recording),
            truth=f"{RESULTS}/truth/{recording}.parquet",
            summary=f"{RESULTS}/truth/{recording}.json",
        log:
            **traces("simulate_recording", recording),
        params:
            code=code("simulate_recording"),
            format=RECORDINGS[recording].format,
            folder=RECORDINGS[recording].folder,
            truth=f"{RESULTS}/truth/{recording}",
            gravity=SELECTION.gravity(recording),
            plan=RECORDINGS[recording].plan().model_dump(mode="json"),
        run:
            run_step("simulate_recording", input, output, params, log)


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
            fitted=parameters("arm.yaml"),
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
            recordings=[*TRUTHS],
            lowpass=design(SETTINGS.lowpass.accelerations),
        run:
            run_step(rule, input, output, params, log)
