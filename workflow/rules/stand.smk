# One rule for each simulated recording: which files it has depends on what is simulated.
for recording in SIMULATED:

    rule:
        name:
            f"simulate_recording_{recording}"
        input:
            **way_points(recording),
            arm=described(RECORDINGS[recording].arm.known_as),
            code=code("simulate_recording"),
        output:
            raw=raw_files(recording),
            truth=f"{RESULTS}/truth/{recording}.parquet",
            summary=f"{RESULTS}/truth/{recording}.json",
        log:
            f"{RESULTS}/logs/simulate_recording/{recording}.log",
        benchmark:
            f"{RESULTS}/benchmarks/simulate_recording/{recording}.tsv"
        params:
            format=RECORDINGS[recording].format,
            gravity=gravities([recording])[0],
            plan=RECORDINGS[recording].plan().model_dump_json(),
        script:
            "../scripts/simulate_recording.py"


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
            code=code("compare_with_truth"),
        output:
            truth=f"{RESULTS}/tables/truth.csv",
        log:
            f"{RESULTS}/logs/compare_with_truth.log",
        benchmark:
            f"{RESULTS}/benchmarks/compare_with_truth.tsv"
        params:
            **SETTINGS.lowpass.accelerations.model_dump(),
            recordings=SIMULATED,
            robots=ROBOTS,
        script:
            "../scripts/compare_with_truth.py"
