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


if SIMULATED:

    rule compare_with_truth:
        input:
            truth=[f"{RESULTS}/truth/{name}.parquet" for name in SIMULATED],
            truth_summary=[f"{RESULTS}/truth/{name}.json" for name in SIMULATED],
            clocks=results("clocks.json", SIMULATED),
            motion=results("motion.parquet", SIMULATED),
            fused=results("fused_motion.parquet", SIMULATED),
            accelerations=results("accelerations.parquet", SIMULATED),
            forces=results("forces.parquet", SIMULATED),
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
        params:
            **SETTINGS.lowpass.accelerations.model_dump(),
            code=code("compare_with_truth"),
            recordings=SIMULATED,
            robots=ROBOTS,
        run:
            run_step(rule, input, output, params, log)
