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
