rule rebuild_forces:
    input:
        signals=result("signals.parquet"),
        motion=result("motion.parquet"),
        torques=result("torques.parquet"),
        kinematics=result("kinematics.parquet"),
        quality=result("quality.json"),
        arm=arm_file,
        code=code("rebuild_forces"),
    output:
        forces=result("published_forces.parquet"),
    log:
        f"{RESULTS}/logs/rebuild_forces/{{recording}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/rebuild_forces/{{recording}}.tsv"
    params:
        **SETTINGS.lowpass.published_forces.model_dump(),
        min_singular_value=SETTINGS.singularities.min_singular_value,
    script:
        "../scripts/rebuild_forces.py"


rule fit_residuals:
    input:
        currents=fitted_results("currents.parquet"),
        motion=fitted_results("motion.parquet"),
        friction=parameter("friction.json"),
        code=code("fit_residuals"),
    output:
        residuals=parameter("residuals.json"),
    log:
        f"{RESULTS}/logs/fit_residuals/{{robot}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/fit_residuals/{{robot}}.tsv"
    params:
        cutoff_hz=SETTINGS.lowpass.currents.cutoff_hz,
    script:
        "../scripts/fit_residuals.py"


rule estimate_forces:
    input:
        motion=result("motion.parquet"),
        currents=result("currents.parquet"),
        kinematics=result("kinematics.parquet"),
        residuals=parameter_of("residuals.json"),
        free_currents=contact_free_results("currents.parquet"),
        free_motion=contact_free_results("motion.parquet"),
        load=result("currents.json"),
        free_loads=contact_free_results("currents.json"),
        code=code("estimate_forces"),
    output:
        forces=result("forces.parquet"),
    log:
        f"{RESULTS}/logs/estimate_forces/{{recording}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/estimate_forces/{{recording}}.tsv"
    params:
        cutoff_hz=SETTINGS.lowpass.currents.cutoff_hz,
        contact_force_n=SETTINGS.contact.force_n,
    script:
        "../scripts/estimate_forces.py"


rule compare_forces:
    input:
        signals=result("signals.parquet"),
        force=result("force.parquet"),
        quality=result("quality.json"),
        kinematics=result("kinematics.parquet"),
        published=result("published_forces.parquet"),
        forces=result("forces.parquet"),
        arm=arm_file,
        code=code("compare_forces"),
    output:
        sensor=result("sensor.parquet"),
        summary=result("forces.json"),
    log:
        f"{RESULTS}/logs/compare_forces/{{recording}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/compare_forces/{{recording}}.tsv"
    params:
        gravity=gravity_of,
        bias_window_s=SETTINGS.sensor.bias_window_s,
        min_singular_value=SETTINGS.singularities.min_singular_value,
    script:
        "../scripts/compare_forces.py"


rule set_threshold:
    input:
        forces=fitted_results("forces.parquet"),
        code=code("set_threshold"),
    output:
        threshold=parameter("threshold.json"),
    log:
        f"{RESULTS}/logs/set_threshold/{{robot}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/set_threshold/{{robot}}.tsv"
    params:
        false_alarms_per_min=SETTINGS.alarms.false_per_min,
    script:
        "../scripts/set_threshold.py"


rule detect_contacts:
    input:
        forces=result("forces.parquet"),
        sensor=result("sensor.parquet"),
        motion=result("motion.parquet"),
        currents=result("currents.parquet"),
        kinematics=result("kinematics.parquet"),
        regressor=result("load_regressor.parquet"),
        residuals=parameter_of("residuals.json"),
        threshold=parameter_of("threshold.json"),
        code=code("detect_contacts"),
    output:
        detection=result("detection.json"),
    log:
        f"{RESULTS}/logs/detect_contacts/{{recording}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/detect_contacts/{{recording}}.tsv"
    params:
        role=lambda wildcards: recording_of(wildcards).role,
        contact_force_n=SETTINGS.contact.force_n,
    script:
        "../scripts/detect_contacts.py"


rule ablate_forces:
    input:
        sensor=result("sensor.parquet"),
        forces=result("forces.parquet"),
        motion=result("motion.parquet"),
        currents=result("currents.parquet"),
        kinematics=result("kinematics.parquet"),
        residuals=parameter_of("residuals.json"),
        code=code("ablate_forces"),
    output:
        ablation=result("ablation.json"),
    log:
        f"{RESULTS}/logs/ablate_forces/{{recording}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/ablate_forces/{{recording}}.tsv"
    params:
        contact_force_n=SETTINGS.contact.force_n,
    script:
        "../scripts/ablate_forces.py"
