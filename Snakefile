# The study, the rules, and what a run makes.
import os
import sys

from snakemake.exceptions import WorkflowError
from snakemake.utils import min_version

from ur5lib.workspace.places import WORKFLOW

# Snakemake puts these folders first, so that a user's pandas.py would hide the package.
sys.path.sort(key=lambda folder: folder in (str(WORKFLOW), os.getcwd()))

from ur5lib.errors import InputError
from ur5lib.jobs.syntax import keep_for_the_next_process
from ur5lib.workspace.extensions import take_up_all

try:
    take_up_all()  # before modules are imported that use them
except InputError as error:
    raise WorkflowError(str(error))

from ur5lib.jobs.snakemake_inside import given_studies
from ur5lib.study.loading import read_studies_as_data

min_version("9.0")
read_studies_as_data(given_studies(workflow))

# Paths in a study, raw/ and results/ are those of the working folder.
# A study given by --configfile stands alone: it inherits nothing from config.yaml.
if not given_studies(workflow):

    configfile: "config.yaml"


include: "workflow/rules/common.smk"
include: "workflow/rules/stand.smk"


for rules_of_topic in sorted(PACKAGE.glob("topics/*/rules.smk")):

    include: str(rules_of_topic)


include: "workflow/rules/steps.smk"
include: "workflow/rules/report.smk"
include: "workflow/rules/cluster.smk"


keep_for_the_next_process()


onsuccess:
    list_unreadable()
    if Path(f"{RESULTS}/report.html").exists():
        print(f"report: {RESULTS}/report.html, {RESULTS}/report.pdf")


onerror:
    list_unreadable()
    if FAILED:
        print(f"\n{len(FAILED)} failed:", *FAILED, sep="\n")


# Intermediate tables are results too: deleted ones are made again.
rule all:
    input:
        rules.write_report.output,
        outputs_in(""),


# A report shows the figures of a few recordings; `snakemake figures` draws those of all.
rule figures:
    input:
        lambda wildcards: expand(rules.draw_figures.output, recording=RECORDINGS),
