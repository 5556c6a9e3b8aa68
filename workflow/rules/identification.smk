rule estimate_gains:
    input:
        signals=result("signals.parquet"),
        arm=arm_file,
        code=code("estimate_gains"),
    output:
        closed_loop=result("closed_loop.parquet"),
        gains=result("gains.json"),
    log:
        f"{RESULTS}/logs/estimate_gains/{{recording}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/estimate_gains/{{recording}}.tsv"
    params:
        gravity=gravity_of,
    script:
        "../scripts/estimate_gains.py"


rule fit_rotor_inertia:
    input:
        signals=fitted_results("signals.parquet"),
        motion=fitted_results("motion.parquet"),
        arm=arm_file,
        code=code("fit_rotor_inertia"),
    output:
        rotors=parameter("rotor_inertia.json"),
    log:
        f"{RESULTS}/logs/fit_rotor_inertia/{{robot}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/fit_rotor_inertia/{{robot}}.tsv"
    params:
        **SETTINGS.lowpass.motion.model_dump(),
        recordings=fitted_on,
        gravities=fitted_gravities,
    script:
        "../scripts/fit_rotor_inertia.py"


rule identify_model:
    input:
        signals=fitted_results("signals.parquet"),
        motion=fitted_results("motion.parquet"),
        arm=arm_file,
        rotors=parameter("rotor_inertia.json"),
        code=code("identify_model"),
    output:
        arm=parameter("arm.yaml"),
        urdf=parameter("arm.urdf"),
        summary=parameter("identification.json"),
    log:
        f"{RESULTS}/logs/identify_model/{{robot}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/identify_model/{{robot}}.tsv"
    params:
        **SETTINGS.lowpass.motion.model_dump(),
        recordings=fitted_on,
        gravities=fitted_gravities,
    script:
        "../scripts/identify_model.py"


rule fit_friction:
    input:
        signals=fitted_results("signals.parquet"),
        motion=fitted_results("motion.parquet"),
        torques=fitted_results("torques.parquet"),
        quality=fitted_results("quality.json"),
        arm=parameter("arm.yaml"),
        code=code("fit_friction"),
    output:
        friction=parameter("friction.json"),
    log:
        f"{RESULTS}/logs/fit_friction/{{robot}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/fit_friction/{{robot}}.tsv"
    params:
        **SETTINGS.lowpass.currents.model_dump(),
        recordings=fitted_on,
        terms=SETTINGS.friction.terms,
    script:
        "../scripts/fit_friction.py"


rule estimate_payload:
    input:
        signals=result("signals.parquet"),
        motion=result("motion.parquet"),
        torques=result("torques.parquet"),
        friction=parameter_of("friction.json"),
        arm=parameter_of("arm.yaml"),
        code=code("estimate_payload"),
    output:
        payload=result("payload.json"),
        regressor=result("load_regressor.parquet"),
    log:
        f"{RESULTS}/logs/estimate_payload/{{recording}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/estimate_payload/{{recording}}.tsv"
    params:
        **SETTINGS.lowpass.currents.model_dump(),
        recording="{recording}",
        gravity=gravity_of,
    script:
        "../scripts/estimate_payload.py"


rule predict_currents:
    input:
        signals=result("signals.parquet"),
        motion=result("motion.parquet"),
        torques=result("torques.parquet"),
        load=result("torques.json"),
        payload=result("payload.json"),
        regressor=result("load_regressor.parquet"),
        unloaded=results_of_fitted("payload.json"),
        friction=parameter_of("friction.json"),
        arm=parameter_of("arm.yaml"),
        quality=result("quality.json"),
        code=code("predict_currents"),
    output:
        currents=result("currents.parquet"),
        summary=result("currents.json"),
    log:
        f"{RESULTS}/logs/predict_currents/{{recording}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/predict_currents/{{recording}}.tsv"
    params:
        **SETTINGS.lowpass.currents.model_dump(),
        recording="{recording}",
        role=lambda wildcards: recording_of(wildcards).role,
    script:
        "../scripts/predict_currents.py"
