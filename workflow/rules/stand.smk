# One rule for each simulated recording: which files it has depends on what is simulated.
for recording in SIMULATED:

    rule:
        name:
            f"simulate_recording_{recording}"
        input:
            **way_points(recording),
            arm=described(RECORDINGS[recording].arm.known_as),
        output:
            raw=raw_files(recording),
            truth=f"{RESULTS}/truth/{recording}.parquet",
            summary=f"{RESULTS}/truth/{recording}.json",
        log:
            **traces("simulate_recording", recording),
        params:
            code=code("simulate_recording"),
            format=RECORDINGS[recording].format,
            gravity=gravities([recording])[0],
            plan=RECORDINGS[recording].plan().model_dump_json(),
        run:
            run_step("simulate_recording", input, output, params, log)


if TRUTHS:

    rule compare_with_truth:
        input:
            truth=[f"{truth}.parquet" for truth in TRUTHS.values()],
            truth_summary=[f"{truth}.json" for truth in TRUTHS.values()],
            clocks=results("clocks.json", TRUTHS),
            motion=results("motion.parquet", TRUTHS),
            fused=results("fused_motion.parquet", TRUTHS),
            accelerations=results("accelerations.parquet", TRUTHS),
            forces=results("forces.parquet", TRUTHS),
            described=[described(robot) for robot in ROBOTS],
            fitted=parameters("arm.yaml"),
            rotors=parameters("rotor_inertia.json"),
            identification=parameters("identification.json"),
            calibration=parameters("imu.json"),
            friction=parameters("friction.json"),
        output:
            truth=f"{RESULTS}/tables/truth.csv",
        log:
            **traces("compare_with_truth"),
        group:
            in_cluster("document")
        params:
            **SETTINGS.lowpass.accelerations.model_dump(),
            code=code("compare_with_truth"),
            recordings=[*TRUTHS],
            robots=ROBOTS,
        run:
            run_step(rule, input, output, params, log)
