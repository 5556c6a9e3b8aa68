# The study, the rules, and what a run makes.
from snakemake.utils import min_version

min_version("9.0")

# A study given by --configfile stands alone: it inherits nothing from config.yaml.
if not workflow.overwrite_configfiles:

    configfile: "config.yaml"


# Steps run in .venv; only `--sdm apptainer` uses this, for an image with requirements.lock in it.
container: "docker://python:3.11"


include: "workflow/rules/common.smk"
include: "workflow/rules/stand.smk"
include: "workflow/rules/recordings.smk"
include: "workflow/rules/signals.smk"
include: "workflow/rules/dynamics.smk"
include: "workflow/rules/identification.smk"
include: "workflow/rules/force.smk"
include: "workflow/rules/report.smk"


# Intermediate tables are results too: what is deleted is made again.
rule all:
    input:
        rules.write_report.output,
        rules.make_tables.output,
        TRUTH,
        SIMULATED_FILES,
        rules.draw_filters.output,
        expand(rules.draw_friction.output, robot=ROBOTS),
        expand(rules.draw_figures.output, recording=RECORDINGS),
        expand(rules.detect_contacts.output, recording=RECORDINGS),
        expand(rules.set_threshold.output, robot=ROBOTS),
        expand(rules.compare_forces.output, recording=RECORDINGS),
        expand(rules.estimate_forces.output, recording=RECORDINGS),
        expand(rules.fit_residuals.output, robot=ROBOTS),
        expand(rules.rebuild_forces.output, recording=RECORDINGS),
        expand(rules.estimate_payload.output, recording=VALIDATED),
        expand(rules.predict_currents.output, recording=RECORDINGS),
        expand(rules.fit_friction.output, robot=ROBOTS),
        expand(rules.compute_torques.output, recording=RECORDINGS),
        expand(rules.compute_kinematics.output, recording=RECORDINGS),
        expand(rules.identify_model.output, robot=ROBOTS),
        expand(rules.fit_rotor_inertia.output, robot=ROBOTS),
        expand(rules.estimate_gains.output, recording=RECORDINGS),
        expand(rules.compare_accelerations.output, recording=RECORDINGS),
        expand(rules.smooth_motion.output, recording=RECORDINGS),
        expand(rules.calibrate_imu.output, robot=ROBOTS),
        expand(rules.filter_signals.output, recording=RECORDINGS),
        expand(rules.align_signals.output, recording=RECORDINGS),
        expand(rules.repair_frames.output, recording=RECORDINGS),
